//! Joint names → text → joint names: how a log file keeps them.

use crate::{LogError, Result, shown};
use std::path::Path;
use torquewise_motion::unfit_joint_name;

/// Key of the joint names in the metadata of a Parquet file.
#[cfg(feature = "formats")]
pub(crate) const PARQUET_KEY: &str = "torquewise.joints";

/// Start of the comment line that holds the joint names of a CSV file.
pub(crate) const CSV_COMMENT: &str = "# joints:";

pub(crate) fn numbered(n: usize) -> Vec<String> {
    (1..=n).map(|joint| format!("joint{joint}")).collect()
}

pub(crate) fn parse(text: &str) -> Vec<String> {
    text.split(',').map(|name| name.trim().to_owned()).collect()
}

pub(crate) fn checked(file: &Path, names: Vec<String>, n: usize) -> Result<Vec<String>> {
    if names.len() != n {
        let (file, found) = (file.into(), names.len());
        return Err(LogError::JointNameCount { file, found, expected: n });
    }
    check(&names).map(|()| names)
}

pub(crate) fn check(names: &[String]) -> Result<()> {
    unfit_joint_name(names)
        .map_or(Ok(()), |name| Err(LogError::JointName { name: shown(name.as_bytes()) }))
}
