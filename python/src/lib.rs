//! torquewise for Python: the engine of the package `torquewise`, which wraps it.
//!
//! Long work runs in a thread of its own without the interpreter; the calling thread shows progress
//! and listens to Ctrl-C (`work`). Arrays are read where they lie, a block of rows at a time
//! (`arrays`).
#![expect(clippy::needless_pass_by_value, reason = "PyO3 hands arguments over by value")]

mod arrays;
mod control;
mod errors;
mod fit;
mod friction_state;
mod log;
mod model;
mod observer;
mod simulation;
mod states;
mod sums;
mod work;

use pyo3::prelude::*;

#[pymodule]
mod _core {
    use pyo3::prelude::*;

    #[pymodule_export]
    use crate::arrays::ArrayFrame;
    #[pymodule_export]
    use crate::control::control;
    #[pymodule_export]
    use crate::errors::{
        ColumnError, FitError, Interrupted, LogError, ModelError, TorquewiseError, UsageError,
    };
    #[pymodule_export]
    use crate::fit::{Fit, fit, keywords};
    #[pymodule_export]
    use crate::friction_state::FrictionState;
    #[pymodule_export]
    use crate::log::{Log, inspect, patterns, suggest, write_log};
    #[pymodule_export]
    use crate::model::Model;
    #[pymodule_export]
    use crate::observer::{contacts, gains, payload};
    #[pymodule_export]
    use crate::simulation::{arms, excite, simulate};
    #[pymodule_export]
    use crate::sums::{Request, Summary};
    #[pymodule_export]
    use crate::work::{command_line, write_whole};

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
