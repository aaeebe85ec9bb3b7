//! Torque that others put on an arm, and when they touched it.

use crate::arguments::parsed;
use crate::signal_arguments::SignalArguments;
use crate::{Outcome, Result, TABLES, Table, check_files, read_model, staged, watch, write_whole};
use clap::Args;
use serde_json::json;
use std::path::PathBuf;
use torquewise::external::{Contact, External, ExternalOptions, contacts};
use torquewise::logs::{Column, TableWriter, Values};
use torquewise::model::{Model, number};
use torquewise::motion::repairs::counted;
use torquewise::report::chart_figure;
use torquewise::report::html::{Chart, Growing, Series};

/// External torque of a log by the momentum observer, and contacts beyond a threshold
///
/// The table has t, tau_external and the threshold of each joint, which follows the motion, without the
/// first moments of each trajectory, in which the observer settles.
#[derive(Args, Debug)]
pub(crate) struct Arguments {
    /// Model file
    model: PathBuf,
    /// Logs of the arm
    #[arg(required = true, value_name = "LOG")]
    logs: Vec<PathBuf>,
    /// Table to write, .csv or .parquet
    #[arg(help_heading = "Output", short, long, value_name = "FILE")]
    output: PathBuf,
    /// Log of the arm that nothing touches, to set the thresholds by; repeat for several [default:
    /// the logs themselves, contacts being the exception]
    #[arg(help_heading = "Detection", long, value_name = "LOG")]
    free: Vec<PathBuf>,
    /// False alarms of the whole arm in an hour of free motion
    #[arg(help_heading = "Detection", long, value_name = "PER HOUR", default_value_t = ExternalOptions::default().false_alarms_per_hour)]
    #[arg(value_parser = positive)]
    false_alarms: f64,
    /// Bandwidth of the observer in Hz
    #[arg(help_heading = "Detection", long, value_name = "HZ", default_value_t = ExternalOptions::default().bandwidth)]
    #[arg(value_parser = positive)]
    bandwidth: f64,
    /// Figure to write: external torque over time, with its thresholds
    #[arg(help_heading = "Output", long, value_name = "FILE.svg")]
    figure: Option<PathBuf>,
    #[command(flatten)]
    signals: SignalArguments,
}

/// Contacts that are printed; the JSON has all.
const MOST_PRINTED: usize = 30;

fn positive(text: &str) -> Result<f64, String> {
    parsed(text, |x| *x > 0.0 && *x <= 1e4, "expected a number above 0, at most 10000")
}

pub(crate) fn run(arguments: &Arguments) -> Result<Outcome> {
    let inputs = arguments.logs.iter().chain(&arguments.free).chain([&arguments.model]);
    let figure = arguments.figure.iter().map(|file| (file.as_path(), &["svg"][..]));
    check_files(inputs, figure.chain([(arguments.output.as_path(), TABLES)]))?;
    let model = read_model(&arguments.model)?;
    let log = arguments.signals.open(&arguments.logs)?;
    let free = Some(&arguments.free).filter(|free| !free.is_empty());
    let free = free.map(|free| arguments.signals.open(free)).transpose()?;
    let options = ExternalOptions {
        bandwidth: arguments.bandwidth,
        false_alarms_per_hour: arguments.false_alarms,
    };
    let columns = Column::of_joints(&["tau_external", "threshold"], model.n_joints());
    let mut table = TableWriter::create(&staged(&arguments.output)?, &columns)?;
    let mut rows = 0;
    let mut curves = vec![<[Growing; 3]>::default(); model.n_joints()];
    let found =
        contacts(&model, &log, free.as_ref(), options, &watch(), &mut |t, external, most| {
            if external.iter().any(|x| x.is_nan()) {
                return Ok(());
            }
            for ((curves, x), most) in curves.iter_mut().zip(external).zip(most) {
                curves.iter_mut().zip([*x, *most, -most]).for_each(|(own, y)| own.push([t, y]));
            }
            rows += 1;
            let row: Vec<f64> = [&[t][..], external, most].concat();
            Ok(table.append(&row.chunks(1).map(Values::Numbers).collect::<Vec<_>>())?)
        })?;
    table.finish()?;
    let mut outcome = outcome(arguments, &model, &found, rows);
    if let Some(file) = &arguments.figure {
        let charts = charts(curves, &model);
        write_whole(file, &chart_figure("External torque", &charts, 2)?)?;
        outcome.text.extend([format!("figure: {}\n", file.display())]);
        outcome.json["figure"] = json!(file.display().to_string());
    }
    Ok(outcome)
}

