//! Errors of arms, planned motions and noise levels.
#![expect(missing_docs, reason = "each message explains its fields")]

use torquewise_motion::MotionError;

/// Why an arm cannot be read, moved or made noisy.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DynamicsError {
    // Reading an arm
    #[error("no arm is called `{name}`: choose one of {known}, or give a .urdf or .toml file")]
    UnknownArm { name: String, known: String },
    #[error("the URDF is no XML that can be read: check that it is one whole <robot> element")]
    Urdf { source: roxmltree::Error },
    #[error("line {line} of the URDF: <{element}> {what}: mend the element")]
    UrdfElement { line: u32, element: String, what: String },
    #[error("the DH table cannot be read: write name, gravity and one [[joints]] row per joint")]
    DhTable { source: Box<toml::de::Error> },

    // Tree of links and joints
    #[error("{kind} `{name}` appears twice: give each {kind} its own name")]
    DuplicateName { kind: &'static str, name: String },
    #[error(
        "a joint is called \"{name}\": take a name of 1 to 200 bytes without comma, control character \
         or outer space"
    )]
    JointName { name: String },
    #[error("joint `{joint}` names link `{link}`, which is not defined: add it or mend the name")]
    UnknownLink { joint: String, link: String },
    #[error("joints `{first}` and `{second}` both carry link `{link}`: remove one of them")]
    TwoParents { link: String, first: String, second: String },
    #[error("expected one link without parent joint, found {}: {}", roots.len(), shown(roots))]
    Roots { roots: Vec<String> },
    #[error("link `{link}` hangs on itself through a loop of joints: open the loop")]
    Loop { link: String },
    #[error("cannot lock joint `{joint}`, the URDF has no such joint: choose from {known}")]
    UnknownLocked { joint: String, known: String },
    #[error(
        "only revolute and continuous joints may move, found {joints}: lock them (at 0, mass kept)"
    )]
    UnsupportedJoints { joints: String },
    #[error("the arm branches at link `{link}`: to keep one serial chain, lock {lock}")]
    Branches { link: String, lock: String },
    #[error(
        "the URDF has no joint `{unknown}`: it has {known}; name the joints of the log after \
         them, by `joints` in a profile"
    )]
    UnknownJoints { unknown: String, known: String },
    #[error(
        "the joints of the log are {found}, the URDF has them in the order {expected}: put them \
         in that order, by `joints` in a profile"
    )]
    JointOrder { expected: String, found: String },
    #[error("gravity has no direction: give three numbers that are not all 0")]
    NoGravity,
    #[error("no joint is left that moves: an arm needs at least one, lock fewer or add one")]
    NoJoints,

    // Numbers of an arm
    #[error("{what} of `{place}` is not finite: give a number")]
    NotFinite { what: &'static str, place: String },
    #[error("mass of `{place}` is {mass} kg: a mass is a number that is not negative")]
    Mass { place: String, mass: f64 },
    #[error(
        "inertia of `{place}` has a negative principal moment: check the signs and the order \
         ixx, iyy, izz, ixy, ixz, iyz"
    )]
    Inertia { place: String },
    #[error("axis of joint `{joint}` has no direction: give three numbers that are not all 0")]
    Axis { joint: String },
    #[error("range of joint `{joint}` is [{lower}, {upper}] rad: give lower < upper")]
    Range { joint: String, lower: f64, upper: f64 },

    // Friction of an arm
    #[error("the friction cannot be read: write a table with `coulomb` for each joint that rubs")]
    FrictionTable { source: Box<toml::de::Error> },
    #[error("friction is given for joint `{joint}`, the arm has {known}: name one of those")]
    FrictionJoint { joint: String, known: String },
    #[error("{what} of the friction of joint {joint} is {found}, expected {expected}")]
    Friction { what: &'static str, joint: usize, found: f64, expected: &'static str },

    // Moving an arm
    #[error("{signal} holds {found} numbers, expected {expected}: give one per joint")]
    JointCount { signal: &'static str, found: usize, expected: usize },
    #[error(
        "mass matrix is not positive definite at joint {}: give the links after it mass or inertia",
        joint + 1
    )]
    Massless { joint: usize },
    #[error("{what} of the motion plan is {found:?}, expected {expected}")]
    Plan { what: &'static str, found: f64, expected: &'static str },
    #[error("noise case {0} is unknown: choose 1, 2 or 3")]
    NoiseCase(u8),
    #[error("signal-to-noise ratio of {signal} is {db} dB: give a number, or +inf for no noise")]
    NoiseLevel { signal: &'static str, db: f64 },
    #[error("the motion cannot be built: check the arm's masses and the plan or noise asked for")]
    Motion {
        #[from]
        source: MotionError,
    },
}

/// The names, or what to do when there is none.
fn shown(names: &[String]) -> String {
    if names.is_empty() {
        "the joints form a loop or there is no link; open the loop".into()
    } else {
        format!("{}; join them or remove the others", names.join(", "))
    }
}
