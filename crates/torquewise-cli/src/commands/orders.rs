//! `orders`: the held-out residual at each order of the libraries, and the chosen orders.

use crate::arguments::{PatternArguments, kinds_of_joints};
use crate::signal_arguments::FilterArguments;
use crate::{Outcome, Result, Table, check_files, watch, write_whole};
use clap::Args;
use serde_json::{Value, json};
use std::path::PathBuf;
use torquewise::Rows;
use torquewise::identify::Warning;
use torquewise::model::{JointKinds, number};
use torquewise::report::{chart_figure, order_charts};
use torquewise::stepwise::orders::{OrderCurve, OrderPlan, OrderPoint, orders};

/// Show the residual at each order of the libraries, and the recommended orders
///
/// N1 is the number of sines and cosines in a term, N2 that of velocities and accelerations; the
/// steps have N2 fixed. Least squares on one half of the rows, judged on the other. The order
/// chosen is the first that no higher one improves by more than a tenth, the ratios of all joints
/// multiplied. Of a step only its own terms change with N1, those of the steps before stay at 4.
///
/// `fit --library product` takes the N1 of standstill as --gravity-order and that of the other
/// steps as --trig-order; `fit` takes that of the energy library as --interaction.
#[derive(Args, Debug)]
pub(crate) struct Arguments {
    /// Logs of one arm
    #[arg(required = true, value_name = "LOG")]
    logs: Vec<PathBuf>,
    /// Figure to write
    #[arg(short, long, value_name = "FILE.svg")]
    output: Option<PathBuf>,
    /// Product library, step by step: largest number of sines and cosines in a term
    #[arg(help_heading = "Orders", long, value_name = "N", default_value_t = OrderPlan::default().trig_order)]
    #[arg(value_parser = clap::value_parser!(u8).range(1..=8))]
    trig_order: u8,
    /// The same for the whole library in one shot
    #[arg(help_heading = "Orders", long, value_name = "N", default_value_t = OrderPlan::default().whole_order)]
    #[arg(value_parser = clap::value_parser!(u8).range(1..=8))]
    whole_order: u8,
    /// Energy library: largest number of joint angles in a term
    #[arg(help_heading = "Orders", long, value_name = "K", default_value_t = 4)]
    #[arg(value_parser = clap::value_parser!(u8).range(1..=16))]
    interaction: u8,
    /// Which joints turn and which slide, base to tip, as r,r,p,r or RRPR [default: all turn]
    #[arg(long, value_name = "KINDS", value_parser = kinds_of_joints())]
    kinds: Option<String>,
    #[command(flatten)]
    patterns: PatternArguments,
    #[command(flatten)]
    filter: FilterArguments,
}

pub(crate) fn run(arguments: &Arguments) -> Result<Outcome> {
    let figure = arguments.output.iter().map(|file| (file.as_path(), &["svg"][..]));
    check_files(&arguments.logs, figure)?;
    let log = arguments.filter.signals.open(&arguments.logs)?;
    log.files.require_tau()?;
    let logs = arguments.filter.prepare(&log, Rows::Filtered)?;
    let kinds = arguments.kinds.as_deref().and_then(JointKinds::read).unwrap_or_default();
    let plan = OrderPlan {
        kinds,
        trig_order: arguments.trig_order,
        whole_order: arguments.whole_order,
        interaction: arguments.interaction.into(),
        patterns: arguments.patterns.plan()?,
    };
    let curves = orders(&logs.watched(&watch(), "trying orders"), &plan)?;
    let mut text: Vec<String> =
        curves.iter().map(|curve| curve_text(curve, log.joints())).collect();
    if let Some(file) = &arguments.output {
        let names = arguments.logs.iter().map(|log| log.display().to_string()).collect::<Vec<_>>();
        let charts = order_charts(&[(names.join(", "), curves.as_slice())]);
        write_whole(file, &chart_figure("Residual against order", &charts, 2)?)?;
        text.push(format!("figure: {}\n", file.display()));
    }
    let json = json!({
        "joints": log.joints(),
        "libraries": curves.iter().map(curve_json).collect::<Vec<_>>(),
        "file": arguments.output.as_ref().map(|file| file.display().to_string()),
    });
    let warnings =
        Warning::of_orders(&curves, log.joints()).iter().map(ToString::to_string).collect();
    Ok(Outcome { text: text.concat(), json, warnings, ..Outcome::default() })
}

fn curve_json(curve: &OrderCurve) -> Value {
    let point = |point: &OrderPoint| {
        let percent = |residuals: &[f64]| residuals.iter().map(|r| 100.0 * r).collect::<Vec<_>>();
        json!({
            "order": point.order,
            "motion_order": point.motion_order,
            "candidates": point.candidates,
            "residual_percent": percent(&point.residual),
            "fitted_percent": percent(&point.fitted),
            "suffices": point.suffices(),
        })
    };
    json!({
        "name": curve.name,
        "rows": curve.rows,
        "points": curve.points.iter().map(point).collect::<Vec<_>>(),
        "chosen": curve.points.get(curve.chosen).map(point),
    })
}

fn curve_text(curve: &OrderCurve, joints: &[String]) -> String {
    let whole = curve.points.iter().any(|point| point.motion_order > 0);
    let order = if curve.name == "energy" { "interaction" } else { "N1" };
    let numbers = [Some(order), whole.then_some("N2"), Some("candidates")].into_iter().flatten();
    let errors = joints.iter().map(|name| format!("{name} [%]"));
    let mut table = Table::new(numbers.map(String::from).chain(errors).chain([String::new()]));
    for (place, point) in curve.points.iter().enumerate() {
        let mut cells = Vec::new();
        cells.extend(whole.then(|| point.motion_order.to_string()));
        cells.push(point.candidates.to_string());
        cells.extend(point.residual.iter().map(|residual| number(100.0 * residual)));
        let mark = if point.suffices() { "<- chosen" } else { "<- best, and of little use" };
        cells.extend((place == curve.chosen).then(|| mark.to_owned()));
        table.row(&point.order.to_string(), cells);
    }
    format!(
        "{}, {} rows, held-out residual of std(tau):\n{}\n",
        curve.name,
        curve.rows,
        table.text()
    )
}
