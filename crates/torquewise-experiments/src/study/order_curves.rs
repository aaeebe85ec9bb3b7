//! Log → residual against order for one-shot SINDy, each step and the energy library (Fig. 5).

use crate::error::ExperimentError;
use crate::scenario::{Decibels, Scenario};
use crate::settings::Settings;
use serde::Serialize;
use torquewise_identify::orders::{OrderCurve, OrderPlan, orders};

/// Residuals against order at one level of noise.
#[derive(Clone, Debug, Serialize)]
pub struct OrderResults {
    /// Noise of the log.
    pub noise: Decibels,
    /// One curve per library.
    pub curves: Vec<LibraryCurve>,
}

/// The residuals of one library.
#[derive(Clone, Debug, Serialize)]
pub struct LibraryCurve {
    /// Whose: `SINDy`, the name of a pattern, or `energy`.
    pub name: String,
    /// One point per order.
    pub points: Vec<CurvePoint>,
    /// Place of the point chosen.
    pub chosen: usize,
}

/// The residual at one order.
#[derive(Clone, Debug, Serialize)]
pub struct CurvePoint {
    /// N₁, or the interaction order of the energy library.
    pub order: u8,
    /// N₂ of the whole library; 0 where it is fixed.
    pub motion_order: u8,
    /// Candidates.
    pub candidates: usize,
    /// Held-out RMS residual of each joint over the standard deviation of its torque \[%\], n.
    pub residual_percent: Vec<f64>,
}

/// Residuals without noise and with that of case 2.
///
/// # Errors
/// [`ExperimentError`] if a log cannot be made or fitted.
pub fn study_orders(settings: &Settings) -> Result<Vec<OrderResults>, ExperimentError> {
    let plan = OrderPlan {
        trig_order: settings.trig_order,
        whole_order: settings.whole_order,
        ..OrderPlan::default()
    };
    [1, 2]
        .into_iter()
        .map(|case| {
            let noise = Decibels::case(case);
            let Settings { arm, seconds, seed, .. } = *settings;
            let scenario = Scenario { arm, seconds, noise, seed };
            let log = scenario.record(&scenario.simulate()?)?;
            let curves = orders(&log, &plan).map_err(|source| ExperimentError::Identify {
                experiment: "orders".into(),
                source,
            })?;
            Ok(OrderResults { noise, curves: curves.iter().map(library_curve).collect() })
        })
        .collect()
}

fn library_curve(curve: &OrderCurve) -> LibraryCurve {
    let points = curve.points.iter().map(|point| CurvePoint {
        order: point.order,
        motion_order: point.motion_order,
        candidates: point.candidates,
        residual_percent: point.residual.iter().map(|residual| 100.0 * residual).collect(),
    });
    LibraryCurve { name: curve.name.clone(), points: points.collect(), chosen: curve.chosen }
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
        assert!(best.residual_percent.iter().all(|&percent| percent < 1e-3), "{energy:?}");
        assert!(results[1].curves.iter().all(|curve| curve.chosen < curve.points.len()));
    }
}
