//! What a robot arm did: joint positions, velocities, accelerations and torques over time.
//!
//! The one noun that every other crate reads. A [`Recording`] is anything that can hand out [`Motion`] blocks in order, as often as asked, so that a log longer
//! than memory is worked through in fixed memory.
//!
//! ```
//! use faer::Mat;
//! use torquewise_motion::{Motion, Signals};
//!
//! let still = Mat::zeros(3, 1);
//! let motion = Motion::new(Signals {
//!     joints: vec!["shoulder".into()],
//!     t: vec![0.0, 0.01, 0.02],
//!     q: Mat::from_fn(3, 1, |row, _| 0.1 * row as f64),
//!     dq: still.clone(),
//!     ddq: still.clone(),
//!     tau: Some(still),
//! })?;
//! assert_eq!((motion.n_rows(), motion.n_joints()), (3, 1));
//! # Ok::<(), torquewise_motion::MotionError>(())
//! ```

pub mod bounded_file;
pub mod error;
mod joint_names;
pub mod motion;
pub mod path;
pub mod pattern;
pub mod repairs;
pub mod recording;
pub mod differentiate;
pub mod stats;
pub mod whole_file;
pub mod signals;

pub use differentiate::{HALF_WINDOW, derivative};
pub use error::{MotionError, Result};
pub use joint_names::unfit_joint_name;
pub use motion::{LARGEST, Motion, Signals};
pub use path::Path;
pub use pattern::Pattern;
pub use recording::{BLOCK_ROWS, RawRecording, ReadError, ReadResult, Recording, Visit, VisitPair};
pub use repairs::Repairs;
pub use signals::{Conditioning, Raw, Signal};
pub use stats::{ends, grouped, median, quantile, whole};
