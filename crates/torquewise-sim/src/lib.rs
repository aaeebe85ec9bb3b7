//! Simulated arms: rigid-body dynamics with friction and noise, motions to record, and the loop closed.
//!
//! An [`Arm`] comes from a URDF, from a table of Denavit–Hartenberg rows or by name. It answers
//! with torque, mass matrix, acceleration and energy, and [`simulate()`] moves it to make a log
//! whose equations are known. Nothing that learns from logs may see this crate.
//!
//! ```
//! use torquewise_sim::{Arm, MotionPlan, Noise, add_noise, simulate};
//!
//! let arm = Arm::builtin("puma560-3")?;
//! let hold = arm.gravity_torque(&[0.0, 0.5, -1.0]);
//! assert!(hold[1].abs() > hold[0].abs(), "the waist carries no weight");
//!
//! let clean = simulate(&arm, &MotionPlan { seconds: 2.0, ..MotionPlan::default() })?;
//! let measured = add_noise(&clean.motion, &Noise::case(2)?, 7)?;
//! assert_eq!((measured.n_rows(), measured.n_joints()), (500, 3));
//! # Ok::<(), torquewise_sim::SimError>(())
//! ```

pub mod error;
mod random;
mod state;
mod spatial;
pub mod arm;
pub mod dh;
pub mod urdf;
pub mod arms;
pub mod rigid_body;
pub mod friction;
pub mod plan;
mod trajectory;
pub mod simulate;
pub mod noise;
pub mod excite;
pub mod control;

pub use arm::{Arm, JointLimits};
pub use arms::{ArmSummary, arms};
pub(crate) use control::knowledge::{Knowledge, sum};
pub(crate) use control::plant::Plant;
pub use error::{Result, SimError};
pub(crate) use error::{check_between, check_joints};
pub(crate) use excite::limits::Bounds;
pub(crate) use excite::part::{Part, States, Sweep};
pub use friction::{Friction, Stribeck};
pub use noise::{Noise, add_noise};
pub use plan::{MotionKind, MotionPlan};
pub(crate) use random::{between, direction, log_between, normal};
pub use simulate::{SimulatedLog, Simulation, simulate};
pub use spatial::Body;
pub(crate) use spatial::{Pose, placement, pose, shifted_turned};
pub(crate) use state::State;
pub use urdf::{UrdfChain, UrdfJoint};
