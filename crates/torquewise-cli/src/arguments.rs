//! Settings that several commands share.

use crate::files::read_text;
use crate::selection::{FRICTION, SelectionArguments};
use crate::{CliError, Result, object};
use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use serde::Serialize;
use serde_json::{Value, json};
use std::path::PathBuf;
use std::str::FromStr;
use torquewise::FitOptions;
use torquewise::dynamics::Noise;
use torquewise::identify::PatternPlan;
use torquewise::identify::plan::KnownGeometry;
use torquewise::model::JointKinds;
use torquewise::urdf::known_geometry;

/// A word that an option may have, and its help.
pub(crate) type Word<T> = (&'static str, &'static str, T);

pub(crate) fn choice<T: Copy + Send + Sync>(
    all: &'static [Word<T>],
) -> impl TypedValueParser<Value = T> {
    let words = all.iter().map(|(name, help, _)| PossibleValue::new(*name).help(*help));
    PossibleValuesParser::new(words).map(|given| {
        let known = all.iter().find(|(name, ..)| *name == given);
        known.unwrap_or(&all[0]).2
    })
}

/// The same where the word itself is what the option is set to.
pub(crate) fn words(all: &[(&'static str, &'static str)]) -> PossibleValuesParser {
    all.iter().map(|(name, help)| PossibleValue::new(name).help(help)).collect::<Vec<_>>().into()
}

const ACTIVATION: [(&str, &str); 2] = [
    ("scaled", "Each joint by its own range, sensitivity from the noise floor"),
    ("paper", "Fixed constants, as published with the method"),
];

/// What is known of an arm before its log is read.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Learned chain")]
pub(crate) struct RobotArguments {
    /// Take the joint axes from a URDF instead of searching them: joints go by name, in its order
    /// where it has none of the names; those that the log does not have are held at 0
    #[arg(long, value_name = "ROBOT.urdf")]
    pub(crate) urdf: Option<PathBuf>,
    /// Joints of the URDF that are held at 0, where names do not tell
    #[arg(long, value_name = "JOINT", value_delimiter = ',', requires = "urdf")]
    lock: Vec<String>,
    /// Gravity direction in the URDF base frame, normalised; a fit may tilt it [default: 0,0,-1]
    #[arg(long, value_name = "X,Y,Z", requires = "urdf", allow_hyphen_values = true)]
    #[arg(value_parser = direction)]
    gravity: Option<[f64; 3]>,
}

impl RobotArguments {
    /// Where the axes of the joints of a log lie, if a file says so.
    pub(crate) fn geometry(&self, joints: &[String]) -> Result<Option<KnownGeometry>> {
        let Some(file) = &self.urdf else { return Ok(None) };
        let known = known_geometry(&read_text(file)?, joints, &self.lock, self.gravity);
        let what = || format!("cannot match {} to the joints of the log", file.display());
        Ok(Some(known.map_err(|error| CliError::from(error).within(what()))?))
    }
}

fn direction(text: &str) -> Result<[f64; 3], String> {
    let numbers = text.split(',').map(|x| x.trim().parse().ok().filter(|x: &f64| x.is_finite()));
    match numbers.collect::<Option<Vec<f64>>>().as_deref() {
        Some(&[x, y, z]) if [x, y, z].iter().any(|x| *x != 0.0) => Ok([x, y, z]),
        _ => Err("expected three numbers, not all 0, such as 0,0,-1".to_owned()),
    }
}

/// How rows are clustered.
#[derive(Args, Clone, Debug, Serialize)]
#[command(next_help_heading = "Patterns of motion")]
pub(crate) struct PatternArguments {
    /// Constants of the activation index, by which rows are clustered
    #[arg(long, value_parser = words(&ACTIVATION), default_value = "scaled")]
    activation: String,
    /// Number of clusters from 1 to 9, or `auto` for the elbow; a chain is fitted to all rows at
    /// once, its report alone tells of them
    #[arg(long, value_name = "auto|K", default_value = "auto", value_parser = clusters)]
    // Named in full, since clap takes a plain Option for one that may be left out.
    clusters: std::option::Option<usize>,
    /// Random seed
    #[arg(long, default_value_t = 0)]
    seed: u64,
}

impl PatternArguments {
    pub(crate) fn plan(&self) -> Result<PatternPlan> {
        Ok(fit_options(object(self))?.patterns())
    }
}

