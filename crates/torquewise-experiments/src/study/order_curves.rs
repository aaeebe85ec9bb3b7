//! From log to residual against order for one-shot SINDy, each step and the energy library (Fig.
//! 5).

use crate::error::{ExperimentError, within};
use crate::scenario::Decibels;
use crate::settings::Settings;
use serde::Serialize;
use torquewise_stepwise::orders::{OrderCurve, OrderPlan, orders};

/// Residuals against order at one level of noise.
#[derive(Clone, Debug, Serialize)]
pub struct OrderResults {
    pub noise: Decibels,
    /// One curve per library.
    pub curves: Vec<OrderCurve>,
}

/// Residuals without noise and with that of case 2.
pub(crate) fn study_orders(settings: &Settings) -> Result<Vec<OrderResults>, ExperimentError> {
    let plan = OrderPlan {
        trig_order: settings.trig_order,
        whole_order: settings.whole_order,
        ..OrderPlan::default()
    };
    [1, 2]
        .into_iter()
        .map(|case| {
            let noise = Decibels::case(case);
            let scenario = settings.scenario(noise, settings.seed);
            let log = scenario.record(&scenario.simulate()?)?;
            let curves = orders(&log, &plan).map_err(within("orders"))?;
            Ok(OrderResults { noise, curves })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_noise_the_energy_library_is_exact_at_the_order_of_the_arm() {
        let settings = Settings { whole_order: 2, trig_order: 2, ..Settings::quick(1) };

        let results = study_orders(&settings).unwrap();

        let energy = results[0].curves.last().unwrap();
        assert_eq!(energy.name, "energy");
        let best = &energy.points[energy.chosen];
        assert!(best.residual.iter().all(|&residual| residual < 1e-5), "{energy:?}");
        assert!(results[1].curves.iter().all(|curve| curve.chosen < curve.points.len()));
    }
}
