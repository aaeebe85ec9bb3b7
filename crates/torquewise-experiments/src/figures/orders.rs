//! Order curves → Fig. 5: residual against order.

use crate::figures::Figure;
use crate::study::order_curves::{CurvePoint, LibraryCurve, OrderResults};
use torquewise_report::html::{Axis, Chart, Colour, Guide, Mark, Series};

/// One panel per library.
pub(crate) fn figure(orders: &[OrderResults]) -> Figure {
    let curves = orders.first().map_or(&[][..], |first| &first.curves);
    Figure {
        name: "fig5_orders".into(),
        title: "Fig. 5: residual against the order of the library".into(),
        caption: "Least squares on one half of the rows, judged on the other: the residual of the \
                  worst joint over the standard deviation of its torque. The order chosen without \
                  noise is marked: the first that no higher one improves by more than a tenth for \
                  any joint. Without noise the residual drops to rounding once the library holds \
                  the truth; with noise it levels off where the noise is all that is left, and \
                  rises again where there are more candidates than the rows can tell apart."
            .into(),
        charts: curves.iter().map(|curve| chart(&curve.name, orders)).collect(),
        columns: 2,
    }
}

fn chart(name: &str, orders: &[OrderResults]) -> Chart {
    let mut series = Vec::new();
    let mut guides = Vec::new();
    for results in orders {
        let Some(curve) = results.curves.iter().find(|curve| curve.name == name) else { continue };
        if guides.is_empty() {
            let best = curve.points.get(curve.chosen);
            guides.extend(best.map(|p| Guide::at_x(f64::from(p.order), "chosen")));
        }
        series.extend(lines(curve, &results.noise.name(), series.len()));
    }
    let order = if name == "energy" { "joint angles in a term" } else { "N₁" };
    Chart {
        title: title(name),
        x: Axis::named(order),
        y: Axis::log("held-out residual, worst joint [%]"),
        series,
        guides,
        ..Chart::default()
    }
}

fn title(name: &str) -> String {
    match name {
        "SINDy" => "One-shot SINDy, whole library".into(),
        "energy" => "Energy library [E4]".into(),
        step => format!("Step: {step}"),
    }
}

/// One line per N₂.
fn lines(curve: &LibraryCurve, noise: &str, colours: usize) -> Vec<Series> {
    let mut second: Vec<u8> = curve.points.iter().map(|point| point.motion_order).collect();
    second.sort_unstable();
    second.dedup();
    let line = |(place, motion_order): (usize, &u8)| {
        let points = curve.points.iter().filter(|point| point.motion_order == *motion_order);
        let points = points.map(|point| [f64::from(point.order), worst(point)]).collect();
        let label = match motion_order {
            0 => format!("noise {noise}"),
            second => format!("N₂ ≤ {second}, noise {noise}"),
        };
        Series::new(label, Mark::DottedLine, Colour::Series(colours + place), points)
    };
    second.iter().enumerate().map(line).collect()
}

fn worst(point: &CurvePoint) -> f64 {
    point.residual_percent.iter().copied().fold(0.0, f64::max)
}
