//! Logs, test log → stepwise reconstruction beside one-shot SINDy.

use crate::arguments::PlanArguments;
use crate::outcome::Outcome;
use crate::signal_arguments::{FilterArguments, ProfileArguments, Wanted};
use crate::table::{Table, number};
use crate::timed::{Timed, timed};
use anyhow::Result;
use clap::Args;
use serde_json::{Value, json};
use std::path::PathBuf;
use torquewise::identify::{Plan, Scores, score};
use torquewise::logs::Logs;
use torquewise::motion::Recording;

/// Compare stepwise reconstruction with one-shot SINDy
#[derive(Args, Debug)]
pub(crate) struct Arguments {
    /// Logs to fit on
    #[arg(required = true, value_name = "LOG")]
    logs: Vec<PathBuf>,
    /// Log to judge by; repeat for several
    #[arg(long, required = true, value_name = "LOG")]
    test: Vec<PathBuf>,
    #[command(flatten)]
    plan: PlanArguments,
    #[command(flatten)]
    profile: ProfileArguments,
    #[command(flatten)]
    filter: FilterArguments,
}

/// A method with what it found and how good that is.
struct Contender {
    name: &'static str,
    timed: Timed,
    scores: Scores,
}

/// Fits with both methods and scores both.
pub(crate) fn run(arguments: &Arguments) -> Result<Outcome> {
    let (stepwise, sindy) = arguments.plan.both_plans()?;
    let open = |paths: &[PathBuf]| -> Result<Logs> {
        let logs = arguments.profile.open(paths)?;
        logs.require_tau()?;
        Ok(logs)
    };
    let train = arguments.filter.prepare(open(&arguments.logs)?, Wanted::Filtered)?;
    let test = arguments.filter.prepare_like(&train, open(&arguments.test)?)?;
    let contend = |name, plan: &Plan| -> Result<Contender> {
        let timed = timed(&train, None, plan)?;
        let scores = score(&timed.found.model, &test)?;
        Ok(Contender { name, timed, scores })
    };
    let contenders = [contend("stepwise", &stepwise)?, contend("sindy", &sindy)?];

    let warnings = contenders.iter().flat_map(|contender| {
        let warnings = contender.timed.found.warnings.iter();
        warnings.map(|warning| format!("{}: {warning}", contender.name))
    });
    let json: serde_json::Map<String, Value> =
        contenders.iter().map(|contender| (contender.name.to_owned(), contender.json())).collect();
    let text = text(&contenders, train.joints());
    Ok(Outcome { notes: Vec::new(), text, warnings: warnings.collect(), json: Value::Object(json) })
}

impl Contender {
    fn json(&self) -> Value {
        let found = &self.timed.found;
        let percent: Vec<f64> = self.scores.joints.iter().map(|j| j.nrmse_percent).collect();
        let rmse: Vec<f64> = self.scores.joints.iter().map(|j| j.rmse).collect();
        json!({
            "candidates": found.candidates,
            "candidates_by_step":
                found.steps.iter().map(|step| step.candidates).collect::<Vec<_>>(),
            "seconds": self.timed.seconds,
            "active": found.model.active(),
            "active_total": found.model.n_coefficients(),
            "nrmse_percent": percent,
            "rmse": rmse,
        })
    }
}

fn text(contenders: &[Contender], joints: &[String]) -> String {
    let names: Vec<String> = joints.iter().map(|name| format!("NRMSE {name} [%]")).collect();
    let headings: Vec<&str> = ["method", "candidates", "active", "seconds"]
        .into_iter()
        .chain(names.iter().map(String::as_str))
        .collect();
    let mut table = Table::new(&headings);
    for contender in contenders {
        let found = &contender.timed.found;
        let scores = contender.scores.joints.iter().map(|joint| number(joint.nrmse_percent));
        let counts = [
            found.candidates.to_string(),
            found.model.n_coefficients().to_string(),
            format!("{:.2}", contender.timed.seconds),
        ];
        table.row(contender.name, counts.into_iter().chain(scores));
    }
    table.text()
}
