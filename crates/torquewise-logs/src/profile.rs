//! Profiles: which column of a log is which signal, in which unit and at which scale.

pub(crate) mod unit;
mod check;
#[cfg(feature = "formats")]
mod text;

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::PathBuf;
use torquewise_motion::Signal;

/// How to read logs that have other columns than `t`, `q1`…`qn`, …, or other units than SI.
///
/// A value of a signal is Σ matrix · (gear · torque_constant · scale · unit · column) + offset,
/// the sum over the joints.
///
/// ```
/// use torquewise_logs::Profile;
///
/// let profile = Profile::from_toml(
///     r#"
///     joints = ["shoulder", "elbow"]
///     t = { column = "time", unit = "ms" }
///     q = { columns = "pos", unit = "deg" }
///     tau = { columns = ["i1", "i2"], unit = "A", torque_constant = [0.1, -0.1], gear = 100.0 }
///     "#,
/// )?;
///
/// assert_eq!(Profile::from_toml(&profile.to_toml())?, profile);
/// assert!(Profile::from_toml("jonts = []").is_err());
/// # Ok::<(), torquewise_logs::LogError>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Profile {
    /// Name of the robot, for people.
    pub robot: Option<String>,
    /// Joint names, base to tip. For bags: which joints, and in which order.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub joints: Vec<String>,
    /// Joints that are dropped after everything else was worked out.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub leave_out: Vec<String>,
    /// Topic of the joint states, for a bag with several.
    pub topic: Option<String>,
    /// Rows per second \[Hz\], for a file without a clock or instead of its clock.
    pub rate: Option<f64>,
    /// First and last rows that are read, 1 for the first; each range is a trajectory.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub rows: Vec<[u64; 2]>,
    /// Times between which rows are read \[s\], 0 for the first row; each range is a trajectory.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub seconds: Vec<[f64; 2]>,
    /// Further files with the same rows, by the name that their columns are called with
    /// (`NAME.column`); paths are relative to the folder of the log.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub beside: BTreeMap<String, PathBuf>,
    /// The clock; column `t` in seconds unless given.
    pub t: Option<TimeColumn>,
    /// Positions; may be left out for bags.
    pub q: Option<SignalColumns>,
    /// Velocities.
    pub dq: Option<SignalColumns>,
    /// Accelerations.
    pub ddq: Option<SignalColumns>,
    /// Torques.
    pub tau: Option<SignalColumns>,
}

/// The column of the clock.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TimeColumn {
    /// Its name.
    pub column: String,
    /// `s` (default), `ms`, `us` or `ns`.
    pub unit: Option<String>,
}

/// The columns of a signal.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SignalColumns {
    /// One per joint; may be left out for bags.
    pub columns: Option<Columns>,
    /// Of motions `rad` (default), `deg`, `rev` or `m`; with `/s` or `/s2` where it is a
    /// derivative, or `rpm`. Of torques `N.m` (default), `mN.m`, `N` or `A`; amperes need a
    /// `torque_constant`.
    pub unit: Option<String>,
    /// Factor; 1 unless given.
    pub scale: Option<PerJoint>,
    /// Of torques: turns of the motor for one of the joint, with its sign; 1 unless given.
    pub gear: Option<PerJoint>,
    /// Of torques: torque of the motor for each ampere \[N·m/A\], with its sign; 1 unless given.
    pub torque_constant: Option<PerJoint>,
    /// n×n coupling of the columns, applied after their factors; the identity unless given.
    pub matrix: Option<Vec<Vec<f64>>>,
    /// Added last, in SI units; 0 unless given.
    pub offset: Option<PerJoint>,
}

/// Names of columns.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(untagged, expecting = "expected a prefix such as \"pos\" or a list of column names")]
pub enum Columns {
    /// `"pos"` stands for pos1 … posn, or for pos itself if there is one joint and no pos1.
    Prefix(String),
    /// One name per joint.
    Names(Vec<String>),
}

/// Numbers for the joints.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged, expecting = "expected a number, or a list with a number for each joint")]
pub enum PerJoint {
    /// The same for all.
    All(f64),
    /// One for each.
    Each(Vec<f64>),
}

impl Profile {
    pub(crate) fn signal(&self, signal: Signal) -> Option<&SignalColumns> {
        [&self.q, &self.dq, &self.ddq, &self.tau][signal as usize].as_ref()
    }

    /// Why its torques may be none, if it leaves their unit open or as [`suggest`](crate::suggest())
    /// put it there.
    pub(crate) fn torque_doubt(&self) -> Option<&'static str> {
        let SignalColumns { columns, unit, torque_constant, .. } = self.tau.as_ref()?;
        let names = match columns {
            Some(Columns::Names(names)) => names.as_slice(),
            Some(Columns::Prefix(prefix)) => std::slice::from_ref(prefix),
            None => &[],
        };
        let is_current = names.iter().any(|name| name.to_lowercase().contains("cur"));
        let is_one = |own: &f64| own.to_bits() == 1.0_f64.to_bits();
        match torque_constant {
            Some(PerJoint::Each(own)) if own.iter().all(is_one) => Some(
                "every torque_constant of [tau] is 1.0, as a suggested profile has it: fill in N·m/A of \
                 each motor, or write torque_constant = 1.0",
            ),
            None if unit.is_none() && is_current => Some(
                "[tau] names currents and no unit, so they are taken as N·m: fill in unit = \"A\" and \
                 torque_constant, or write unit = \"N.m\"",
            ),
            _ => None,
        }
    }

    /// What columns named as usual mean: `q1`, `dq1`, …
    ///
    /// - `is_recorded`: whether q̇, q̈
    pub fn usual(is_recorded: [bool; 2]) -> Self {
        let of = |name: &str| {
            let columns = Some(Columns::Prefix(name.to_owned()));
            SignalColumns { columns, ..SignalColumns::default() }
        };
        Self {
            q: Some(of("q")),
            dq: is_recorded[0].then(|| of("dq")),
            ddq: is_recorded[1].then(|| of("ddq")),
            tau: Some(of("tau")),
            ..Self::default()
        }
    }

    /// The same with torque columns that are worth as much more, n.
    pub fn with_gains(mut self, gains: &[f64]) -> Self {
        let tau = self.tau.get_or_insert_default();
        let before = |joint| tau.scale.as_ref().and_then(|scale| scale.of(joint)).unwrap_or(1.0);
        let scale = gains.iter().enumerate().map(|(joint, gain)| before(joint) * gain).collect();
        tau.scale = Some(PerJoint::Each(scale));
        self
    }
}

impl PerJoint {
    pub(crate) fn of(&self, joint: usize) -> Option<f64> {
        match self {
            Self::All(value) => Some(*value),
            Self::Each(values) => values.get(joint).copied(),
        }
    }

    fn values(&self) -> &[f64] {
        match self {
            Self::All(value) => std::slice::from_ref(value),
            Self::Each(values) => values,
        }
    }
}
