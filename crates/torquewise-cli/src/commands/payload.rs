//! `payload`: the load on a link of an arm whose model is known.

use crate::arguments::fitting;
use crate::signal_arguments::SignalArguments;
use crate::{
    CliError, Outcome, Result, Table, check_files, object, read_model, staged, watch, write_whole,
};
use clap::Args;
use serde_json::json;
use std::path::PathBuf;
use torquewise::Log;
use torquewise::logs::{Profile, is_bag};
use torquewise::model::shaft_friction::Estimated;
use torquewise::model::{Model, number};
use torquewise::payload::{LoadPlace, Payload, gains, payload};

/// Estimate the load on a link from seconds of motion, with a model of the bare arm
#[derive(Args, Debug)]
pub(crate) struct Arguments {
    /// Model of the arm without the load
    model: PathBuf,
    /// Logs of the arm with the load
    #[arg(required = true, value_name = "LOG")]
    logs: Vec<PathBuf>,
    /// File to write: the model of the arm that carries the load, or with `--known-mass` the profile by
    /// which the torque columns are in N·m
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Link that carries the load: as the URDF calls it, or its joint [default: the last]
    #[arg(long, value_name = "NAME")]
    link: Option<String>,
    /// Centre of mass of the load in m, in the frame of the link, where it is known
    #[arg(
        long,
        value_name = "X,Y,Z",
        value_delimiter = ',',
        allow_hyphen_values = true,
        conflicts_with = "known_mass"
    )]
    #[arg(value_parser = fitting(|x: &f64| x.abs() <= 100.0, "expected a length in m, at most 100"))]
    center: Option<Vec<f64>>,
    /// Mass of the load in kg, where torque columns are currents or of unknown gain: finds what a unit
    /// of each is worth, with a model that was learned from the same columns
    #[arg(long, value_name = "KG")]
    #[arg(value_parser = fitting(|kg: &f64| *kg > 0.0 && *kg <= 1e4, "expected a mass above 0, at most 10000 kg"))]
    known_mass: Option<f64>,
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
    let center = match arguments.center.as_deref() {
        None => None,
        Some(&[x, y, z]) => Some([x, y, z]),
        Some(_) => return Err(CliError::Usage("--center expects three numbers in m".to_owned())),
    };
    let link = arguments.link.as_deref();
    let place = LoadPlace::named(&model, link, center).ok_or_else(|| {
        let (name, joints) = (link.unwrap_or(""), model.joints.join(", "));
        CliError::Usage(format!("no link of the model is called {name}; its joints are {joints}"))
    })?;
    let log = arguments.signals.open(&arguments.logs)?;
    if let Some(mass) = arguments.known_mass {
        return run_gains(arguments, &model, &log, (place, mass));
    }
    let found = payload(&model, &log, place, &watch())?;
    let mut text = load_text(&found) + "\n";
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
    Ok(Outcome { text, json, warnings: found.hints(), ..Outcome::default() })
}

/// The load as a table, with its frame and the rows it was found on.
pub(super) fn load_text(found: &Payload) -> String {
    let mut table = Table::new(["load", "value", "±", "unit"]);
    let all = std::iter::once(found.mass).chain(found.center).chain(found.inertia);
    let names = ROWS.iter().flat_map(|(names, unit)| names.iter().map(move |name| (name, unit)));
    for ((name, unit), estimated) in names.zip(all) {
        let Estimated { value, std_error } = estimated;
        table.row(name, [number(value), number(std_error), (*unit).to_owned()]);
    }
    let frame = found.link.as_ref().map_or_else(
        || "z along the axis of its joint, origin where it is next to the axis before".to_owned(),
        |link| format!("frame of {link}"),
    );
    format!(
        "{} rows; {frame}; ± is one standard error, moments are about the centre\n\n{}",
        found.rows,
        table.text()
    )
}

fn run_gains(
    arguments: &Arguments,
    model: &Model,
    log: &Log,
    (place, mass): (LoadPlace, f64),
) -> Result<Outcome> {
    let found = gains(model, log, place, mass, &watch())?;
    let told = found.told();
    let mut table = Table::new(["gain", "N m per unit", "±"]);
    for (joint, gain) in model.joints.iter().zip(&found.gains) {
        table.row(joint, [number(gain.value), number(gain.std_error)]);
    }
    let mut text = format!(
        "{} rows; a load of {} kg, which the torque columns as they are weigh at {} kg; ± is one \
         standard error\n\n{}",
        found.rows,
        number(mass),
        number(found.apparent_mass),
        table.text()
    );
    let mut json = object(&found);
    if let Some(output) = &arguments.output {
        let usual = || {
            if arguments.logs.iter().any(|log| is_bag(log)) {
                Profile { joints: model.joints.clone(), ..Profile::default() }
            } else {
                Profile::usual([log.files.has_dq(), log.files.has_ddq()])
            }
        };
        let profile = arguments.signals.profile()?.unwrap_or_else(usual);
        let gains = found.gains.iter().zip(&told);
        let gains: Vec<f64> =
            gains.map(|(gain, told)| if *told { gain.value } else { 1.0 }).collect();
        write_whole(output, profile.with_gains(&gains).to_toml())?;
        let file = output.display().to_string();
        text.extend([format!("\nprofile: {file}; fit again with `--profile {file}`\n")]);
        json["file"] = json!(file);
    }
    Ok(Outcome { text, json, warnings: found.hints(), ..Outcome::default() })
}
