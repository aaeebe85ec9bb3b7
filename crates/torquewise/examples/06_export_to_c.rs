//! A learned model as C99 for a controller, with its cost.

use std::error::Error;
use torquewise::Fit;
use torquewise::dynamics::{Arm, MotionPlan, simulate};
use torquewise::export::{Precision, Program, Quantity, to_c};

fn main() -> Result<(), Box<dyn Error>> {
    let plan = MotionPlan { seconds: 60.0, rate: 100.0, seed: 1, ..MotionPlan::default() };
    let fit = Fit::new(&simulate(&Arm::builtin("planar-2")?, &plan)?.motion).run()?;

    let program = Program::of(&fit.model)?;
    let source = to_c(&program, "arm", Precision::Double)?;

    let cost = program.cost(Quantity::Torque);
    println!("{source}");
    println!("/* {} operations, {} functions a call */", cost.operations, cost.functions);
    Ok(())
}
