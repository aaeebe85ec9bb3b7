//! From a log file to a model file, in ten lines.

use std::error::Error;
use torquewise::{Fit, Log};

fn main() -> Result<(), Box<dyn Error>> {
    let folder = tempfile::tempdir()?;
    let [train, test] = recorded(folder.path())?;

    let fit = Fit::new(&Log::open(train)?).run()?;
    for joint in fit.evaluate(&Log::open(test)?)?.joints {
        println!("{}: {:.3} % of the torque is not explained", joint.name, joint.nrmse_percent);
    }
    println!("verdict: {}", fit.verdict());
    fit.model.save(folder.path().join("arm.json"))?;
    Ok(())
}

/// Two logs, as a robot would have recorded them.
fn recorded(folder: &std::path::Path) -> Result<[std::path::PathBuf; 2], Box<dyn Error>> {
    use torquewise::dynamics::{Arm, MotionPlan, Noise, add_noise, simulate};
    let files = ["train.csv", "test.csv"].map(|name| folder.join(name));
    for (file, seed) in files.iter().zip([1, 2]) {
        let plan = MotionPlan { seconds: 120.0, seed, ..MotionPlan::default() };
        let motion = simulate(&Arm::builtin("planar-2")?, &plan)?.motion;
        torquewise::logs::write_motion(file, &add_noise(&motion, &Noise::case(2)?, seed)?)?;
    }
    Ok(files)
}
