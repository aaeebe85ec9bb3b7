//! Closed-form torque models of robot arms: terms, weights, prediction, files.
//!
//! A [`Model`] is plain data: for each joint a sum of [`Term`]s with coefficients, or one set of
//! energies M(q), V(q) that all joints share, and the [`friction`] of their shafts. [`Torque`]
//! evaluates it, [`checks`] asks whether it is physics, [`print`](mod@print) writes it down,
//! [`file`](mod@file) keeps it.

pub mod error;
pub mod number;
pub mod term;
pub mod friction;
pub mod harmonic;
pub mod energy;
pub mod library;
pub mod expansion;
mod weighted;
pub mod rigid_chain;
pub mod units;
pub mod model;
pub mod shaft_friction;
mod links;
mod products;
pub mod torque;
pub mod momentum_observer;
pub mod rollout;
pub mod checks;
pub mod file;
pub mod selection;
pub mod print;
pub mod learned;
pub mod verdict;

pub use checks::{Checks, check};
pub use energy::{EnergyTerm, Place};
pub use error::ModelError;
pub use file::{from_json, to_json};
pub use friction::{Direction, FrictionLaw, FrictionTerm};
pub use model::{Choice, Form, GeometryFound, Model, Stage, Training, Weighted};
pub use number::number;
pub use rigid_chain::{Drive, JointKind, JointKinds, LinkFrame, RigidChain, RobotNames};
pub use term::{Factor, Kind, Sum, Term, Trig};
pub use torque::{Parts, Torque};
pub(crate) use weighted::LEAST_T;
