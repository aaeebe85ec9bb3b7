//! An arm under control, at a fixed rate, beside what it was asked to do.
//!
//! A [`Plant`] is an arm with friction, drives and encoders, integrated with error control between
//! the ticks of a controller by some [`Law`]. What a controller knows of the arm is a [`Knowledge`]: a model
//! that was reconstructed ([`Learned`]) or, to compare with, the truth. [`track()`] lets the one
//! drive the other along a desired motion; [`record()`] makes the log a model is learned from.
//!
//! ```
//! use torquewise_sim::control::{Gains, Law, Periodic, Plant, mean_inertia, periodic, track};
//! use torquewise_sim::Arm;
//!
//! let plant = Plant::ideal(Arm::builtin("planar-2")?);
//! let wanted = periodic(&plant.arm, &Periodic { seconds: 2.0, ..Periodic::default() })?;
//! let gains = Gains::critically_damped(10.0, &mean_inertia(&plant, &wanted)?);
//! let rms = |law| -> Result<Vec<f64>, torquewise_sim::SimError> {
//!     Ok(track(&plant, law, &plant, &gains, &wanted)?.rms_error(0.0))
//! };
//! assert!(rms(Law::Controller2)?[0] < 0.01 * rms(Law::Pid)?[0]);
//! # Ok::<(), torquewise_sim::SimError>(())
//! ```

mod integrate;
pub mod plant;
mod moving;
pub mod reference;
pub mod knowledge;
pub mod gains;
pub mod controller;
pub mod record;

pub use controller::{Law, Run, Runs, Tracking, compare, track};
pub use gains::{Gains, mean_inertia};
pub use knowledge::{Knowledge, Learned, is_of_joints};
pub use plant::{Actuator, Plant, Sensors, each};
pub use record::record;
pub use reference::{Periodic, periodic};