fn charts(curves: Vec<[Growing; 3]>, model: &Model) -> Vec<Chart> {
    let chart = |(curves, name): ([Growing; 3], &String)| {
        let names = ["external torque", "+ threshold", "− threshold"];
        let series = names.into_iter().zip(curves);
        let series = series.map(|(name, curve)| Series::line(name, curve.into_points())).collect();
        Chart::over(name, ["time [s]", "external torque [N·m]"], series)
    };
    curves.into_iter().zip(&model.joints).map(chart).collect()
}

fn outcome(
    arguments: &Arguments,
    model: &Model,
    External { thresholds, contacts: found, spikes, warnings: outside }: &External,
    rows: u64,
) -> Outcome {
    let mut table = Table::new(["threshold [N·m]", "in motion", "at rest"]);
    let both = thresholds.torque.iter().zip(&thresholds.at_rest);
    for (name, (most, rest)) in model.joints.iter().zip(both) {
        table.row(name, [number(*most), number(*rest)]);
    }
    let mut text = format!(
        "thresholds for {} false alarms an hour, from {:.0} s of {}\n\n{}\n{}\n",
        number(thresholds.false_alarms_per_hour),
        thresholds.seconds,
        if arguments.free.is_empty() { "these logs" } else { "free motion" },
        table.text(),
        counted(found.len() as u64, "contact", "found")
    );
    if !found.is_empty() {
        let mut table =
            Table::new(["from [s]", "to [s]", "joint", "largest [N·m]", "of threshold"]);
        for contact in found.iter().take(MOST_PRINTED) {
            let Contact { begin, end, joint, torque, factor } = contact;
            let cells =
                [format!("{end:.3}"), joint.clone(), number(*torque), format!("{factor:.1}")];
            table.row(&format!("{begin:.3}"), cells);
        }
        text.extend([format!("\n{}", table.text())]);
        if found.len() > MOST_PRINTED {
            text.extend([format!("and {} more: --json has all\n", found.len() - MOST_PRINTED)]);
        }
    }
    let blind = &thresholds.blind;
    let (seen, needed) = (thresholds.seconds, 3600.0 / thresholds.false_alarms_per_hour);
    let few = || format!("{seen:.0} s were seen for thresholds, {needed:.0} s have a false alarm");
    let note = (seen < needed).then(few);
    let blows = || {
        format!(
            "spikes of torque that were replaced: {spikes}; blows of a few rows are replaced alike, look \
             for these by --filter none"
        )
    };
    let file = arguments.output.display().to_string();
    text.extend([format!("\nexternal torque: {file} ({rows} rows)\n")]);
    let json = json!({
        "joints": model.joints,
        "thresholds": thresholds.torque,
        "thresholds_at_rest": thresholds.at_rest,
        "false_alarms_per_hour": thresholds.false_alarms_per_hour,
        "bandwidth_hz": arguments.bandwidth,
        "contacts": found,
        "blind": blind,
        "rows": rows,
        "file": file,
    });
    let warnings = unseen(arguments, blind).into_iter().chain((*spikes > 0).then(blows)).collect();
    let notes = note.into_iter().chain(outside.iter().cloned()).collect();
    Outcome { text, json, warnings, notes, ..Outcome::default() }
}

/// What is said of blind joints, and what would help.
fn unseen(arguments: &Arguments, blind: &[String]) -> Option<String> {
    let more = if arguments.free.is_empty() {
        "record free motion like that of the log and give it by --free"
    } else {
        "give more free motion like that of the log"
    };
    (!blind.is_empty()).then(|| {
        format!(
            "contacts at {} go unseen: the threshold is over twice the spread of the torque that \
             was trained on; {more}, or train a better model",
            blind.join(", ")
        )
    })
}
