//! Errors of planning a motion.
#![expect(missing_docs, reason = "each message explains its fields")]

use torquewise_motion::MotionError;
use torquewise_regression::SparseError;
use torquewise_stepwise::IdentifyError;

/// Why a motion cannot be planned.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ExciteError {
    #[error(
        "{what} is given {found} times, the arm has {joints} joints: give it once, or for each"
    )]
    Count { what: &'static str, found: usize, joints: usize },
    #[error("{what} is given for joint `{joint}`, which is not there: choose from {known}")]
    UnknownJoint { what: &'static str, joint: String, known: String },
    #[error("{what} is given with and without names of joints: give all of them names, or none")]
    Mixed { what: &'static str },
    #[error("{what} of joint `{joint}` is {found}, expected {expected}: correct it")]
    Limit { what: &'static str, joint: String, found: f64, expected: &'static str },
    #[error(
        "joint `{joint}` may move from {lower} to {upper} rad: give lower < upper within the \
         limits of the arm"
    )]
    Range { joint: String, lower: f64, upper: f64 },
    #[error("home of joint `{joint}` is {home} rad, it may move from {lower} to {upper}: move it")]
    Home { joint: String, home: f64, lower: f64, upper: f64 },
    #[error("{setting} is {found}, expected {expected}: correct it")]
    Setting { setting: &'static str, found: f64, expected: &'static str },
    #[error(
        "the recording `{recording}` of {seconds} s has no room for a single {piece} there and \
         back: give it more seconds or the joints more speed"
    )]
    TooShort { recording: &'static str, seconds: f64, piece: &'static str },
    #[error(
        "a plan for {columns:.0} columns would take too long, expected at most {limit}: \
         lower the interaction order or lock joints"
    )]
    TooManyColumns { columns: f64, limit: usize },
    #[error(
        "the planned {what} of joint `{joint}` reaches {found}, allowed are {limit}: \
         this is a mistake of the planner, please report it"
    )]
    Exceeds { what: &'static str, joint: String, found: f64, limit: f64 },
    #[error("the library cannot be listed")]
    Library {
        #[from]
        source: IdentifyError,
    },
    #[error("the library cannot be evaluated")]
    Columns {
        #[from]
        source: SparseError,
    },
    #[error("the motion cannot be built")]
    Motion {
        #[from]
        source: MotionError,
    },
}
