//! Charts of orders: held-out residual against the order of each library (Fig. 5).

use crate::{Axis, Chart, Colour, Guide, Mark, Series};
use torquewise_stepwise::orders::{OrderCurve, OrderPoint};

/// One chart per library: the residual of the worst joint against the order.
///
/// - `logs`: a word for each log, such as its noise, and its curves; the order chosen for the first
///   log is marked
pub fn order_charts(logs: &[(String, &[OrderCurve])]) -> Vec<Chart> {
    let first = logs.first().map_or(&[][..], |(_, curves)| *curves);
    first.iter().map(|curve| chart(&curve.name, logs)).collect()
}

fn chart(name: &str, logs: &[(String, &[OrderCurve])]) -> Chart {
    let mut series = Vec::new();
    let mut guides = Vec::new();
    for (log, curves) in logs {
        let Some(curve) = curves.iter().find(|curve| curve.name == name) else { continue };
        if guides.is_empty() {
            let best = curve.points.get(curve.chosen);
            let label = if logs.len() > 1 { format!("chosen, {log}") } else { "chosen".into() };
            guides.extend(best.map(|point| Guide::at_x(f64::from(point.order), label)));
        }
        series.extend(lines(curve, log, series.len()));
    }
    let (title, order) = match name {
        "SINDy" => ("One-shot SINDy, whole library".into(), "N₁"),
        "energy" => ("Energy library".into(), "joint angles in a term"),
        step => (format!("Step: {step}"), "N₁"),
    };
    let axes = [Axis::whole(order), Axis::log("held-out residual, worst joint [%]")];
    Chart { guides, ..Chart::new(title, axes, series) }
}

fn lines(curve: &OrderCurve, log: &str, colours: usize) -> Vec<Series> {
    let mut second: Vec<u8> = curve.points.iter().map(|point| point.motion_order).collect();
    second.sort_unstable();
    second.dedup();
    let line = |(place, motion_order): (usize, &u8)| {
        let points = curve.points.iter().filter(|point| point.motion_order == *motion_order);
        // The worst joint, in percent.
        let worst = |point: &OrderPoint| point.residual.iter().copied().fold(0.0, f64::max);
        let points = points.map(|point| [f64::from(point.order), 100.0 * worst(point)]).collect();
        let label = match motion_order {
            0 => log.to_owned(),
            second => format!("N₂ ≤ {second}, {log}"),
        };
        Series::new(label, Mark::DottedLine, Colour::Series(colours + place), points)
    };
    second.iter().enumerate().map(line).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve(name: &str, motion_orders: &[u8]) -> OrderCurve {
        let point = |&motion_order: &u8| OrderPoint {
            order: 2,
            motion_order,
            candidates: 5,
            residual: vec![0.01, 0.25],
            fitted: vec![0.0, 0.0],
        };
        let points = motion_orders.iter().map(point).collect();
        OrderCurve { name: name.into(), rows: 10, points, chosen: 0 }
    }

    #[test]
    fn each_library_is_a_chart_and_each_motion_order_a_line() {
        let curves = [curve("SINDy", &[1, 2]), curve("energy", &[0])];

        let charts = order_charts(&[("quiet".into(), &curves), ("noisy".into(), &curves)]);

        assert_eq!(charts.len(), 2);
        let labels: Vec<&str> = charts[0].series.iter().map(|s| s.label.as_str()).collect();
        let expected = ["N₂ ≤ 1, quiet", "N₂ ≤ 2, quiet", "N₂ ≤ 1, noisy", "N₂ ≤ 2, noisy"];
        assert_eq!(labels, expected);
        assert_eq!(charts[1].series[0].points, [[2.0, 25.0]]);
        assert_eq!(charts[1].guides.len(), 1);
    }
}
