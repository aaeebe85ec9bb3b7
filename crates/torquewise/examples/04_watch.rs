//! Six joints, watched while it is learned: progress, warnings, and the numbers as JSON.

use std::error::Error;
use std::ops::ControlFlow;
use torquewise::dynamics::{Arm, MotionPlan, simulate};
use torquewise::{Event, Fit, FitOptions, FrictionKind};

fn main() -> Result<(), Box<dyn Error>> {
    let plan = MotionPlan { seconds: 60.0, rate: 50.0, seed: 1, ..MotionPlan::default() };
    let motion = simulate(&Arm::builtin("generic-4")?, &plan)?.motion;

    let watch = |event: Event| {
        if let Event::Stage(stage) = event {
            println!("{stage:?}");
        }
        // `Break` would stop the fit with `Error::Interrupted`.
        ControlFlow::Continue(())
    };
    // Rows without friction and noise: the geometry of the arm is learned all the same.
    let options = FitOptions {
        library: Some(torquewise::Library::Chain),
        friction: Some(FrictionKind::None),
        ..FitOptions::default()
    };
    let fit = Fit::new(&motion).options(options).observer(&watch).run()?;

    fit.warnings.iter().for_each(|warning| println!("warning: {warning}"));
    println!("{}", serde_json::to_string_pretty(&fit.summary()?)?);
    Ok(())
}
