//! The whole way at once: a log, its patterns, its equations, and how well they predict.

use super::fit::date;
use crate::files::{check_rows, create_folder, read_arm};
use crate::table::methods;
use crate::{Outcome, Result, Table, staged, watch, write_whole};
use clap::Args;
use serde::Serialize;
use serde_json::{Value, json};
use std::path::PathBuf;
use std::time::SystemTime;
use torquewise::dynamics::{MotionKind, MotionPlan, Noise, add_noise, simulate};
use torquewise::logs::write_motion;
use torquewise::model::print;
use torquewise::model::selection::Selection;
use torquewise::motion::{Motion, Pattern};
use torquewise::page::{LogFile, Origin, page};
use torquewise::report::html::Colour;
use torquewise::report::{chart_figure, torque_charts};
use torquewise::{Evaluation, Fit, FitOptions, FitResult, Library, Log, Torque};

/// Simulate the reference arm, reconstruct it, print and plot what was found
#[derive(Args, Debug)]
pub(crate) struct Arguments {
    /// Folder for log, models, figure and report
    #[arg(short, long, value_name = "DIR", default_value = "torquewise-demo")]
    output: PathBuf,
    /// Arm to reconstruct; the default is that of the paper
    #[arg(long, default_value = "puma560-3")]
    arm: String,
    /// Recorded time in seconds; a million rows at most
    ///
    /// The default takes 5 s and 0.7 GB. One-shot SINDy keeps most of its 3612 candidates where the
    /// motion is short: 60 s take a minute and 3 GB.
    #[arg(long, value_name = "S", default_value_t = 600.0)]
    seconds: f64,
    /// Rows per second
    #[arg(long, value_name = "HZ", default_value_t = 100.0)]
    rate: f64,
    /// Seed of motion and noise
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Noise level: 1 none, 2 70/50/30 dB, 3 60/40/30 dB on q/dq/ddq
    #[arg(long, value_name = "1|2|3", default_value_t = 3)]
    #[arg(value_parser = clap::value_parser!(u8).range(1..=3))]
    case: u8,
}

const MOST_ROWS: f64 = 1e6;

/// Length of the motion that models are judged by \[s\].
const TEST_SECONDS: f64 = 20.0;

struct Found {
    name: &'static str,
    file: &'static str,
    fit: FitResult,
    scores: Evaluation,
}

/// Rows of a pattern, and the share of them that truly show it.
#[derive(Serialize)]
struct Purity {
    name: &'static str,
    rows: usize,
    #[serde(rename = "purity_percent")]
    percent: f64,
}

pub(crate) fn run(arguments: &Arguments) -> Result<Outcome> {
    let Arguments { seconds, rate, seed, case, .. } = *arguments;
    check_rows(seconds, rate, MOST_ROWS)?;
    let (arm, _) = read_arm(&arguments.arm, &[], None)?;
    let plan = MotionPlan { kind: MotionKind::Moves, seconds, rate, seed };
    let clean = simulate(&arm, &plan)?;
    let log = add_noise(&clean.motion, &Noise::case(case)?, seed)?;
    let kind = MotionKind::Sines;
    let unseen = MotionPlan { kind, seconds: TEST_SECONDS, rate, seed: seed.wrapping_add(1) };
    let test = simulate(&arm, &unseen)?.motion;
    create_folder(&arguments.output)?;
    let file = staged(&arguments.output.join("log.csv"))?;
    write_motion(&file, &log)?;
    let recorded = Log::open(&file)?;

    let product = FitOptions { library: Some(Library::Product), ..FitOptions::default() };
    let methods = [
        ("energy library", "energy.json", FitOptions::default()),
        ("product library", "product.json", product),
        ("one-shot SINDy", "sindy.json", FitOptions::sindy()),
    ];
    let mut found = Vec::with_capacity(methods.len());
    for (name, file, options) in methods {
        let options = FitOptions { seed, ..options };
        let fit = Fit::new(&recorded).options(options).observer(&watch()).run()?;
        let scores = fit.evaluate(&test)?;
        found.push(Found { name, file, fit, scores });
    }
    let purities = purities(&found[0], &log, &clean.truth);
    write_files(arguments, &found, &figure(arm.name(), &test, &found)?)?;

    let warnings = found[0].fit.warnings.iter().map(ToString::to_string).collect();
    let text = text(arguments, &log, &purities, &found);
    let json = json(arguments, &log, &purities, &found);
    Ok(Outcome { text, json, warnings, ..Outcome::default() })
}

