//! What hangs on the last link of an arm whose model is known.

use crate::error::Result;
use crate::files::{check_files, read_model, staged};
use crate::outcome::{Outcome, object};
use crate::progress::watch;
use crate::signal_arguments::SignalArguments;
use crate::table::Table;
use clap::Args;
use serde_json::json;
use std::path::PathBuf;
use torquewise::model::number;
use torquewise::model::shaft_friction::Estimated;
use torquewise::payload::payload;

/// Estimate the load on the last link from seconds of motion, with a model of the bare arm
#[derive(Args, Debug)]
pub(crate) struct Arguments {
    /// Model of the arm without the load
    model: PathBuf,
    /// Logs of the arm with the load
    #[arg(required = true, value_name = "LOG")]
    logs: Vec<PathBuf>,
    /// Model to write: the arm that carries the load
    #[arg(short, long, value_name = "MODEL.json")]
    output: Option<PathBuf>,
    #[command(flatten)]
    signals: SignalArguments,
}

/// Names of the components, and their unit.
const ROWS: [(&[&str], &str); 3] = [
    (&["mass"], "kg"),
    (&["centre x", "centre y", "centre z"], "m"),
    (&["Ixx", "Iyy", "Izz", "Ixy", "Ixz", "Iyz"], "kg m2"),
];

pub(crate) fn run(arguments: &Arguments) -> Result<Outcome> {
    let inputs = arguments.logs.iter().chain([&arguments.model]);
    check_files(inputs, arguments.output.iter().map(|file| (file.as_path(), &[][..])))?;
    let model = read_model(&arguments.model)?;
    let log = arguments.signals.open(&arguments.logs)?;
    let found = payload(&model, &log, &watch())?;
    let mut table = Table::new(["load", "value", "±", "unit"]);
    let all = std::iter::once(found.mass).chain(found.center).chain(found.inertia);
    let names = ROWS.iter().flat_map(|(names, unit)| names.iter().map(move |name| (name, unit)));
    for ((name, unit), estimated) in names.zip(all) {
        let Estimated { value, std_error } = estimated;
        table.row(name, [number(value), number(std_error), (*unit).to_owned()]);
    }
    let frame = found.link.as_ref().map_or_else(
        || "z along the last axis, origin where it is next to the axis before".to_owned(),
        |link| format!("frame of {link}"),
    );
    let mut text = format!(
        "{} rows; {frame}; ± is one standard error, moments are about the centre\n\n{}\n",
        found.rows,
        table.text()
    );
    let mut left = Table::new(["torque left [N m]", "without load", "with load"]);
    let pairs = found.residual_without.iter().zip(&found.residual_with);
    for (joint, (without, with)) in model.joints.iter().zip(pairs) {
        left.row(joint, [number(*without), number(*with)]);
    }
    text += &left.text();
    let mut json = object(&found);
    if let Some(output) = &arguments.output {
        found.added_to(&model)?.save(staged(output)?)?;
        let file = output.display().to_string();
        text.extend([format!("\nmodel of the arm with its load: {file}\n")]);
        json["file"] = json!(file);
    }
    let warnings = found.hints().into_iter().map(str::to_owned).collect();
    Ok(Outcome { text, json, warnings, ..Outcome::default() })
}
