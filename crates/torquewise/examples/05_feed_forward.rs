//! A learned model in a controller: the loop closed at 1 kHz beside PID.

use std::error::Error;
use torquewise::Fit;
use torquewise::control::{Gains, Law, Learned, Periodic, Plant, mean_inertia, periodic, track};
use torquewise::dynamics::{Arm, MotionPlan, simulate};

fn main() -> Result<(), Box<dyn Error>> {
    let arm = Arm::builtin("planar-2")?;
    let plan = MotionPlan { seconds: 60.0, rate: 100.0, seed: 1, ..MotionPlan::default() };
    let fit = Fit::new(&simulate(&arm, &plan)?.motion).run()?;

    let plant = Plant::ideal(arm);
    let wanted = periodic(&plant.arm, &Periodic { seconds: 4.0, ..Periodic::default() })?;
    let gains = Gains::critically_damped(10.0, &mean_inertia(&plant, &wanted)?);
    let learned = Learned::new(&fit.model)?;
    for law in [Law::Pid, Law::Controller2] {
        let errors = track(&plant, law, &learned, &gains, &wanted)?.rms_error(1.0);
        println!("{law:?}: {:.2e} rad of the first joint", errors[0]);
    }
    Ok(())
}
