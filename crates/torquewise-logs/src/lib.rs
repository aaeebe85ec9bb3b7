//! Motion logs of robot arms: read in bounded memory and checked, whatever program wrote them.
//!
//! Columns are `t`, `q1…qn`, `dq1…dqn`, `ddq1…ddqn`, `tau1…taun` in SI units and in any order;
//! dq, ddq and tau may be missing, and all joints counted from 0. Any other layout is described by a
//! [`Profile`], which [`suggest`](suggest()) drafts. Read are CSV, Parquet, bags of ROS 2 (`.db3`
//! and `.mcap` with joint states), NumPy archives (`.npz`) and MATLAB files (`.mat`).
//!
//! [`Logs`] reads several files as one [`Recording`](torquewise_motion::Recording), or as recorded
//! with [`Logs::read_raw`]; a [`Frame`] is a table in memory that is read as a file is; [`TableWriter`] writes CSV and Parquet.
//!
//! ```
//! use torquewise_logs::Logs;
//!
//! let folder = tempfile::tempdir()?;
//! let log = folder.path().join("swing.csv");
//! std::fs::write(&log, "t,q1,dq1,ddq1\n0.0,0.1,0.2,0.0\n0.1,0.12,0.2,0.0\n")?;
//!
//! let logs = Logs::open(&[log])?;
//! let swing = &logs.read_all()?[0];
//!
//! assert_eq!((swing.n_rows(), swing.joints()), (2, &["joint1".to_owned()][..]));
//! assert!(!logs.has_tau());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Without the default features only CSV is read and written; `formats` adds all but `.db3`, which
//! takes a library in C and is `sqlite`.

pub mod error;
mod format;
mod log_input;
mod joints;
mod rows;
mod lines;
mod csv_rows;
#[cfg(feature = "formats")]
mod parquet_checks;
#[cfg(feature = "formats")]
mod parquet_rows;
#[cfg(feature = "formats")]
mod bag;
#[cfg(feature = "formats")]
mod arrays;
mod mapping;
mod plain;
pub mod profile;
mod by_profile;
mod beside;
pub mod frame;
pub mod signal_rows;
pub mod source;
mod absurd;
mod accelerations;
mod gaps;
mod blocks;
pub mod logs;
mod raw_noise;
mod clock;
mod pieces;
mod trajectory;
pub mod conditioned;
#[cfg(feature = "formats")]
pub mod suggest;
#[cfg(feature = "formats")]
pub mod preview;
mod sink;
#[cfg(feature = "formats")]
mod parquet_sink;
pub mod table;

pub use accelerations::LEAST_GAIN;
pub use conditioned::ConditionedLogs;
#[cfg(feature = "formats")]
pub(crate) use error::guarded;
pub use error::{LogError, Result, RowPlace};
pub(crate) use error::{listed, shown};
pub(crate) use format::Format;
pub use format::{is_bag, is_log};
pub use frame::Frame;
pub(crate) use joints::CSV_COMMENT;
#[cfg(feature = "formats")]
pub(crate) use joints::PARQUET_KEY;
pub use log_input::{HeldBytes, LogInput};
pub use logs::Logs;
pub(crate) use mapping::{Mapping, Slot, Time};
#[cfg(feature = "formats")]
pub use preview::preview;
pub use profile::Profile;
pub(crate) use rows::Rows;
pub use signal_rows::ReadReport;
pub use sink::{Column, Values};
pub use source::Options;
#[cfg(feature = "formats")]
pub use suggest::{Suggestion, suggest};
pub use table::{TableWriter, write_motion};
