//! Charts of torque: measured and predicted, joint by joint.

use crate::fit_report::clock;
use crate::{Chart, Clock, Colour, Findings, Item, Mark, Section, Series, significant};
use faer::Mat;
use torquewise_identify::Diagnosis;
use torquewise_model::{Torque, units};

/// Charts of time with this word share their zoom.
pub(crate) const LINK: &str = "time";

pub(crate) fn section(findings: &Findings<'_>) -> Section {
    let mut items = vec![Item::Text(
        "Drag across a chart to zoom in, double-click to see all again; all charts over time \
         follow."
            .into(),
    )];
    let fitted = charts(findings, findings.diagnosis, LINK);
    match findings.test {
        None => items.push(fitted),
        Some(test) => {
            let summary = "On the fitted log".into();
            items.push(charts(findings, test, "time of the test log"));
            items.push(Item::Details { summary, items: vec![fitted] });
        }
    }
    items.extend(parts(findings));
    Section { heading: "Torque".into(), items }
}

/// One chart per joint of what a diagnosis looked at; charts of one `link` share their zoom.
fn charts(findings: &Findings<'_>, diagnosis: &Diagnosis, link: &str) -> Item {
    let model = &findings.found.model;
    let parts = Torque::new(model).parts(&diagnosis.trace.motion).ok();
    let clock = Clock::new(diagnosis.trace.motion.t());
    let charts = (0..diagnosis.scores.joints.len()).map(|joint| {
        let rubs = model.friction.iter().any(|law| law.term.acts_on(joint));
        let curve = |tau: &Mat<f64>| clock.curve(|row| tau[(row, joint)]);
        let friction = parts.as_ref().filter(|_| rubs).map(|parts| {
            Series::new("friction", Mark::Line, Colour::Series(1), curve(&parts.friction))
        });
        let (trace, score) = (&diagnosis.trace, &diagnosis.scores.joints[joint]);
        let measured = trace.motion.tau().map(|tau| {
            let points = clock.curve(|row| tau[(row, joint)]);
            Series::new("measured", Mark::BroadLine, Colour::Measured, points)
        });
        let predicted = match &trace.bounds {
            None => Series::line("predicted", curve(&trace.tau_hat)),
            Some([low, high]) => Series {
                spread: curve(low).iter().zip(curve(high)).map(|(a, b)| [a[1], b[1]]).collect(),
                ..Series::line("predicted, 95 % interval", curve(&trace.tau_hat))
            },
        };
        let title = format!("{}, NRMSE {} %", score.name, significant(score.nrmse_percent, 3));
        let series = measured.into_iter().chain([predicted]).chain(friction).collect();
        let label = units::unit(model.kinds().of(joint), "torque [N·m]");
        let chart = Chart::over(title, [clock::LABEL, &label], series);
        Chart { linked: Some(link.into()), ..chart }
    });
    Item::Charts(charts.collect())
}

/// What the predicted torque is made of, a chart per joint, folded.
fn parts(findings: &Findings<'_>) -> Option<Item> {
    let (model, trace) = (&findings.found.model, &findings.judged().trace);
    let parts = Torque::new(model).parts(&trace.motion).ok()?;
    let clock = Clock::new(trace.motion.t());
    let named = [
        ("inertia", &parts.inertia),
        ("Coriolis", &parts.coriolis),
        ("gravity", &parts.gravity),
        ("friction", &parts.friction),
    ];
    let chart = |joint: usize| {
        let rubs = model.friction.iter().any(|law| law.term.acts_on(joint));
        let own = named.iter().take(if rubs { named.len() } else { named.len() - 1 });
        let series = own.enumerate().map(|(k, (name, part))| {
            let points = clock.curve(|row| part[(row, joint)]);
            Series::new(*name, Mark::Line, Colour::Series(k), points)
        });
        let label = units::unit(model.kinds().of(joint), "torque [N·m]");
        let chart = Chart::over(&model.joints[joint], [clock::LABEL, &label], series.collect());
        Chart { linked: Some("time of the parts".into()), ..chart }
    };
    let summary = "Its parts: inertia, Coriolis, gravity, friction".into();
    let charts = (0..model.n_joints()).map(chart).collect();
    Some(Item::Details { summary, items: vec![Item::Charts(charts)] })
}
