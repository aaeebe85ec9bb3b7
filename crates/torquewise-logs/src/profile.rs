//! From TOML text to profile: which column of a log is which signal, in which unit and at which
//! scale.

pub(crate) mod unit;
mod check;
#[cfg(feature = "formats")]
mod text;

use crate::layout::Signal;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::PathBuf;

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
#[serde(deny_unknown_fields)]
pub struct Profile {
    /// Name of the robot, for people.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub robot: Option<String>,
    /// Joint names, base to tip. For bags: which joints, and in which order.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub joints: Vec<String>,
    /// Joints that are dropped after everything else was worked out.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub leave_out: Vec<String>,
    /// Topic of the joint states, for a bag with several.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub topic: Option<String>,
    /// Rows per second \[Hz\], for a file without a clock or instead of its clock.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rate: Option<f64>,
    /// First and last rows that are read, 1 for the first; each range is a trajectory.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub rows: Vec<[u64; 2]>,
    /// Times between which rows are read \[s\], 0 for the first row; each range is a trajectory.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub seconds: Vec<[f64; 2]>,
    /// Further files with the same rows, by the name that their columns are called with
    /// (`NAME.column`); paths are relative to the folder of the log.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub beside: BTreeMap<String, PathBuf>,
    /// The clock; column `t` in seconds unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub t: Option<TimeColumn>,
    /// Positions; may be left out for bags.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub q: Option<SignalColumns>,
    /// Velocities.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dq: Option<SignalColumns>,
    /// Accelerations.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ddq: Option<SignalColumns>,
    /// Torques.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tau: Option<TorqueColumns>,
}

/// The column of the clock.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TimeColumn {
    /// Its name.
    pub column: String,
    /// `s` (default), `ms`, `us` or `ns`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
}

/// The columns of a signal that is a motion.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SignalColumns {
    /// One per joint; may be left out for bags.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub columns: Option<Columns>,
    /// `rad` (default), `deg`, `rev` or `m`; with `/s` or `/s2` where it is a derivative, or `rpm`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
    /// Factor; 1 unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scale: Option<PerJoint>,
    /// n×n coupling of the columns, applied after their factors; the identity unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub matrix: Option<Vec<Vec<f64>>>,
    /// Added last, in SI units; 0 unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub offset: Option<PerJoint>,
}

/// The columns of the torques.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TorqueColumns {
    /// One per joint; may be left out for bags.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub columns: Option<Columns>,
    /// `N.m` (default), `mN.m`, `N` or `A`; amperes need a `torque_constant`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
    /// Factor; 1 unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scale: Option<PerJoint>,
    /// Turns of the motor for one of the joint, with its sign; 1 unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gear: Option<PerJoint>,
    /// Torque of the motor for each ampere \[N·m/A\], with its sign; 1 unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub torque_constant: Option<PerJoint>,
    /// n×n coupling of the columns, applied after their factors; the identity unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub matrix: Option<Vec<Vec<f64>>>,
    /// Added last, in SI units; 0 unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
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
    /// What the profile says of a signal.
    pub(crate) fn parts(&self, signal: Signal) -> Option<Parts<'_>> {
        match signal {
            Signal::Q => self.q.as_ref().map(Parts::of_motion),
            Signal::Dq => self.dq.as_ref().map(Parts::of_motion),
            Signal::Ddq => self.ddq.as_ref().map(Parts::of_motion),
            Signal::Tau => self.tau.as_ref().map(Parts::of_torque),
        }
    }
}

/// What a profile says of any signal.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Parts<'a> {
    pub(crate) columns: Option<&'a Columns>,
    pub(crate) unit: Option<&'a str>,
    pub(crate) scale: Option<&'a PerJoint>,
    pub(crate) gear: Option<&'a PerJoint>,
    pub(crate) torque_constant: Option<&'a PerJoint>,
    pub(crate) matrix: Option<&'a Vec<Vec<f64>>>,
    pub(crate) offset: Option<&'a PerJoint>,
}

impl<'a> Parts<'a> {
    fn of_motion(of: &'a SignalColumns) -> Self {
        Self {
            columns: of.columns.as_ref(),
            unit: of.unit.as_deref(),
            scale: of.scale.as_ref(),
            gear: None,
            torque_constant: None,
            matrix: of.matrix.as_ref(),
            offset: of.offset.as_ref(),
        }
    }

    fn of_torque(of: &'a TorqueColumns) -> Self {
        Self {
            columns: of.columns.as_ref(),
            unit: of.unit.as_deref(),
            scale: of.scale.as_ref(),
            gear: of.gear.as_ref(),
            torque_constant: of.torque_constant.as_ref(),
            matrix: of.matrix.as_ref(),
            offset: of.offset.as_ref(),
        }
    }
}

impl PerJoint {
    /// The number of joint `joint`, 0 for the first.
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