fn purities(found: &Found, log: &Motion, truth: &[Pattern]) -> Vec<Purity> {
    let labels = found.fit.patterns.label(log);
    let purity = |pattern| {
        let labelled = labels.iter().zip(truth).filter(|(label, _)| **label == pattern);
        let rows = labelled.clone().count();
        let right = labelled.filter(|(_, truth)| **truth == pattern).count();
        let percent = 100.0 * right as f64 / rows as f64;
        Purity { name: pattern.name(), rows, percent }
    };
    Pattern::ALL.into_iter().map(purity).collect()
}

/// Measured torque, the energy library and the baseline; all others lie on the first.
fn figure(arm: &str, test: &Motion, found: &[Found]) -> Result<String> {
    let drawn = found.last().into_iter().chain(found.first()).enumerate();
    let line = |(place, found): (usize, &Found)| -> Result<_> {
        let torque = Torque::new(&found.fit.model).over(test)?;
        Ok((found.name.to_owned(), Colour::Series(1 - place), torque))
    };
    let lines = drawn.map(line).collect::<Result<Vec<_>>>()?;
    let mut charts = torque_charts(("measured", test), 1, &lines, None)?;
    for (chart, joint) in charts.iter_mut().zip(test.joints()) {
        chart.title.clone_from(joint);
    }
    Ok(chart_figure(&format!("{arm}: torque of a motion outside the training set"), &charts, 1)?)
}

fn write_files(arguments: &Arguments, found: &[Found], svg: &str) -> Result<()> {
    let folder = &arguments.output;
    let date = date(SystemTime::now());
    let origin = Origin {
        logs: &[LogFile { name: "log.csv".into(), date: date.clone() }],
        tests: &[],
        model: &folder.join(found[0].file).display().to_string(),
        command: "torquewise demo",
        date: &date,
    };
    let html = page(&found[0].fit, None, origin, &watch())?.unwrap_or_default();
    for found in found {
        found.fit.model.save(staged(&folder.join(found.file))?)?;
    }
    write_whole(&folder.join("report.html"), html)?;
    write_whole(&folder.join("torque.svg"), svg)
}

fn text(arguments: &Arguments, log: &Motion, purities: &[Purity], found: &[Found]) -> String {
    let Arguments { arm, seconds, rate, case, output, .. } = arguments;
    let mut patterns = Table::new(["pattern", "rows", "purity [%]"]);
    for purity in purities {
        let cells = [purity.rows.to_string(), format!("{:.2}", purity.percent)];
        patterns.row(purity.name, cells);
    }
    let scores = methods(
        log.joints(),
        found.iter().map(|Found { name, fit, scores, .. }| {
            let errors = scores.joints.iter().map(|joint| joint.nrmse_percent);
            (*name, fit, errors.collect())
        }),
    );
    format!(
        "{arm}: {} rows, {seconds} s at {rate} Hz, noise of case {case}\n\n\
         Patterns, and how much of each truly is one:\n\n{}\n\
         Equations found with the energy library:\n\n{}\n\
         Torque of a motion outside the training set, {TEST_SECONDS} s of sines without noise:\
         \n\n{}\n\
         log, models and figure: {}\nreport: {}\n\n\
         next: open the report; then `torquewise inspect LOG` says what a log of your own holds,\n\
         and `torquewise fit LOG -o model.json --report report.html` learns the arm from it\n",
        log.n_rows(),
        patterns.text(),
        print::text(&found[0].fit.model, &Selection::default()),
        scores.text(),
        output.display(),
        output.join("report.html").display(),
    )
}

fn json(arguments: &Arguments, log: &Motion, purities: &[Purity], found: &[Found]) -> Value {
    let file = |name: &str| arguments.output.join(name).display().to_string();
    let methods = found.iter().map(|Found { name, file: model, fit, scores }| {
        let percent = scores.joints.iter().map(|joint| joint.nrmse_percent);
        json!({
            "name": name,
            "candidates": fit.candidates,
            "active": fit.model.active(),
            "active_total": fit.model.n_coefficients(),
            "seconds": fit.seconds,
            "nrmse_percent": percent.collect::<Vec<_>>(),
            "file": file(model),
        })
    });
    json!({
        "arm": arguments.arm,
        "rows": log.n_rows(),
        "patterns": purities,
        "methods": methods.collect::<Vec<_>>(),
        "log": file("log.csv"),
        "figure": file("torque.svg"),
        "report": file("report.html"),
    })
}
