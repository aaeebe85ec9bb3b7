//! The results as one HTML page.

use crate::error::PaperError;
use crate::results::{Claim, Results, Study, Table, Verdict};
use torquewise_report::html::{Item, Page, Section};

/// What was done, for all experiments.
const SETUP: &str = "Training logs are positioning and sorting moves at 100 Hz: dwell, accelerate, \
    cruise, brake, dwell, all joints together. Torque and motion come from rigid-body dynamics; \
    white Gaussian noise is added to position, velocity and acceleration, each joint by its own \
    power, none to the torque. Each seed is another motion and other noise. Models are judged by \
    the torque of 20 s of smooth sines without noise, the same for all. An error is the RMSE of \
    the torque of a joint over the standard deviation of that torque, in percent; a range is that \
    of the seeds. The paper names neither its arm, nor the length of its logs, nor its \
    implementation of SINDy; its experiments on a real arm are simulated.";

/// The page as one HTML text that needs no other file and no network.
///
/// # Errors
/// [`PaperError::Report`] if it cannot be written.
pub fn page(results: &Results) -> Result<String, PaperError> {
    let count = |verdict| results.claims().filter(|claim| claim.verdict == verdict).count();
    let lead = format!(
        "Every simulated experiment of D. Guo, J. Xu and S. Zhang, “Stepwise Model Reconstruction \
         of Robotic Manipulator Based on Data-Driven Method”, done again on the arm {}, and those \
         that it leaves open. Of its claims {} hold, {} hold in part and {} are contradicted.",
        results.settings.arm,
        count(Verdict::Holds),
        count(Verdict::HoldsInPart),
        count(Verdict::Contradicted),
    );
    let mut sections = vec![Section { heading: "What holds".into(), items: vec![claims(results)] }];
    sections[0].items.insert(0, Item::Text(SETUP.into()));
    sections.extend(results.studies.iter().map(section));
    let title = "Stepwise model reconstruction, simulated again".into();
    Ok(Page { title, lead, sections, ..Page::default() }.to_html()?)
}

fn claims(results: &Results) -> Item {
    let mut table = Table::new(
        "The claims of the paper, judged.",
        "the paper says;where;measured here;verdict",
    );
    for Claim { claim, source, measured, verdict } in results.claims() {
        let words = [*claim, source, measured, verdict.name()];
        table.push(words.map(Into::into));
    }
    Item::Table(table.to_html())
}

fn section(study: &Study) -> Section {
    let mut items = Vec::new();
    if !study.text.is_empty() {
        items.push(Item::Text(study.text.into()));
    }
    for figure in &study.figures {
        items.push(Item::Text(figure.caption.clone()));
        if figure.charts.len() == 2 {
            items.push(Item::Charts(figure.charts.clone()));
        } else {
            items.extend(figure.charts.iter().map(|chart| Item::Charts(vec![chart.clone()])));
        }
    }
    let tables = study.tables.iter().chain(&study.timed.tables);
    items.extend(tables.map(|table| Item::Table(table.to_html())));
    Section { heading: study.heading.into(), items }
}
