//! Residual against order for one-shot SINDy, each step and the energy library (Fig. 5).

use crate::{Cell, Result, Settings, Study, within};
use torquewise_report::order_charts;
use torquewise_sim::Noise;
use torquewise_stepwise::orders::{OrderPlan, orders};

/// A residual has settled where it is below this part of what it was at first.
const SETTLED: f64 = 0.5;

/// Residuals without noise and with that of case 2.
pub(crate) fn study(settings: &Settings) -> Result<Study> {
    let plan = OrderPlan {
        trig_order: settings.trig_order,
        whole_order: settings.whole_order,
        ..OrderPlan::default()
    };
    let mut study = Study::described("orders", 0);
    let (mut logs, mut chosen, mut settled) = (Vec::new(), Vec::new(), Vec::new());
    for (case, noise) in Noise::CASES.into_iter().enumerate().take(2) {
        let scenario = settings.scenario(noise);
        let log = scenario.record(&scenario.simulate()?)?;
        let curves = orders(&log, &plan).map_err(within("orders"))?;
        for curve in &curves {
            let point = &curve.points[curve.chosen];
            let order = |order: u8| if order > 0 { order.to_string() } else { "–".into() };
            let [first, residual] = [0, curve.chosen]
                .map(|place| curve.points[place].residual.iter().copied().fold(0.0, f64::max));
            let head = [noise.to_string(), curve.name.clone()].map(Cell::from);
            let orders = [point.order, point.motion_order].map(|number| order(number).into());
            let found: [Cell; 2] = [point.candidates.into(), (100.0 * residual).into()];
            study.tables[0].push(&[head, orders].concat(), found);
            if case == 0 {
                let what = if curve.name == "energy" { "interaction" } else { "N₁" };
                let second = format!(", N₂ = {}", point.motion_order);
                let second = if point.motion_order > 0 { second } else { String::new() };
                chosen.push(format!("{}: {what} = {}{second}", curve.name, point.order));
                settled.push(curve.chosen == 0 || residual <= SETTLED * first);
            }
        }
        logs.push((format!("noise {noise}"), curves));
    }
    let named: Vec<_> = logs.iter().map(|(name, curves)| (name.clone(), &curves[..])).collect();
    study.figures[0].charts = order_charts(&named);
    study.claims[0].judge([chosen.join("; ")], &settled);
    Ok(study)
}
