//! From steps to Fig. 10: torque predicted after each of them.

use crate::figures::Figure;
use crate::figures::cases::range;
use crate::results::Results;
use crate::study::cases::Prediction;
use crate::study::steps::StepResults;
use torquewise_report::html::{Axis, Chart, Colour, Mark, Series};

/// The torque after each step of the first method; `None` if no case was judged.
pub(crate) fn figure(results: &Results) -> Option<Figure> {
    let (steps, case) = (results.steps.first()?, results.case(2)?);
    let joints = 0..case.prediction.needed.len();
    Some(Figure {
        name: "fig10_steps".into(),
        title: format!(
            "Fig. 10, simulated: torque after steps 1, 2 and 3 ({}, case 2)",
            steps.method.name()
        ),
        caption: format!(
            "The same motion, predicted with what is known after each step ({}, case 2). Step 1 \
             knows gravity; step 2 adds what depends on velocity; step 3 adds inertia, without \
             which no torque of a moving arm is right.",
            steps.method.name()
        ),
        charts: joints.map(|joint| chart(steps, &case.prediction, joint)).collect(),
        columns: 1,
    })
}

fn chart(steps: &StepResults, prediction: &Prediction, joint: usize) -> Chart {
    let t = &prediction.t;
    let line = |values: &[f64]| t.iter().zip(values).map(|(&t, &tau)| [t, tau]).collect();
    let needed = &prediction.needed[joint];
    let measured = Series::new("needed", Mark::BroadLine, Colour::Measured, line(needed));
    let after = steps.torque.iter().enumerate().map(|(step, torque)| {
        let label = format!("after step {}: {}", step + 1, steps.names[step]);
        let colour = [Colour::Series(5), Colour::Series(2), Colour::Series(1)][step.min(2)];
        Series::new(label, Mark::Line, colour, line(&torque[joint]))
    });
    Chart {
        title: format!("Joint {}", joint + 1),
        x: Axis::named("time [s]"),
        y: Axis { range: Some(range(needed)), ..Axis::named("torque [N·m]") },
        series: std::iter::once(measured).chain(after).collect(),
        linked: Some("steps".into()),
        ..Chart::default()
    }
}
