//! From steps to Fig. 10: torque predicted after each of them.

use crate::figures::Figure;
use crate::figures::looks::{after_step, torque_chart};
use crate::results::Results;
use crate::study::cases::Prediction;

/// The torque after each step of the first method; `None` if no case was judged.
pub(crate) fn figure(results: &Results) -> Option<Figure> {
    let (steps, case) = (results.steps.first()?, results.case(2)?);
    let Prediction { t, needed, .. } = &case.prediction;
    let joints = 0..needed.len();
    let chart = |joint: usize| {
        let after = steps.torque.iter().zip(&steps.names).enumerate().map(|(step, own)| {
            let (label, colour) = after_step(step, own.1);
            (label, colour, own.0[joint].as_slice())
        });
        let title = format!("Joint {}", joint + 1);
        torque_chart(title, t, ("needed", &needed[joint]), after, "steps")
    };
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
        charts: joints.map(chart).collect(),
        columns: 1,
    })
}
