//! The reference arms that tests, examples and documents share.

use crate::arm::Arm;
use crate::error::SimError;

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

/// Every reference arm with its DH table, fewest joints first.
const BUILTIN: [(ArmSummary, &str); 6] = [
    (
        ArmSummary {
            name: "planar-2",
            joints: 2,
            description: "two links in a vertical plane, whose equations fit on one line",
        },
        include_str!("arms/planar-2.toml"),
    ),
    (
        ArmSummary {
            name: "puma560-3",
            joints: 3,
            description: "first three joints of the PUMA 560, the arm of the paper",
        },
        include_str!("arms/puma560-3.toml"),
    ),
    (
        ArmSummary {
            name: "generic-4",
            joints: 4,
            description: "palletiser: waist, shoulder, elbow and a turning gripper flange",
        },
        include_str!("arms/generic-4.toml"),
    ),
    (
        ArmSummary {
            name: "generic-5",
            joints: 5,
            description: "small assembly arm with pitching and rolling wrist",
        },
        include_str!("arms/generic-5.toml"),
    ),
    (
        ArmSummary {
            name: "generic-6",
            joints: 6,
            description: "industrial arm with spherical wrist",
        },
        include_str!("arms/generic-6.toml"),
    ),
    (
        ArmSummary {
            name: "generic-7",
            joints: 7,
            description: "redundant lightweight arm with offset-free shoulder and wrist",
        },
        include_str!("arms/generic-7.toml"),
    ),
];

/// The reference arms, fewest joints first.
pub fn arms() -> Vec<ArmSummary> {
    BUILTIN.iter().map(|(summary, _)| *summary).collect()
}

impl Arm {
    /// The reference arm of that name; [`arms`] lists them.
    ///
    /// # Errors
    /// [`SimError::UnknownArm`], which lists the names there are.
    pub fn builtin(name: &str) -> Result<Self, SimError> {
        match BUILTIN.iter().find(|(summary, _)| summary.name == name) {
            Some((_, table)) => Self::from_dh_toml(table),
            None => Err(SimError::UnknownArm {
                name: name.into(),
                known: BUILTIN.map(|(summary, _)| summary.name).join(", "),
            }),
        }
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

    #[test]
    fn an_unknown_name_is_answered_with_the_names_there_are() {
        let error = Arm::builtin("puma").unwrap_err();

        assert!(matches!(error, SimError::UnknownArm { .. }));
        for summary in arms() {
            assert!(error.told().contains(summary.name));
        }
    }
}
