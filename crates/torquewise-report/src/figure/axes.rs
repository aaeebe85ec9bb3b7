//! From chart to scales: axes with room for all that is drawn.

use crate::figure::DOTS;
use crate::figure::scale::{Needs, Scale, extent};
use crate::html::chart::Position;
use crate::html::thin::sorted;
use crate::html::{Chart, Mark, Series};

/// Space for one number along y.
const Y_ROOM: i32 = 28 * DOTS;
/// Space for one number along x, at least, and between two of them.
const X_ROOM: i32 = 45 * DOTS;
const X_GAP: i32 = 20 * DOTS;
/// Numbers along x at most.
const MOST_NUMBERS: i32 = 12;
/// Space beyond the outermost points, as a part of their distance.
const MARGIN: f64 = 0.05;
/// Half the width of a bar, as a part of the distance to the next.
const HALF_BAR: f64 = 0.4;

/// The axes of a chart that are so many dots wide and high.
pub(crate) fn scales(chart: &Chart, (width, height): (i32, i32)) -> (Scale, Scale) {
    let bars = || chart.series.iter().filter(|series| series.mark == Mark::Bars);
    let is_thin = |series: &Series| {
        let mark = series.mark;
        series.spread.is_empty() && matches!(mark, Mark::Line | Mark::BroadLine | Mark::DashedLine)
    };
    let xs = chart.series.iter().flat_map(|series| &series.points).map(|point| point[0]);
    let sides = bars().flat_map(|series| {
        let points = sorted(series, chart.x.log).points;
        let half = half_bar(&points);
        points.into_iter().flat_map(move |[x, _]| [x - half, x + half])
    });
    let guides = chart.guides.iter();
    let upright = guides.clone().filter_map(|guide| match guide.at {
        Position::X(at) => Some(at),
        Position::Y(_) => None,
    });
    let mut x = Needs {
        extent: extent(&chart.x, xs.chain(sides).chain(upright)),
        // Curves may touch the edge, dots and caps may not.
        margin: if chart.series.iter().all(is_thin) { 0.0 } else { MARGIN },
        from_zero: false,
        ticks: (width / X_ROOM).min(MOST_NUMBERS),
    };
    let widest = Scale::new(&chart.x, &x).widest();
    x.ticks = x.ticks.min(width / (widest + X_GAP));
    let x = Scale::new(&chart.x, &x);
    let ys = chart.series.iter().flat_map(|series| heights(series, &x));
    let level = guides.filter_map(|guide| match guide.at {
        Position::X(_) => None,
        Position::Y(at) => Some(at),
    });
    let zero = bars().map(|_| 0.0);
    let y = Needs {
        extent: extent(&chart.y, ys.chain(level).chain(zero)),
        margin: MARGIN,
        from_zero: bars().next().is_some(),
        ticks: height / Y_ROOM,
    };
    let y = Scale::new(&chart.y, &y);
    (x, y)
}

/// Heights of the points between the ends of x, and of their error bars.
fn heights<'a>(series: &'a Series, x: &'a Scale) -> impl Iterator<Item = f64> + 'a {
    let ends = |row: usize| series.spread.get(row).copied().unwrap_or([f64::NAN; 2]);
    let shown = series.points.iter().enumerate().filter(|(_, point)| x.contains(point[0]));
    shown.flat_map(move |(row, point)| [point[1]].into_iter().chain(ends(row)))
}

/// Half the width of the bars at points from left to right.
pub(crate) fn half_bar(points: &[[f64; 2]]) -> f64 {
    let steps = points.windows(2).map(|pair| pair[1][0] - pair[0][0]);
    let least = steps.filter(|step| *step > 0.0).fold(f64::INFINITY, f64::min);
    HALF_BAR * if least.is_finite() { least } else { 1.0 }
}
