//! Chains of rigid bodies whose geometry is learned from motion and torque (E8).
//!
//! The energy library says what functions the torque of any arm may hold; for six joints these are
//! thousands. A chain of rigid bodies needs a few dozen numbers to say the same: where each joint
//! axis lies in its parent frame, and ten inertial parameters of each link. This crate learns both from
//! motion and torque alone.

pub mod error;
pub mod joint;
pub mod coupling;
pub mod geometry;
pub mod recursion;
pub mod inertia;
pub mod base_parameters;
pub mod feasible;
pub mod rows;
mod inertial_fit;
mod levenberg_marquardt;
pub mod search;
pub mod tangent;
pub mod usual_arm;

pub use coupling::Coupling;
pub(crate) use error::expect;
pub use error::{ChainError, Result};
pub use geometry::{Geometry, PER_BASE, Placement};
pub(crate) use inertial_fit::InertialFit;
pub use joint::{Functions, JointKind, JointKinds};
pub use recursion::{Kinematics, MotionState, Moved, PER_BODY};
pub use rows::ChainRows;
pub use search::{Chain, Search, refine, search};
pub use tangent::Tangent;
pub use usual_arm::UsualArm;
