//! From an arm with friction under control to Fig. 10 and 11, and its Stribeck curves.

use crate::figures::Figure;
use crate::figures::looks::{after_step, torque_chart};
use crate::study::control::{ControlResults, DEAD_ZONE};
use torquewise_report::html::{Axis, Chart, Colour, Guide, Mark, Series};

/// Friction, torque after each step, tracking.
pub(crate) fn figures(results: &ControlResults) -> Vec<Figure> {
    vec![friction(results), steps(results), tracking(results)]
}

fn friction(results: &ControlResults) -> Figure {
    let charts = results.friction.iter().enumerate().map(|(joint, curve)| {
        let points =
            |f: &[f64]| curve.speed.iter().zip(f).map(|(&v, &f)| [v, f]).collect::<Vec<_>>();
        Chart {
            title: format!("Joint {}: friction", joint + 1),
            x: Axis::named("speed [rad/s]"),
            y: Axis::named("friction [N·m]"),
            series: vec![
                Series::new("plant", Mark::BroadLine, Colour::Measured, points(&curve.truth)),
                Series::new("model", Mark::Line, Colour::Series(0), points(&curve.learned)),
            ],
            guides: [-DEAD_ZONE, DEAD_ZONE].map(|at| Guide::at_x(at, "")).to_vec(),
            ..Chart::default()
        }
    });
    Figure {
        name: "fig10_friction".into(),
        title: "Stribeck friction (17), true and learned".into(),
        caption: format!(
            "Friction that nobody told the learner, in both directions. Between the dashed lines \
             at ±{DEAD_ZONE} rad/s it is not judged: a model smooths its reversal there."
        ),
        charts: charts.collect(),
        columns: 3,
    }
}

fn steps(results: &ControlResults) -> Figure {
    let charts = (0..results.needed.len()).map(|joint| {
        let after = results.steps.iter().enumerate().map(|(place, step)| {
            let (label, colour) = after_step(place, &step.name);
            (label, colour, step.torque[joint].as_slice())
        });
        let title = format!("Joint {}: torque", joint + 1);
        torque_chart(title, &results.t, ("plant", &results.needed[joint]), after, "control")
    });
    Figure {
        name: "fig10_control".into(),
        title: "Fig. 10, simulated with friction: torque of a periodic motion".into(),
        caption: "What the motion of the next figure takes, and what is predicted of it with each \
                  part of the model: what very slow motion shows, what uniform motion adds, what \
                  variable motion adds."
            .into(),
        charts: charts.collect(),
        columns: 1,
    }
}

/// Controllers that are drawn.
const DRAWN: [&str; 3] = ["PID", "controller 1", "controller 2"];

fn tracking(results: &ControlResults) -> Figure {
    let charts = (0..results.needed.len()).map(|joint| {
        let drawn = results.tracking.iter().filter(|found| DRAWN.contains(&found.name.as_str()));
        let series = drawn.enumerate().map(|(place, found)| {
            let errors = results.t.iter().zip(&found.error[joint]);
            let points = errors.map(|(&t, &error)| [t, 1e3 * error]).collect();
            Series::new(&found.name, Mark::Line, Colour::Series(place), points)
        });
        Chart {
            title: format!("Joint {}: tracking error", joint + 1),
            x: Axis::named("time [s]"),
            y: Axis::named("error [mrad]"),
            series: series.collect(),
            linked: Some("control".into()),
            ..Chart::default()
        }
    });
    Figure {
        name: "fig11_tracking".into(),
        title: "Fig. 11, simulated: tracking with the same gains".into(),
        caption: "Position error of PID, of controller 1 with what slow motion shows (18), and of \
                  controller 2 with the whole model (19), at 1 kHz on the arm with friction, \
                  encoders and a drive that is 1 ms late. The first period begins with an empty \
                  integral and does not count."
            .into(),
        charts: charts.collect(),
        columns: 1,
    }
}
