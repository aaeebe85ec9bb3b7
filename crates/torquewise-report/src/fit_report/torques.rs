//! Findings → torque charts: measured and predicted, joint by joint.

use crate::fit_report::Findings;
use crate::fit_report::clock::{self, Clock};
use crate::html::number::significant;
use crate::html::{Axis, Chart, Colour, Item, Mark, Section, Series};

/// Charts of time with this word share their zoom.
pub(crate) const LINK: &str = "time";

/// One chart per joint, measured torque behind the predicted one.
pub(crate) fn section(findings: &Findings<'_>) -> Section {
    let clock = Clock::new(findings.diagnosis.trace.motion.t());
    let mut items = vec![Item::Text(
        "Drag across a chart to zoom in, double-click to see all again; all charts over time \
         follow."
            .into(),
    )];
    items.extend((0..findings.n_joints()).map(|joint| Item::Chart(chart(findings, &clock, joint))));
    Section { heading: "Torque".into(), items }
}

fn chart(findings: &Findings<'_>, clock: &Clock, joint: usize) -> Chart {
    let trace = &findings.diagnosis.trace;
    let score = &findings.diagnosis.scores.joints[joint];
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
        linked: Some(LINK.into()),
        ..Chart::default()
    }
}
