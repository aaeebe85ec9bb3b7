//! Friction beside rigid-body dynamics: chosen on held-out rows, read as engineers read it.

use std::error::Error;
use torquewise::dynamics::{Arm, Friction, MotionPlan, Noise, SimulatedLog, add_noise};
use torquewise::model::shaft_friction::ShaftFriction;
use torquewise::{Fit, FitOptions, FrictionKind};

/// Coulomb and viscous friction of the two joints \[N·m, N·m·s/rad\].
const FRICTION: &str =
    "joint1 = { coulomb = 1.2, viscous = 0.8 }\njoint2 = { coulomb = 0.4, viscous = 0.3 }";

fn main() -> Result<(), Box<dyn Error>> {
    let arm = Arm::builtin("planar-2")?;
    let plan = MotionPlan { seconds: 120.0, rate: 100.0, seed: 1, ..MotionPlan::default() };
    let friction = Friction::from_toml(FRICTION, arm.joints())?;
    let log = SimulatedLog::new(&arm, &plan)?.with_friction(friction)?.whole()?;
    let log = add_noise(&log.motion, &Noise::case(2)?, 1)?;

    let options = FitOptions { friction: Some(FrictionKind::Linear), ..FitOptions::default() };
    let fit = Fit::new(&log).options(options).run()?;

    for shaft in ShaftFriction::all(&fit.model) {
        println!("{}: {}", shaft.name(), serde_json::to_string(&shaft.parameters())?);
    }
    Ok(())
}
