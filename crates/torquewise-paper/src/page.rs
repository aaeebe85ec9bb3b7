//! The results as one HTML page.

use crate::{Claim, ClaimVerdict, PaperError, Results, Study};
use torquewise_report::html::Page;
use torquewise_report::{Heading, Item, Label, Section, Table};

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
        count(ClaimVerdict::Holds),
        count(ClaimVerdict::HoldsInPart),
        count(ClaimVerdict::Contradicted),
    );
    let setup = Study { heading: "What holds".into(), ..Study::described("setup", 0) };
    let mut sections = vec![section(&setup)];
    sections[0].items.push(claims(results));
    sections.extend(results.studies.iter().map(section));
    let title = "Stepwise model reconstruction, simulated again".into();
    Ok(Page { title, lead, sections, ..Page::default() }.to_html()?)
}

fn claims(results: &Results) -> Item {
    let headings = ["the paper says", "where", "measured here", "verdict"];
    let row = |claim: &Claim| {
        let Claim { claim, source, measured, verdict } = claim;
        [claim, source, measured, verdict.name()].map(Label::from).to_vec()
    };
    Item::Table(Table {
        caption: "The claims of the paper, judged.".into(),
        columns: headings.map(Heading::words).to_vec(),
        rows: results.claims().map(row).collect(),
    })
}

fn section(study: &Study) -> Section {
    let mut items = Vec::new();
    if !study.text.is_empty() {
        items.push(Item::Text(study.text.clone()));
    }
    for figure in &study.figures {
        items.push(Item::Text(figure.caption.clone()));
        let rows = figure.charts.chunks(figure.columns());
        items.extend(rows.map(|row| Item::Charts(row.to_vec())));
    }
    let tables = study.tables.iter().chain(&study.timed.tables);
    items.extend(tables.map(|table| Item::Table(table.to_html())));
    Section { heading: study.heading.clone(), items }
}
