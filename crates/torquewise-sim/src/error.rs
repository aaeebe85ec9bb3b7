//! What can keep an arm from being read, moved, controlled, or a motion from being planned.
#![expect(missing_docs, reason = "each message explains its fields")]

use torquewise_model::ModelError;
use torquewise_motion::MotionError;
use torquewise_stepwise::IdentifyError;

/// What fails by [`SimError`].
pub type Result<T, E = SimError> = std::result::Result<T, E>;

/// Why an arm cannot be read, moved, made noisy or controlled, or a motion not be planned.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[non_exhaustive]
pub enum SimError {
    // Reading an arm
    #[error("no arm is called `{name}`")]
    #[diagnostic(help("choose one of {known}, or give a .urdf or .toml file"))]
    UnknownArm { name: String, known: String },
    #[error("the URDF is no XML that can be read")]
    #[diagnostic(help("check that it is one whole <robot> element"))]
    Urdf { source: roxmltree::Error },
    #[error("line {line} of the URDF: <{element}> {what}")]
    #[diagnostic(help("mend the element"))]
    UrdfElement { line: u32, element: String, what: String },
    #[error("the DH table cannot be read")]
    #[diagnostic(help("write name, gravity and one [[joints]] row per joint"))]
    DhTable { source: Box<toml::de::Error> },

