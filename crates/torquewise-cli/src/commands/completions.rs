//! `completions`: a script that completes the words of the command line.

use crate::commands::CommandLine;
use crate::{CliError, Outcome, Result};
use clap::{Args, CommandFactory};
use clap_complete::{Shell, generate};
use serde_json::json;

/// Print the completion script of a shell
#[derive(Args, Debug)]
pub(crate) struct Arguments {
    /// Shell to complete in
    #[arg(value_enum)]
    shell: Shell,
}

pub(crate) fn run(arguments: &Arguments) -> Result<Outcome> {
    let mut script = Vec::new();
    generate(arguments.shell, &mut CommandLine::command(), "torquewise", &mut script);
    let text = String::from_utf8(script)
        .map_err(|error| CliError::Stdout { source: std::io::Error::other(error) })?;
    let json = json!({ "shell": arguments.shell.to_string(), "script": text });
    Ok(Outcome { text, json, ..Outcome::default() })
}
