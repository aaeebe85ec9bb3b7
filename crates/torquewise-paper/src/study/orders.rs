//! Residual against order for one-shot SINDy, each step and the energy library (Fig. 5).

use crate::error::{PaperError, within};
use crate::results::{Claim, Figure, Study, Table};
use crate::scenario::{Decibels, Settings};
use torquewise_report::order_charts;
use torquewise_stepwise::orders::{OrderCurve, OrderPlan, orders};

/// A residual has settled where it is below this part of what it was at first.
const SETTLED: f64 = 0.5;

/// Residuals without noise and with that of case 2.
pub(crate) fn study(settings: &Settings) -> Result<Study, PaperError> {
    let plan = OrderPlan {
        trig_order: settings.trig_order,
        whole_order: settings.whole_order,
        ..OrderPlan::default()
    };
    let mut table = Table::new(
        "The orders that the rule chooses: the first that no higher one improves by more than a \
         tenth, the ratios of all joints multiplied.",
        "noise;library;N₁ or angles in a term;N₂;candidates;held-out residual, worst joint [%]",
    );
    let mut logs = Vec::new();
    for case in [1, 2] {
        let noise = Decibels::case(case);
        let scenario = settings.scenario(noise, settings.seed);
        let log = scenario.record(&scenario.simulate()?)?;
        let curves = orders(&log, &plan).map_err(within("orders"))?;
        for curve in &curves {
            let point = &curve.points[curve.chosen];
            let order = |order: u8| if order > 0 { order.to_string() } else { "–".into() };
            table.push([
                noise.name().into(),
                curve.name.clone().into(),
                order(point.order).into(),
                order(point.motion_order).into(),
                point.candidates.into(),
                (100.0 * worst(curve, curve.chosen)).into(),
            ]);
        }
        logs.push((format!("noise {}", noise.name()), curves));
    }
    let named: Vec<_> = logs.iter().map(|(name, curves)| (name.clone(), &curves[..])).collect();
    let figure = Figure::new(
        "fig5_orders",
        "Fig. 5: least squares on one half of the rows, judged on the other: the residual of the \
         worst joint over the standard deviation of its torque. Of a step, only its own terms \
         change with N₁.",
        order_charts(&named),
    );
    Ok(Study {
        heading: "Orders (Fig. 5)",
        claims: vec![claim(&logs[0].1)],
        tables: vec![table],
        figures: vec![figure],
        ..Study::default()
    })
}

/// The residual of the worst joint at a point of a curve.
fn worst(curve: &OrderCurve, place: usize) -> f64 {
    curve.points[place].residual.iter().copied().fold(0.0, f64::max)
}

fn claim(clean: &[OrderCurve]) -> Claim {
    let chosen = clean.iter().map(|curve| {
        let point = &curve.points[curve.chosen];
        let first = if curve.name == "energy" { "interaction" } else { "N₁" };
        let second = match point.motion_order {
            0 => String::new(),
            order => format!(", N₂ = {order}"),
        };
        format!("{}: {first} = {}{second}", curve.name, point.order)
    });
    let has_settled = |curve: &&OrderCurve| {
        curve.chosen == 0 || worst(curve, curve.chosen) <= SETTLED * worst(curve, 0)
    };
    let settled = clean.iter().filter(has_settled).count();
    let chosen: Vec<String> = chosen.collect();
    Claim::new(
        "Fig. 5",
        "The least-squares residual falls fast up to a certain order and hardly beyond it, which \
         gives the orders of each library.",
        format!("Orders chosen without noise: {}.", chosen.join("; ")),
        [settled == clean.len(), settled > 0],
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::results::Cell;

    #[test]
    fn without_noise_the_energy_library_is_exact_at_the_order_of_the_arm() {
        let settings = Settings { whole_order: 2, trig_order: 2, ..Settings::quick(1) };

        let found = study(&settings).unwrap();

        let rows = &found.tables[0].rows;
        let energy = rows.iter().find(|row| row[1] == "energy".into()).unwrap();
        assert!(matches!(energy[5], Cell::Number(percent) if percent < 1e-3), "{energy:?}");
    }
}
