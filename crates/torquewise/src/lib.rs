//! From the motion log of a robot arm to its equations of motion.
//!
//! The front door: every part of the workspace under one name, and no logic of its own. Read
//! [`identify::reconstruct()`] first; it is the method on one page.
//!
//! ```
//! use torquewise::dynamics::{Arm, MotionPlan, simulate};
//! use torquewise::identify::{Plan, reconstruct, score};
//!
//! let arm = Arm::builtin("planar-2")?;
//! let log = simulate(&arm, &MotionPlan { seconds: 60.0, rate: 50.0, ..MotionPlan::default() })?;
//! let found = reconstruct(&log.motion, &Plan::default(), &mut |_| {})?;
//! assert!(score(&found.model, &log.motion)?.joints.iter().all(|joint| joint.r2 > 0.999));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub use torquewise_control as control;
pub use torquewise_diagnose as diagnose;
pub use torquewise_dynamics as dynamics;
pub use torquewise_excite as excite;
pub use torquewise_experiments as experiments;
pub use torquewise_export as export;
pub use torquewise_identify as identify;
pub use torquewise_logs as logs;
pub use torquewise_model as model;
pub use torquewise_motion as motion;
pub use torquewise_regression as regression;
pub use torquewise_report as report;
pub use torquewise_signals as signals;
pub use torquewise_stepwise as stepwise;
pub use torquewise_survey as survey;
