//! How well a model predicts the torque of logs.

use crate::arguments::fitting;
use crate::signal_arguments::SignalArguments;
use crate::{Outcome, Result, object, read_model, score_table, watch};
use clap::Args;
use std::path::PathBuf;
use torquewise::Grade;
use torquewise::evaluate::{evaluate_prepared, prepare, rollouts};
use torquewise::summary::{all_repairs, repairs_text};

/// Compare the torque a model predicts with the torque measured
#[derive(Args, Debug)]
pub(crate) struct Arguments {
    /// Model file
    model: PathBuf,
    /// Logs of the arm
    #[arg(required = true, value_name = "LOG")]
    logs: Vec<PathBuf>,
    /// Simulate windows of the log from their measured state with the measured torque, and print how
    /// far they drift after these times
    #[arg(long, value_name = "S", value_delimiter = ',', default_missing_value = "0.2,0.5,1",
        num_args = 0..=1)]
    #[arg(value_parser = fitting(|s: &f64| *s > 0.0 && s.is_finite(), "give seconds above 0"))]
    rollout: Option<Vec<f64>>,
    /// Draw so many arms from the covariance of the model, simulate them too, with the noise of the
    /// measured state, and print how many of the windows end in the band of 90 % of them
    #[arg(long, value_name = "N", requires = "rollout")]
    #[arg(value_parser = fitting(|count: &usize| (2..=10_000).contains(count), "give 2 to 10000"))]
    samples: Option<usize>,
    /// Seed of the samples
    #[arg(long, default_value_t = 0, requires = "samples")]
    seed: u64,
    #[command(flatten)]
    signals: SignalArguments,
}

pub(crate) fn run(arguments: &Arguments) -> Result<Outcome> {
    let model = read_model(&arguments.model)?;
    let log = arguments.signals.open(&arguments.logs)?;
    let log = prepare(&model, &log)?;
    let mut scores = evaluate_prepared(&model, &log, &watch())?;
    if let Some(horizons) = &arguments.rollout {
        let mut horizons = horizons.clone();
        horizons.sort_by(f64::total_cmp);
        let samples = arguments.samples.map(|count| (count, arguments.seed));
        scores = scores.with_rollouts(rollouts(&model, &log, &horizons, samples)?);
    }
    let repairs = log.repairs();
    let verdict = &scores.verdict;
    let unusable = (verdict.grade == Grade::Unusable).then(|| verdict.to_string());
    let mut json = object(&scores);
    json["conditioning"] = all_repairs(&repairs);
    Ok(Outcome {
        text: format!(
            "{}{}\n{} rows\n\nverdict: {}\n{}{}",
            log.text(),
            score_table::text(&scores, &model.kinds()),
            scores.rows,
            scores.verdict,
            score_table::rollouts(&scores, &model.kinds()),
            repairs_text(&repairs)
        ),
        json,
        warnings: unusable.into_iter().chain(scores.warnings).chain(log.warnings()).collect(),
        notes: scores.notes,
        ..Outcome::default()
    })
}
