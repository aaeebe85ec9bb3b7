//! The plant and the desired motion of `control`, from the command line.

use crate::arguments::{Word, choice};
use crate::{CliError, Result};
use clap::Args;
use std::path::PathBuf;
use torquewise::control::{Actuator, Periodic, Plant, Sensors, each, periodic};
use torquewise::dynamics::{Arm, Friction, MotionKind, MotionPlan, simulate};
use torquewise::motion::Motion;

/// What is wanted of the arm.
#[derive(Args, Debug)]
#[command(next_help_heading = "Motion")]
pub(crate) struct MotionArguments {
    /// Motion that is wanted
    #[arg(long, value_parser = choice(&TRAJECTORIES), default_value = "periodic")]
    // Named in full, since clap takes a plain Option for one that may be left out.
    trajectory: std::option::Option<MotionKind>,
    /// Its length in seconds
    #[arg(long, value_name = "S", default_value_t = Periodic::default().seconds)]
    seconds: f64,
    /// Rate of the controllers in Hz
    #[arg(long, value_name = "HZ", default_value_t = Periodic::default().rate)]
    rate: f64,
    /// Seed of the motion
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Periodic motion: length of a period in seconds
    #[arg(long, value_name = "S", default_value_t = Periodic::default().period)]
    period: f64,
    /// Periodic motion: speed of a joint in rad/s at most
    #[arg(long, value_name = "V", default_value_t = Periodic::default().speed)]
    speed: f64,
    /// Periodic motion: acceleration of a joint in rad/s² at most
    #[arg(long, value_name = "A", default_value_t = Periodic::default().acceleration)]
    acceleration: f64,
}

/// None is for periodic motion.
const TRAJECTORIES: [Word<Option<MotionKind>>; 3] = [
    ("periodic", "Smooth, at rest after each period", None),
    ("sines", "Smooth sums of sines", Some(MotionKind::Sines)),
    (
        "moves",
        "Positioning and sorting: dwell, accelerate, cruise, brake, dwell",
        Some(MotionKind::Moves),
    ),
];

impl MotionArguments {
    pub(crate) fn wanted(&self, arm: &Arm) -> Result<Motion> {
        let Self { seconds, rate, seed, period, speed, acceleration, .. } = *self;
        Ok(match self.trajectory {
            None => periodic(arm, &Periodic { seconds, period, rate, speed, acceleration, seed })?,
            Some(kind) => {
                let given = Periodic { period, speed, acceleration, ..Periodic::default() };
                if given != Periodic::default() {
                    let what = "--period, --speed and --acceleration are of periodic motion: leave \
                                them out, or --trajectory";
                    return Err(CliError::Usage(what.to_owned()));
                }
                simulate(arm, &MotionPlan { kind, seconds, rate, seed })?.motion
            }
        })
    }
}

/// What the arm is made of, beside links.
#[derive(Args, Debug)]
#[command(next_help_heading = "Plant")]
pub(crate) struct PlantArguments {
    /// Friction of the joints, .toml: [JOINT] with coulomb, stiction, speed, viscous, [backward];
    /// none without, that of a .urdf does not count
    #[arg(long, value_name = "FILE")]
    pub(crate) friction: Option<PathBuf>,
    /// Joints of a .urdf to hold at 0, their mass kept
    #[arg(long, value_name = "JOINT", value_delimiter = ',')]
    pub(crate) lock: Vec<String>,
    /// Inertia of the rotors as felt at the joints in kg·m², one for all or one each
    #[arg(long, value_name = "J", value_delimiter = ',')]
    rotor: Vec<f64>,
    /// Largest torque of the drives in N·m, one for all or one each [default: none]
    #[arg(long, value_name = "TAU", value_delimiter = ',')]
    torque_limit: Vec<f64>,
    /// Time from command to torque in seconds
    #[arg(long, value_name = "S", default_value_t = 0.0)]
    delay: f64,
    /// Counts of the encoders to a turn; 0 for exact positions
    #[arg(long, value_name = "N", default_value_t = 1 << 20)]
    encoder: u32,
    /// Noise of the measured position in rad, its standard deviation
    #[arg(long, value_name = "RAD", default_value_t = 0.0)]
    noise: f64,
    /// Cut-off in Hz of the velocity, which is a filtered difference of positions
    #[arg(long, value_name = "HZ", default_value_t = Sensors::default().cutoff)]
    velocity_cutoff: f64,
    /// Seed of the noise
    #[arg(long, value_name = "SEED", default_value_t = 0)]
    noise_seed: u64,
}

impl PlantArguments {
    pub(crate) fn plant(&self, arm: Arm, friction: Friction) -> Result<Plant> {
        let n = arm.n_joints();
        let arm = if self.rotor.is_empty() { arm } else { arm.with_rotors(&each(&self.rotor, n))? };
        let drive = Actuator::new(n, &self.torque_limit, self.delay);
        let Self { noise, velocity_cutoff: cutoff, noise_seed: seed, .. } = *self;
        let sensors = Sensors { noise, cutoff, seed, ..Sensors::of_counts(self.encoder) };
        let plant = Plant { friction, drive, sensors, ..Plant::ideal(arm) };
        plant.check()?;
        Ok(plant)
    }
}