    // Tree of links and joints
    #[error("{kind} `{name}` appears twice")]
    #[diagnostic(help("give each {kind} its own name"))]
    DuplicateName { kind: &'static str, name: String },
    #[error("a joint is called \"{name}\"")]
    #[diagnostic(help(
        "take a name of 1 to 200 bytes without comma, control character or outer space"
    ))]
    JointName { name: String },
    #[error("joint `{joint}` names link `{link}`, which is not defined")]
    #[diagnostic(help("add it or mend the name"))]
    UnknownLink { joint: String, link: String },
    #[error("joints `{first}` and `{second}` both carry link `{link}`")]
    #[diagnostic(help("remove one of them"))]
    TwoParents { link: String, first: String, second: String },
    #[error("expected one link without parent joint, found {}: {}", roots.len(), roots.join(", "))]
    #[diagnostic(help("join them or remove the others; without any, open the loop of joints"))]
    Roots { roots: Vec<String> },
    #[error("link `{link}` hangs on itself through a loop of joints")]
    #[diagnostic(help("open the loop"))]
    Loop { link: String },
    #[error("only revolute, continuous and prismatic joints may move, found {joints}")]
    #[diagnostic(help("lock them (at 0, mass kept)"))]
    UnsupportedJoints { joints: String },
    #[error("the arm branches at link `{link}`")]
    #[diagnostic(help("to keep one serial chain, lock {lock}"))]
    Branches { link: String, lock: String },
    #[error("the URDF has no joint `{unknown}`: it has {known}")]
    #[diagnostic(help(
        "name the joints of the log after them, by `joints` in a profile, or leave one out, by \
         `leave_out`; lock those that the log lacks"
    ))]
    UnknownJoints { unknown: String, known: String },
    #[error("the joints of the log are {found}, the URDF has them in the order {expected}")]
    #[diagnostic(help("put them in that order, by `joints` in a profile"))]
    JointOrder { expected: String, found: String },
    #[error("{what} has no direction")]
    #[diagnostic(help("give three numbers that are not all 0"))]
    NoDirection { what: String },
    #[error("no joint is left that moves")]
    #[diagnostic(help("an arm needs at least one: lock fewer or add one"))]
    NoJoints,

    // Numbers of an arm
    #[error("inertia of `{place}` has a negative principal moment")]
    #[diagnostic(help("check the signs and the order ixx, iyy, izz, ixy, ixz, iyz"))]
    Inertia { place: String },
    #[error("range of joint `{joint}` is [{lower:?}, {upper:?}]")]
    #[diagnostic(help(
        "give lower < upper, within the limits of the arm; a joint that slides must have limits"
    ))]
    Range { joint: String, lower: f64, upper: f64 },
    #[error("the friction cannot be read")]
    #[diagnostic(help("write a table with `coulomb` for each joint that rubs"))]
    FrictionTable { source: Box<toml::de::Error> },

    // What is asked of an arm
    #[error("{what} holds {found} numbers, expected {expected}")]
    #[diagnostic(help("give one for each joint of the arm"))]
    JointCount { what: &'static str, found: usize, expected: usize },
    #[error("{what} is given {found} times, the arm has {joints} joints")]
    #[diagnostic(help("give it once, or for each"))]
    Count { what: &'static str, found: usize, joints: usize },
    #[error("{what} is given for joint `{joint}`, which is not there")]
    #[diagnostic(help("choose from {known}"))]
    UnknownJoint { what: &'static str, joint: String, known: String },
    #[error("{what} is given with and without names of joints")]
    #[diagnostic(help("give all of them names, or none"))]
    Mixed { what: &'static str },
    #[error("{what} is {found:?}, expected {expected}")]
    Setting { what: String, found: f64, expected: &'static str },
    #[error("home of joint `{joint}` is {home:?} rad, it may move from {lower:?} to {upper:?}")]
    #[diagnostic(help("move it into the range"))]
    Home { joint: String, home: f64, lower: f64, upper: f64 },

    // Moving and controlling an arm
    #[error("mass matrix is not positive definite at joint {}", joint + 1)]
    #[diagnostic(help("give the links after it mass or inertia"))]
    Massless { joint: usize },
    #[error("the motion cannot be built")]
    #[diagnostic(help("check the arm's masses and the plan or noise asked for"))]
    Motion(#[from] MotionError),
    #[error("the desired motion is not even in time at row {row}")]
    #[diagnostic(help("give one row per control period"))]
    Uneven { row: usize },
    #[error("the motion of the arm runs away at {t:.3} s: the loop is unstable")]
    #[diagnostic(help("lower its bandwidth, or raise the rate or the limits of the torque"))]
    Diverged { t: f64 },
    #[error(transparent)]
    #[diagnostic(transparent)]
    Model(#[from] ModelError),

    // Planning a motion
    #[error(
        "the recording `{recording}` of {seconds:?} s has no room for a single {piece} there and back"
    )]
    #[diagnostic(help("give it more seconds or the joints more speed"))]
    TooShort { recording: &'static str, seconds: f64, piece: &'static str },
    #[error("the planned {what} of joint `{joint}` reaches {found:?}, allowed are {limit:?}")]
    #[diagnostic(help("this is a mistake of the planner, please report it"))]
    Exceeds { what: &'static str, joint: String, found: f64, limit: f64 },
    #[error(
        "the torque of joint `{joint}` cannot be kept within 95 % of {limit:?} N·m, as planned motions \
         are: those tried ask for {needed:.3} N·m or more"
    )]
    #[diagnostic(help("raise its limit, narrow the ranges or take another home"))]
    Weak { joint: String, limit: f64, needed: f64 },
    #[error("the library cannot be listed or evaluated")]
    #[diagnostic(forward(0))]
    Library(#[from] IdentifyError),
}

pub(crate) fn check_joints(what: &'static str, found: usize, expected: usize) -> Result<()> {
    if found == expected { Ok(()) } else { Err(SimError::JointCount { what, found, expected }) }
}

/// Refuses a number that is NaN or outside `[least, most]`.
pub(crate) fn check_between(
    what: impl Into<String>,
    found: f64,
    [least, most]: [f64; 2],
    expected: &'static str,
) -> Result<()> {
    let refused = || SimError::Setting { what: what.into(), found, expected };
    (least..=most).contains(&found).then_some(()).ok_or_else(refused)
}

pub(crate) fn check_above_zero(what: &str, found: f64) -> Result<()> {
    check_between(what, found, [f64::MIN_POSITIVE, f64::INFINITY], "above 0")
}

#[cfg(test)]
impl SimError {
    /// What a user is told: the message, then the help.
    pub(crate) fn told(&self) -> String {
        let help = miette::Diagnostic::help(self).map(|help| help.to_string());
        format!("{self}: {}", help.unwrap_or_default())
    }
}
