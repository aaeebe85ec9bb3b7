//! Motions that a torque model can be reconstructed from, planned within the limits of an arm.
//!
//! [`excite()`] plans three recordings, one for each step of the method: poses held, constant
//! speeds, accelerated motion. Each is made of parts that are chosen for what they tell about the
//! coefficients. [`joint_trajectory`] writes a recording for ROS 2.
//!
//! ```
//! use torquewise_sim::Arm;
//! use torquewise_sim::excite::{ExcitationPlan, Wishes, excite, limits};
//!
//! let limits = limits(&Arm::builtin("planar-2")?, &Wishes::default())?;
//! let seconds = [10.0, 40.0, 30.0];
//! let plan = ExcitationPlan { seconds, tries: 2, ..ExcitationPlan::default() };
//! let found = excite(&limits, None, &plan, &mut |_, _| {})?;
//! assert!(found.recordings.iter().zip(plan.seconds).all(|(found, most)| found.seconds <= most));
//! assert!(found.peaks[2][0].velocity <= limits[0].planned.velocity);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod limits;
mod sines;
mod segment;
pub(crate) mod part;
mod library;
pub mod information;
pub mod recording;
pub mod torques;
mod design;
pub mod planner;
pub mod ros;

pub use crate::state::State;
pub use information::DesignCriterion;
pub use limits::{Bounds, JointValues, Limits, Wishes, limits};
pub use planner::{Excitation, ExcitationPlan, excite};
pub use recording::Planned;
pub use ros::{joint_trajectory, waypoints};
pub use torques::Torques;
