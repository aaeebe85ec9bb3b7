//! Torque models as source code: C, Rust, Python, LaTeX, an FMU, a ROS 2 package; and as robots: URDF, MJCF,
//! joints for Isaac Lab.
//!
//! A [`Program`] holds the functions of a model as one graph of operations, each sine and cosine
//! once and common factors shared; one printer per language writes it down. Nothing here touches a
//! file or runs a compiler: everything is returned as text or bytes.
//!
//! ```
//! use torquewise_export::{Precision, Program, to_c};
//! use torquewise_model::{Form, Model, Term, Trig, Weighted};
//!
//! let term = Term::one(1).times(Trig::Sin, 0, 1, 1);
//! let weighted = Weighted::new(term, 3.3);
//! let pendulum = Model {
//!     joints: vec!["pivot".into()],
//!     form: Form::Torque(vec![vec![weighted]]),
//!     ..Model::default()
//! };
//! let code = to_c(&Program::of(&pendulum)?, "pendulum", Precision::Double)?;
//! assert!(code.contains("tau[0] = 3.3*s1;"));
//! # Ok::<(), torquewise_export::ExportError>(())
//! ```

pub mod error;
mod graph;
pub mod cost;
mod derivative;
mod harmonics;
mod polynomial;
mod parts;
mod lower;
mod base_chain;
mod recursion;
mod ways;
mod momentum;
pub mod program;
mod text;
mod template;
pub mod c;
pub mod rust;
pub mod python;
pub mod latex;
pub mod vectors;
pub mod fmu;
pub mod ros;
mod robot;
mod near;
pub mod urdf;

pub use c::to_c;
pub use cost::{Cost, torque_costs};
pub use error::{ExportError, Result};
pub use fmu::{fmu_archive, fmu_sources};
pub(crate) use graph::{Function, Graph, Id, Input, Node};
pub use latex::to_latex;
pub(crate) use program::Role;
pub use program::{Precision, Program, Quantity};
pub use python::to_python;
pub use ros::ros_package;
pub use rust::to_rust;
pub(crate) use template::filled;
pub use urdf::{RobotFile, onto_urdf, to_isaac_lab, to_mjcf, to_urdf};
pub use vectors::test_vectors;
