//! From the motion log of a robot arm to its equations of motion.
//!
//! [`Log`] opens what was recorded, [`Fit`] turns it into a [`Model`], and [`evaluate()`] says how
//! well that predicts another log: all defaults, warnings and the verdict are here, and the command
//! line only translates. The modules are the parts it is made of.
//!
//! ```
//! use torquewise::dynamics::{Arm, MotionPlan, Noise, add_noise, simulate};
//! use torquewise::{Fit, Log};
//!
//! # let folder = tempfile::tempdir()?;
//! # let [train, test] = ["train.csv", "test.csv"].map(|name| folder.path().join(name));
//! let arm = Arm::builtin("planar-2")?;
//! for (file, seed) in [(&train, 1), (&test, 2)] {
//!     let plan = MotionPlan { seconds: 60.0, rate: 50.0, seed, ..MotionPlan::default() };
//!     torquewise::logs::write_motion(file, &simulate(&arm, &plan)?.motion)?;
//! }
//!
//! let fit = Fit::new(&Log::open(train)?).run()?;
//! let errors = fit.evaluate(&Log::open(test)?)?;
//! assert!(errors.joints.iter().all(|joint| joint.nrmse_percent < 1.0));
//! fit.model.save(folder.path().join("arm.json"))?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Features, all on by default: `formats` for logs beside plain CSV, `sqlite` for bags in `.db3`, `simulation` for arms with known
//! truth and controllers, `figures` for reports and exported code.

mod error;
pub mod observe;
mod options;
mod keywords;
pub mod log;
pub mod predict;
pub mod physics;
pub mod evaluate;
mod fit;
pub mod summary;
pub mod compare;
pub mod inspect;
pub mod describe;
#[cfg(feature = "figures")]
pub mod page;
#[cfg(feature = "figures")]
pub mod exported;
pub mod payload;
pub mod external;
pub mod sums;
#[cfg(feature = "simulation")]
pub mod urdf;
#[cfg(feature = "simulation")]
pub mod twin;

pub(crate) use error::Result;
pub use error::{Error, Remedy, Wording};
pub use evaluate::{Evaluation, evaluate};
pub use fit::{Fit, FitResult};
pub use keywords::{Keyword, Takes};
pub use log::{Filter, Log, Prepared, Rows, Source};
/// Help of an [`Error`] is a method of this trait.
pub use miette::Diagnostic;
pub use observe::{Event, NOBODY, Observer, Watched};
pub use options::{FitOptions, Library};
#[cfg(feature = "figures")]
pub use torquewise_export as export;
pub use torquewise_identify as identify;
pub use torquewise_identify::verdict::{Grade, Verdict};
pub use torquewise_logs as logs;
pub use torquewise_model as model;
pub use torquewise_model::{Model, Torque};
pub use torquewise_motion as motion;
pub use torquewise_regression as regression;
#[cfg(feature = "figures")]
pub use torquewise_report as report;
#[cfg(feature = "simulation")]
pub use torquewise_sim as dynamics;
#[cfg(feature = "simulation")]
pub use torquewise_sim::control;
#[cfg(feature = "simulation")]
pub use torquewise_sim::excite;
pub use torquewise_stepwise as stepwise;
pub use torquewise_stepwise::FrictionKind;
pub use torquewise_stepwise::Progress;

/// The guides, whose programs are compiled as tests.
#[cfg(doctest)]
mod guides {
    #[doc = include_str!("../../../docs/library.md")]
    struct Library;
    #[doc = include_str!("../../../README.md")]
    struct Readme;
}