/// The options of a fit that flags say, each under the name of its option.
pub(crate) fn fit_options(mut flags: Value) -> Result<FitOptions> {
    flags["noise_correction"] = json!(flags["no_noise_correction"] != true);
    let given = flags.as_object().into_iter().flatten();
    let given = given.filter(|(name, value)| !value.is_null() && *name != "no_noise_correction");
    let keywords = given.map(|(name, value)| (name.clone(), value.clone())).collect();
    Ok(FitOptions::of_keywords(&keywords)?)
}

const LIBRARY: [(&str, &str); 3] = [
    (
        "energy",
        "M(q) and V(q), shared by all joints: exact for rigid arms of revolute joints; all terms \
         for up to four joints, or with --interaction, else those of a learned chain",
    ),
    (
        "product",
        "Products of sines, cosines, velocities and accelerations, for each joint on its own",
    ),
    (
        "chain",
        "Energies of a chain of rigid bodies whose geometry is learned too: for four joints and \
         more, noisy logs and friction",
    ),
];

pub(crate) const METHOD: [(&str, &str); 2] = [
    ("stepwise", "Gravity from standstill, Coriolis from uniform, inertia from variable velocity"),
    ("sindy", "One-shot SINDy: the product library on all rows, without noise correction"),
];

/// How a log becomes a model, the method left open.
#[derive(Args, Clone, Debug, Serialize)]
#[command(next_help_heading = "Method")]
pub(crate) struct PlanArguments {
    /// Candidates [default: energy; product with --method sindy; chain for filtered logs, friction,
    /// four joints and more, or where it misses less than terms that are not good]
    #[arg(long, value_parser = words(&LIBRARY))]
    library: Option<String>,
    /// Friction of the joints [default: auto with --library chain, else none]
    #[arg(long, value_parser = words(&FRICTION))]
    friction: Option<String>,
    /// Energy library: at most this many joint angles in a term [default: as many as are feasible]
    #[arg(help_heading = "Term libraries", long, value_name = "K", value_parser = clap::value_parser!(u8).range(1..=16))]
    interaction: Option<u8>,
    /// Product library: factors of sine and cosine in a term [default: 4]
    #[arg(help_heading = "Term libraries", long, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=8))]
    trig_order: Option<u8>,
    /// Product library: the same for the gravity step [default: 2]
    #[arg(help_heading = "Term libraries", long, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=8))]
    gravity_order: Option<u8>,
    #[command(flatten)]
    #[serde(flatten)]
    pub(crate) selection: SelectionArguments,
    #[command(flatten)]
    #[serde(flatten)]
    patterns: PatternArguments,
}

impl PlanArguments {
    pub(crate) fn options(&self, method: &str) -> Result<FitOptions> {
        let mut flags = object(self);
        flags["method"] = json!(method);
        fit_options(flags)
    }
}

pub(crate) fn parsed<T: FromStr>(
    text: &str,
    is_fit: impl Fn(&T) -> bool,
    expected: &str,
) -> Result<T, String> {
    text.parse().ok().filter(is_fit).ok_or_else(|| expected.to_owned())
}

/// The same as the parser of an option.
pub(crate) fn fitting<T: FromStr>(
    is_fit: fn(&T) -> bool,
    expected: &'static str,
) -> impl Fn(&str) -> Result<T, String> + Clone {
    move |text| parsed(text, is_fit, expected)
}

/// A letter for each joint.
pub(crate) fn kinds_of_joints() -> impl Fn(&str) -> Result<String, String> + Clone {
    let is_read = |kinds: &String| JointKinds::read(kinds).is_some();
    fitting(is_read, "expected r or p for each joint, as r,r,p,r")
}

/// The same, or none for `auto`.
pub(crate) fn parsed_unless_auto<T: FromStr>(
    text: &str,
    is_fit: impl Fn(&T) -> bool,
    expected: &str,
) -> Result<Option<T>, String> {
    if text == "auto" { Ok(None) } else { parsed(text, is_fit, expected).map(Some) }
}

fn clusters(text: &str) -> Result<Option<usize>, String> {
    let expected = "expected `auto` or a number from 1 to 9";
    parsed_unless_auto(text, |k| (1..=9).contains(k), expected)
}

/// Signal-to-noise ratios of q, q̇ and q̈ \[dB\], separated by commas; `inf` for no noise.
pub(crate) fn noise_levels(text: &str) -> Result<Noise, String> {
    let levels: Result<Vec<f64>, _> = text.split(',').map(|level| level.trim().parse()).collect();
    match levels.as_deref() {
        Ok(&[q, dq, ddq]) => Noise::from_db(q, dq, ddq).map_err(|error| error.to_string()),
        _ => Err("expected three numbers of dB, such as 60,40,30 or inf,40,30".to_owned()),
    }
}
