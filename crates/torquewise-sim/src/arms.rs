//! The reference arms that tests, examples and documents share.

use crate::{Arm, Result, SimError};

/// A reference arm in one line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub struct ArmSummary {
    /// What [`Arm::builtin`] calls it.
    pub name: &'static str,
    /// Number of joints.
    pub joints: usize,
    /// What kind of arm it is.
    pub description: &'static str,
}

/// A reference arm and its table, `arms/NAME.toml`.
macro_rules! summary {
    ($name:literal, $joints:literal, $description:literal) => {
        (
            ArmSummary { name: $name, joints: $joints, description: $description },
            include_str!(concat!("arms/", $name, ".toml")),
        )
    };
}

const BUILTIN: [(ArmSummary, &str); 9] = [
    summary!("planar-2", 2, "two links in a vertical plane, whose equations fit on one line"),
    summary!("puma560-3", 3, "first three joints of the PUMA 560, the arm of the paper"),
    summary!("generic-4", 4, "palletiser: waist, shoulder, elbow and a turning gripper flange"),
    summary!("generic-5", 5, "small assembly arm with pitching and rolling wrist"),
    summary!("generic-6", 6, "industrial arm with spherical wrist"),
    summary!("generic-7", 7, "redundant lightweight arm with offset-free shoulder and wrist"),
    summary!("gantry-3", 3, "gantry: three slides across each other, the last a lift"),
    summary!("scara-4", 4, "SCARA: two parallel turns, a sliding spindle that turns (RRPR)"),
    summary!(
        "surgical-6",
        6,
        "surgical arm: yaw, pitch, a sliding instrument and its wrist (RRPRRR)"
    ),
];

/// The reference arms, fewest joints first, then those that slide.
pub fn arms() -> Vec<ArmSummary> {
    BUILTIN.iter().map(|(summary, _)| *summary).collect()
}

impl Arm {
    /// The reference arm of that name; [`arms`] lists them.
    ///
    /// # Errors
    /// [`SimError::UnknownArm`], which lists the names there are.
    pub fn builtin(name: &str) -> Result<Self> {
        let Some((_, table)) = BUILTIN.iter().find(|(own, _)| own.name == name) else {
            let known = BUILTIN.map(|(own, _)| own.name).join(", ");
            return Err(SimError::UnknownArm { name: name.into(), known });
        };
        Self::from_dh_toml(table)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_summary_agrees_with_its_table() {
        for summary in arms() {
            let arm = Arm::builtin(summary.name).unwrap();

            assert_eq!(arm.name(), summary.name);
            assert_eq!(arm.n_joints(), summary.joints);
        }
    }
}
