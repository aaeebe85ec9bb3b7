//! What one torque of a model costs a controller: operations, time, share of a period.

use crate::Table;
use serde_json::{Value, json};
use torquewise::export::{Cost, ExportError, torque_costs};
use torquewise::model::{Model, number};
use torquewise::report::fit_report::call_cost::RATES;

/// The cost of the torque after each step, with its name.
pub(crate) fn of(model: &Model) -> Result<Vec<(String, Cost)>, ExportError> {
    let steps = model.stages.iter().map(|stage| stage.name.clone());
    Ok(steps.chain(["refit".to_owned()]).zip(torque_costs(model)?).collect())
}

pub(crate) fn text(costs: &[(String, Cost)]) -> String {
    let shares = RATES.map(|rate| format!("of {} kHz [%]", 1e-3 * rate));
    let fixed = ["torque after", "+ - *", "sin cos exp tanh", "about [ns]"];
    let mut table = Table::new(fixed.map(String::from).into_iter().chain(shares));
    for (name, cost) in costs {
        let counts = [cost.operations, cost.functions].map(|count| count.to_string());
        let time = format!("{:.0}", 1e9 * cost.seconds());
        let shares = RATES.map(|rate| number(cost.percent_of_period(rate)));
        table.row(name, counts.into_iter().chain([time]).chain(shares));
    }
    format!("\nOne call in a controller, estimated for a desktop processor:\n\n{}", table.text())
}

pub(crate) fn json(costs: &[(String, Cost)]) -> Value {
    let each = costs.iter().map(|(name, cost)| {
        json!({
            "after": name,
            "operations": cost.operations,
            "functions": cost.functions,
            "seconds_estimated": cost.seconds(),
            "percent_of_period": RATES.map(|rate| cost.percent_of_period(rate)),
        })
    });
    json!({ "rates_hz": RATES, "torque": each.collect::<Vec<_>>() })
}
