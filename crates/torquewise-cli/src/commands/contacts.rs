//! Torque that others put on an arm, and when they touched it.

use crate::error::Result;
use crate::files::{check_files, read_model, staged, write_whole};
use crate::outcome::Outcome;
use crate::progress::watch;
use crate::signal_arguments::{ProfileArguments, SignalArguments};
use crate::table::Table;
use clap::Args;
use serde_json::json;
use std::path::PathBuf;
use torquewise::external::{Contact, ExternalOptions, Thresholds, contacts};
use torquewise::logs::{Column, ColumnKind, TableWriter, Values};
use torquewise::model::{Model, number};
use torquewise::motion::BLOCK_ROWS;
use torquewise::report::chart_figure;
use torquewise::report::html::{Axis, Chart, Guide, Series};

/// External torque of a log by the momentum observer, and contacts beyond a threshold
///
/// The table has t and tau_external of each joint, without the first moments of each trajectory, in
/// which the observer settles.
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
    profile: ProfileArguments,
    #[command(flatten)]
    signals: SignalArguments,
}

/// Contacts that are printed; the JSON has all.
const MOST_PRINTED: usize = 30;
/// Points of a curve in the figure: neighbours are joined where there are twice as many.
const POINTS: usize = 2_000;

fn positive(text: &str) -> Result<f64, String> {
    let known = text.parse().ok().filter(|x: &f64| x.is_finite() && *x > 0.0 && *x <= 1e4);
    known.ok_or_else(|| "expected a number above 0, at most 10000".to_owned())
}

/// Observes, lists and writes.
pub(crate) fn run(arguments: &Arguments) -> Result<Outcome> {
    let inputs = arguments.logs.iter().chain(&arguments.free).chain([&arguments.model]);
    let figure = arguments.figure.iter().map(|file| (file.as_path(), &["svg"][..]));
    check_files(inputs, figure.chain([(arguments.output.as_path(), &[][..])]))?;
    let model = read_model(&arguments.model)?;
    let log = arguments.profile.open(&arguments.logs, &arguments.signals)?;
    let free = Some(&arguments.free).filter(|free| !free.is_empty());
    let free = free.map(|free| arguments.profile.open(free, &arguments.signals)).transpose()?;
    let options = ExternalOptions {
        bandwidth: arguments.bandwidth,
        false_alarms_per_hour: arguments.false_alarms,
    };
    let mut table = Written::create(&arguments.output, model.n_joints())?;
    let mut curves = Curves::new(model.n_joints());
    let (thresholds, found) =
        contacts(&model, &log, free.as_ref(), options, &watch(), &mut |t, external| {
            if external.iter().any(|x| x.is_nan()) {
                return Ok(());
            }
            curves.push(t, external);
            Ok(table.push(t, external)?)
        })?;
    let rows = table.finish()?;
    let mut outcome = outcome(arguments, &model, &thresholds, &found, rows);
    if let Some(file) = &arguments.figure {
        let charts = curves.charts(&model, &thresholds);
        write_whole(file, &chart_figure("External torque", &charts, 2)?)?;
        outcome.text.extend([format!("figure: {}\n", file.display())]);
        outcome.json["figure"] = json!(file.display().to_string());
    }
    Ok(outcome)
}

/// The table, block by block.
struct Written {
    writer: TableWriter,
    columns: Vec<Vec<f64>>,
    rows: usize,
}

impl Written {
    fn create(file: &std::path::Path, n_joints: usize) -> Result<Self> {
        let names = (1..=n_joints).map(|joint| format!("tau_external{joint}"));
        let columns: Vec<Column> = std::iter::once("t".to_owned())
            .chain(names)
            .map(|name| Column::new(name.as_str(), ColumnKind::Number))
            .collect();
        let writer = TableWriter::create(&staged(file)?, &columns)?;
        Ok(Self { writer, columns: vec![Vec::new(); n_joints + 1], rows: 0 })
    }

