//! Stepwise reconstruction beside one-shot SINDy.

use crate::arguments::PlanArguments;
use crate::signal_arguments::FilterArguments;
use crate::table::methods;
use crate::{Outcome, Result, object, watch};
use clap::Args;
use std::path::PathBuf;
use torquewise::Rows;
use torquewise::compare::compare;
use torquewise::identify::warning::list;

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
    filter: FilterArguments,
}

pub(crate) fn run(arguments: &Arguments) -> Result<Outcome> {
    let options = arguments.plan.options("stepwise")?;
    let open = |paths: &[PathBuf]| -> Result<_> {
        let log = arguments.filter.signals.open(paths)?;
        log.files.require_tau()?;
        Ok(log)
    };
    let train = arguments.filter.prepare(&open(&arguments.logs)?, Rows::Filtered)?;
    let test = open(&arguments.test)?.prepare_as(train.filter(), Rows::Filtered)?;
    let compared = compare(train.rows(), test.rows(), &options, &watch())?;
    let contenders = [("stepwise", &compared.stepwise), ("sindy", &compared.sindy)];
    let joints = train.rows().joints();
    let warnings = contenders.iter().flat_map(|(name, contender)| {
        let useless: Vec<String> = (joints.iter().zip(contender.nrmse_percent()))
            .filter(|(_, error)| *error > 100.0 && error.is_finite())
            .map(|(joint, _)| joint.clone())
            .collect();
        let own = contender.fit.warnings.iter().map(ToString::to_string);
        let of_mean = (!useless.is_empty()).then(|| {
            format!("test torque of {} is predicted no better than by its mean", list(&useless))
        });
        own.chain(of_mean).map(move |warning| format!("{name}: {warning}"))
    });
    let rows = contenders.iter().map(|(name, found)| (*name, &found.fit, found.nrmse_percent()));
    let own = arguments.test.iter().filter(|file| arguments.logs.contains(file));
    let trained = own.map(|file| {
        let file = file.display();
        format!("{file} is in both: what is left of its own rows says nothing of others")
    });
    let rubs = train.filter().is_some() && options.friction.is_none();
    let of_friction = rubs.then(|| {
        "both libraries are without friction, which the joints of a real arm have: --friction linear"
            .to_owned()
    });
    Ok(Outcome {
        notes: of_friction.into_iter().chain(trained).collect(),
        text: methods(joints, rows).text(),
        warnings: warnings.collect(),
        json: object(&compared),
        ..Outcome::default()
    })
}
