//! Motion logs of robot arms: CSV and Parquet, read in fixed memory and checked.
//!
//! Columns are `t`, `q1…qn`, `dq1…dqn`, `ddq1…ddqn`, `tau1…taun` in SI units and in any order;
//! dq, ddq and tau may be missing. [`Logs`] reads several files as one
//! [`Recording`](torquewise_motion::Recording), [`LogWriter`] and [`TableWriter`] write them.
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

pub mod error;
mod format;
mod joints;
mod layout;
mod rows;
mod lines;
mod csv_rows;
mod parquet_rows;
mod source;
mod gaps;
mod blocks;
pub mod logs;
pub mod units;
pub mod columns;
mod sink;
pub mod table;
pub mod log_writer;

pub use columns::{Column, ColumnKind, Values};
pub use error::{LogError, Place};
pub use log_writer::{Contents, LogWriter, write_motion};
pub use logs::Logs;
pub use table::TableWriter;
pub use units::{UnitWarning, unit_warnings};