    fn push(&mut self, t: f64, external: &[f64]) -> Result<(), torquewise::logs::LogError> {
        self.columns[0].push(t);
        self.columns[1..].iter_mut().zip(external).for_each(|(column, x)| column.push(*x));
        self.rows += 1;
        if self.columns[0].len() < BLOCK_ROWS { Ok(()) } else { self.flush() }
    }

    fn flush(&mut self) -> Result<(), torquewise::logs::LogError> {
        let values: Vec<Values<'_>> = self.columns.iter().map(|x| Values::Numbers(x)).collect();
        self.writer.append(&values)?;
        self.columns.iter_mut().for_each(Vec::clear);
        Ok(())
    }

    fn finish(mut self) -> Result<usize> {
        self.flush()?;
        self.writer.finish()?;
        Ok(self.rows)
    }
}

/// Curves for the figure: of neighbours the one that is farther from zero.
struct Curves {
    points: Vec<Vec<[f64; 2]>>,
    joined: usize,
    pending: usize,
}

impl Curves {
    fn new(n_joints: usize) -> Self {
        Self { points: vec![Vec::new(); n_joints], joined: 1, pending: 0 }
    }

    fn push(&mut self, t: f64, external: &[f64]) {
        let is_new = self.pending == 0;
        for (own, &x) in self.points.iter_mut().zip(external) {
            match own.last_mut() {
                Some(last) if !is_new => {
                    if x.abs() > last[1].abs() {
                        *last = [t, x];
                    }
                }
                _ => own.push([t, x]),
            }
        }
        self.pending = (self.pending + 1) % self.joined;
        if self.points.first().is_some_and(|own| own.len() > 2 * POINTS) {
            for own in &mut self.points {
                let larger = |pair: &[[f64; 2]]| {
                    pair.iter().copied().max_by(|a, b| a[1].abs().total_cmp(&b[1].abs()))
                };
                *own = own.chunks(2).filter_map(larger).collect();
            }
            self.joined *= 2;
        }
    }

    fn charts(self, model: &Model, thresholds: &Thresholds) -> Vec<Chart> {
        let chart = |((points, name), most): ((Vec<[f64; 2]>, &String), &f64)| Chart {
            title: name.clone(),
            x: Axis::named("time [s]"),
            y: Axis::named("external torque [N·m]"),
            guides: [1.0, -1.0].map(|sign| Guide::at_y(sign * most, "threshold")).to_vec(),
            series: vec![Series::line("external torque", points)],
            ..Chart::default()
        };
        self.points.into_iter().zip(&model.joints).zip(&thresholds.torque).map(chart).collect()
    }
}

fn outcome(
    arguments: &Arguments,
    model: &Model,
    thresholds: &Thresholds,
    found: &[Contact],
    rows: usize,
) -> Outcome {
    let mut table = Table::new(&["joint", "threshold [N·m]"]);
    for (name, most) in model.joints.iter().zip(&thresholds.torque) {
        table.row(name, [number(*most)]);
    }
    let mut text = format!(
        "thresholds for {} false alarms an hour, from {:.0} s of {}\n\n{}\n{} contacts\n",
        number(thresholds.false_alarms_per_hour),
        thresholds.seconds,
        if arguments.free.is_empty() { "these logs" } else { "free motion" },
        table.text(),
        found.len()
    );
    if !found.is_empty() {
        let mut table =
            Table::new(&["from [s]", "to [s]", "joint", "largest [N·m]", "of threshold"]);
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
    let file = arguments.output.display().to_string();
    text.extend([format!("\nexternal torque: {file} ({rows} rows)\n")]);
    let json = json!({
        "joints": model.joints,
        "thresholds": thresholds.torque,
        "false_alarms_per_hour": thresholds.false_alarms_per_hour,
        "bandwidth_hz": arguments.bandwidth,
        "contacts": found,
        "rows": rows,
        "file": file,
    });
    Outcome { text, json, ..Outcome::default() }
}
