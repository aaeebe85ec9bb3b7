//! `merge`: moments files added up, the same bytes in whatever order.

use crate::moments_file::{read_moments, write_moments};
use crate::{CliError, Outcome, Result, check_files};
use clap::Args;
use std::path::PathBuf;

/// Add up moments files, in any order
#[derive(Args, Debug)]
pub(crate) struct Arguments {
    /// Moments files of one arm, each log in one of them only
    #[arg(required = true, value_name = "PART.moments")]
    parts: Vec<PathBuf>,
    /// Moments file to write
    #[arg(short, long, value_name = "ALL.moments")]
    output: PathBuf,
}

pub(crate) fn run(arguments: &Arguments) -> Result<Outcome> {
    check_files(&arguments.parts, [(arguments.output.as_path(), &[][..])])?;
    let (first, others) = arguments.parts.split_at(1);
    let mut all = read_moments(&first[0])?;
    for file in others {
        let what = || format!("{} does not add to the parts before it", file.display());
        let added = all.merge(&read_moments(file)?);
        added.map_err(|error| CliError::from(error).within(what()))?;
    }
    write_moments(&arguments.output, &all)
}
