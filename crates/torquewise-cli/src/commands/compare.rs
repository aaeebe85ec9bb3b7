//! Stepwise reconstruction beside one-shot SINDy.

use crate::arguments::PlanArguments;
use crate::error::Result;
use crate::outcome::{Outcome, object};
use crate::progress::watch;
use crate::signal_arguments::{FilterArguments, ProfileArguments};
use crate::table::Table;
use clap::Args;
use std::path::PathBuf;
use torquewise::compare::{Contender, compare};
use torquewise::identify::plan::Regression;
use torquewise::log::Rows;
use torquewise::model::number;
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

/// Fits with both methods and scores both.
pub(crate) fn run(arguments: &Arguments) -> Result<Outcome> {
    let options = arguments.plan.options(Regression::Stepwise);
    let open = |paths: &[PathBuf]| -> Result<_> {
        let log = arguments.filter.open(&arguments.profile, paths)?;
        log.files().require_tau()?;
        Ok(log)
    };
    let train = arguments.filter.prepare(&open(&arguments.logs)?, Rows::Filtered)?;
    let test = open(&arguments.test)?.prepare_as(train.filter(), Rows::Filtered)?;
    let compared = compare(&train, &test, &options, &watch())?;
    let contenders = [("stepwise", &compared.stepwise), ("sindy", &compared.sindy)];
    let warnings = contenders.iter().flat_map(|(name, contender)| {
        contender.fit.warnings.iter().map(move |warning| format!("{name}: {warning}"))
    });
    Ok(Outcome {
        text: text(&contenders, train.joints()),
        warnings: warnings.collect(),
        json: object(&compared),
        notes: Vec::new(),
        ..Outcome::default()
    })
}

fn text(contenders: &[(&str, &Contender)], joints: &[String]) -> String {
    let names: Vec<String> = joints.iter().map(|name| format!("NRMSE {name} [%]")).collect();
    let headings: Vec<&str> = ["method", "candidates", "active", "seconds"]
        .into_iter()
        .chain(names.iter().map(String::as_str))
        .collect();
    let mut table = Table::new(&headings);
    for (name, contender) in contenders {
        let counts = [contender.candidates, contender.active_total].map(|count| count.to_string());
        let seconds = format!("{:.2}", contender.seconds);
        let errors = contender.nrmse_percent.iter().map(|error| number(*error));
        table.row(name, counts.into_iter().chain([seconds]).chain(errors));
    }
    table.text()
}
