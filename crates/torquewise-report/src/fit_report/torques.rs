//! Findings → torque charts: measured and predicted, joint by joint.

use crate::fit_report::Findings;
use crate::fit_report::clock::{self, Clock};
use crate::html::number::significant;
use crate::html::{Axis, Chart, Colour, Item, Mark, Section, Series};
use torquewise_identify::Diagnosis;

/// Charts of time with this word share their zoom.
pub(crate) const LINK: &str = "time";

/// One chart per joint, measured torque behind the predicted one.
pub(crate) fn section(findings: &Findings<'_>) -> Section {
    let mut items = vec![Item::Text(
        "Drag across a chart to zoom in, double-click to see all again; all charts over time \
         follow."
            .into(),
    )];
    items.extend(charts(findings.diagnosis, LINK));
    Section { heading: "Torque".into(), items }
}

/// One chart per joint of what a diagnosis looked at; charts of one `link` share their zoom.
pub(crate) fn charts(diagnosis: &Diagnosis, link: &str) -> Vec<Item> {
    let clock = Clock::new(diagnosis.trace.motion.t());
    let joints = 0..diagnosis.scores.joints.len();
    joints.map(|joint| Item::Chart(chart(diagnosis, &clock, joint, link))).collect()
}

fn chart(diagnosis: &Diagnosis, clock: &Clock, joint: usize, link: &str) -> Chart {
    let trace = &diagnosis.trace;
    let score = &diagnosis.scores.joints[joint];
    let measured = trace.motion.tau().map(|tau| {
        let points = clock.curve(|row| tau[(row, joint)]);
        Series::new("measured", Mark::BroadLine, Colour::Measured, points)
    });
    let predicted = Series::line("predicted", clock.curve(|row| trace.tau_hat[(row, joint)]));
    Chart {
        title: format!("{}, NRMSE {} %", score.name, significant(score.nrmse_percent, 3)),
        x: Axis::named(clock::LABEL),
        y: Axis::named("torque [N·m]"),
        series: measured.into_iter().chain([predicted]).collect(),
        linked: Some(link.into()),
        ..Chart::default()
    }
}
