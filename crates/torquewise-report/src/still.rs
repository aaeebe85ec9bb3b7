//! Charts as a still picture: an SVG drawn by plotters, words kept as words.

use crate::html::thin::{picked, rows_of, sorted};
use crate::{Axis, Chart, Colour, Guide, Mark, ReportError, Result, Series};
use plotters::chart::SeriesAnno;
use plotters::coord::Shift;
use plotters::coord::ranged1d::{AsRangedCoord, Ranged, ValueFormatter};
use plotters::prelude::*;
use torquewise_motion::ends;

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// Dots to a pixel: the library draws at whole dots only.
const DOTS: u32 = 2;
const WIDTH: u32 = 1_000 * DOTS;
/// Height of a panel, and of one that has the whole width.
const HEIGHT: u32 = 280 * DOTS;
const TITLE: u32 = 44;
const HEADING: u32 = 32;
const WORDS: u32 = 26;
/// Numbers beyond this, or closer to zero on a logarithmic axis, are not drawn.
const LARGEST: f64 = 1e100;
/// Ink of numbers and guides.
const FADED: RGBColor = RGBColor(107, 114, 128);

/// An SVG with one panel per chart, so many `columns` side by side.
///
/// The picture is 1000 pixels wide, on white paper. Curves are thinned to what can be seen, peaks
/// kept. A chart with several names has a legend. Captions are not drawn.
///
/// ```
/// use torquewise_report::chart_figure;
/// use torquewise_report::html::{Axis, Chart, Series};
///
/// let error = vec![[0.0, 0.5], [0.01, 2.0], [0.1, 21.0]];
/// let chart = Chart {
///     x: Axis::named("noise [°]"),
///     y: Axis::log("error [%]"),
///     series: vec![Series::line("energy", error)],
///     ..Chart::default()
/// };
/// let figure = chart_figure("A test", &[chart.clone(), chart], 2)?;
/// assert!(figure.starts_with("<svg") && figure.contains("error [%]"));
/// # Ok::<(), torquewise_report::ReportError>(())
/// ```
///
/// # Errors
/// [`ReportError::Drawing`].
pub fn chart_figure(title: &str, charts: &[Chart], columns: usize) -> Result<String> {
    let columns = columns.clamp(1, charts.len().max(1));
    let rows = charts.len().div_ceil(columns).max(1);
    let height = 2 * TITLE + HEIGHT * u32::try_from(rows).unwrap_or(1);
    let mut svg = String::new();
    {
        let page = SVGBackend::with_string(&mut svg, (WIDTH, height)).into_drawing_area();
        page.fill(&WHITE).map_err(drawing)?;
        let page = page.titled(title, ("sans-serif", TITLE)).map_err(drawing)?;
        for (chart, area) in charts.iter().zip(page.split_evenly((rows, columns))) {
            panel(&area, chart)?;
        }
        page.present().map_err(drawing)?;
    }
    let drawn = format!("width=\"{WIDTH}\" height=\"{height}\"");
    let shown = format!("width=\"{}\" height=\"{}\"", WIDTH / DOTS, height / DOTS);
    Ok(svg.replacen(&drawn, &shown, 1))
}

fn panel(area: &Area<'_>, chart: &Chart) -> Result<()> {
    let points = || chart.series.iter().flat_map(|series| &series.points);
    let bars = chart.series.iter().any(|series| series.mark == Mark::Bars);
    let ends = chart.series.iter().flat_map(|series| series.spread.iter().flatten().copied());
    let guide = |is_level: bool| {
        chart.guides.iter().filter(move |guide| guide.is_level == is_level).map(|guide| guide.at)
    };
    let x = range(&chart.x, points().map(|point| point[0]).chain(guide(false)));
    let heights = points().map(|point| point[1]).chain(ends).chain(guide(true));
    let y = range(&chart.y, heights.chain(bars.then_some(0.0)));
    match (chart.x.log, chart.y.log) {
        (false, false) => axes(area, chart, x.clone(), y.clone(), [x, y]),
        (false, true) => axes(area, chart, x.clone(), y.clone().log_scale(), [x, y]),
        (true, false) => axes(area, chart, x.clone().log_scale(), y.clone(), [x, y]),
        (true, true) => axes(area, chart, x.clone().log_scale(), y.clone().log_scale(), [x, y]),
    }
}

fn range(axis: &Axis, numbers: impl Iterator<Item = f64>) -> std::ops::Range<f64> {
    if let Some([low, high]) = axis.range.filter(|ends| ends.iter().all(|x| drawable(axis, *x))) {
        return low..high;
    }
    let [low, high] = ends(numbers.filter(|x| drawable(axis, *x)));
    match (low <= high, axis.log) {
        (false, false) => 0.0..1.0,
        (false, true) => 1.0..10.0,
        (true, true) if high < 10.0 * low => 0.5 * low..5.0 * high,
        (true, true) => 0.8 * low..1.25 * high,
        (true, false) => {
            let size = low.abs().max(high.abs());
            let margin = (0.05 * (high - low)).max(1e-3 * size).max(1e-9);
            low - margin..high + margin
        }
    }
}

fn drawable(axis: &Axis, x: f64) -> bool {
    x.abs() < LARGEST && (!axis.log || x > 1.0 / LARGEST)
}

#[expect(clippy::too_many_lines, reason = "one panel, drawn from back to front")]
fn axes<X, Y>(
    area: &Area<'_>,
    chart: &Chart,
    x: X,
    y: Y,
    [across, up]: [std::ops::Range<f64>; 2],
) -> Result<()>
where
    X: AsRangedCoord<Value = f64>,
    Y: AsRangedCoord<Value = f64>,
    X::CoordDescType: Ranged<ValueType = f64> + ValueFormatter<f64>,
    Y::CoordDescType: Ranged<ValueType = f64> + ValueFormatter<f64>,
{
    let mut builder = ChartBuilder::on(area);
    builder.margin(16).margin_right(32).x_label_area_size(76).y_label_area_size(124);
    if !chart.title.is_empty() {
        builder.caption(&chart.title, ("sans-serif", HEADING));
    }
    let mut plot = builder.build_cartesian_2d(x, y).map_err(drawing)?;
    let is_narrow = area.dim_in_pixel().0 < WIDTH;
    plot.configure_mesh()
        .x_desc(&chart.x.label)
        .y_desc(&chart.y.label)
        .x_labels(if is_narrow { 6 } else { 12 })
        .y_labels(6)
        .x_label_formatter(&|at| number(&chart.x, *at))
        .y_label_formatter(&|at| number(&chart.y, *at))
        .label_style(("sans-serif", WORDS, &FADED))
        .axis_desc_style(("sans-serif", WORDS))
        .light_line_style(TRANSPARENT)
        .bold_line_style(RGBColor(229, 231, 235))
        .axis_style(FADED)
        .draw()
        .map_err(drawing)?;

    for band in &chart.bands {
        let style = drawn(band.colour).mix(0.25).filled();
        let spans = band.spans.iter().filter(|ends| ends.iter().all(|x| drawable(&chart.x, *x)));
        let tint = |ends: &[f64; 2]| {
            let [from, to] = ends.map(|x| x.clamp(across.start, across.end));
            Rectangle::new([(from, up.start), (to, up.end)], style)
        };
        let drawn = plot.draw_series(spans.map(tint)).map_err(drawing)?;
        name(drawn, &band.label, Mark::Bars, style);
    }
    for guide in &chart.guides {
        let ends = if guide.is_level {
            [(across.start, guide.at), (across.end, guide.at)]
        } else {
            [(guide.at, up.start), (guide.at, up.end)]
        };
        let style = FADED.stroke_width(2);
        let dashes = DashedLineSeries::new(ends, 10, 8, style);
        let drawn = plot.draw_series(dashes).map_err(drawing)?;
        name(drawn, &guide.name(), Mark::DashedLine, style);
    }
    for series in &chart.series {
        let mark = series.mark;
        let colour = drawn(series.colour);
        let style = match mark {
            Mark::BroadLine => colour.stroke_width(10),
            Mark::Cloud => colour.mix(0.55).filled(),
            Mark::Bars => colour.mix(0.8).filled(),
            Mark::Rings => colour.stroke_width(4),
            Mark::Line | Mark::DashedLine | Mark::DottedLine => colour.stroke_width(3),
        };
        let all = sorted(series, chart.x.log);
        let Series { mut points, spread, .. } = picked(&all, &rows_of(&[&all]));
        let is_inside = |[x, y]: [f64; 2]| {
            (across.start..=across.end).contains(&x)
                && drawable(&chart.y, y)
                && (mark.is_line() || (up.start..=up.end).contains(&y))
        };
        let bars = points.iter().zip(&spread).filter(|(point, _)| is_inside(**point));
        let ends = bars.filter(|(_, ends)| ends.iter().all(|end| drawable(&chart.y, *end)));
        let thin = style.color.stroke_width(2);
        let bars =
            ends.map(|(&[x, _], &[low, high])| PathElement::new([(x, low), (x, high)], thin));
        plot.draw_series(bars).map_err(drawing)?;
        // Half the width of bars at points from left to right.
        let steps = points.windows(2).map(|pair| pair[1][0] - pair[0][0]);
        let least = steps.filter(|step| *step > 0.0).fold(f64::INFINITY, f64::min);
        let half = 0.4 * if least.is_finite() { least } else { 1.0 };
        points.iter_mut().filter(|point| !is_inside(**point)).for_each(|point| point[1] = f64::NAN);
        for piece in points.split(|point| point[1].is_nan()) {
            let piece = piece.iter().map(|&[x, y]| (x, y));
            match mark {
                Mark::Line | Mark::BroadLine => plot.draw_series(LineSeries::new(piece, style)),
                Mark::DottedLine => {
                    plot.draw_series(LineSeries::new(piece, style.filled()).point_size(7))
                }
                Mark::DashedLine => plot.draw_series(DashedLineSeries::new(piece, 12, 8, style)),
                Mark::Cloud => plot.draw_series(piece.map(|at| Circle::new(at, 3, style))),
                Mark::Rings => plot.draw_series(piece.map(|at| Circle::new(at, 9, style))),
                Mark::Bars => plot.draw_series(piece.map(|(x, y)| {
                    let foot = if chart.y.log { up.start } else { 0.0 };
                    Rectangle::new([(x - half, foot), (x + half, y)], style)
                })),
            }
            .map_err(drawing)?;
        }
        if points.iter().any(|point| !point[1].is_nan()) {
            let none = LineSeries::new([], style);
            let drawn = plot.draw_series(none).map_err(drawing)?;
            name(drawn, &series.label, mark, style);
        }
    }
    let series = chart.series.iter().map(|series| series.label.clone());
    let bands = chart.bands.iter().map(|band| band.label.clone());
    let names = series.chain(bands).chain(chart.guides.iter().map(Guide::name));
    if names.filter(|name| !name.is_empty()).count() > 1 {
        plot.configure_series_labels()
            .position(SeriesLabelPosition::UpperRight)
            .label_font(("sans-serif", WORDS))
            .legend_area_size(52)
            .background_style(WHITE.mix(0.85))
            .border_style(RGBColor(229, 231, 235))
            .draw()
            .map_err(drawing)?;
    }
    Ok(())
}

/// A name in the legend, and what stands before it.
fn name<'a, 'b: 'a>(
    drawn: &mut SeriesAnno<'a, SVGBackend<'b>>,
    label: &str,
    mark: Mark,
    style: ShapeStyle,
) {
    if label.is_empty() {
        return;
    }
    drawn.label(label);
    match mark {
        Mark::Bars => {
            drawn.legend(move |(x, y)| Rectangle::new([(x, y - 10), (x + 44, y + 10)], style))
        }
        Mark::Cloud | Mark::Rings => drawn.legend(move |(x, y)| Circle::new((x + 22, y), 7, style)),
        _ => drawn.legend(move |(x, y)| PathElement::new([(x, y), (x + 44, y)], style)),
    };
}

fn number(axis: &Axis, at: f64) -> String {
    let is_whole = (at - at.round()).abs() < 1e-9;
    if !axis.places.is_empty() {
        let named =
            axis.places.iter().enumerate().find(|(place, _)| (at - *place as f64).abs() < 1e-9);
        return named.map(|(_, name)| name.clone()).unwrap_or_default();
    }
    if axis.whole && !is_whole {
        return String::new();
    }
    // What is left of the rounding of a step is no digit.
    let at: f64 = format!("{at:.6e}").parse().unwrap_or(at);
    if at.abs() < 1e-12 && !axis.log {
        return "0".into();
    }
    if (1e-3..1e6).contains(&at.abs()) { at.to_string() } else { format!("{at:e}") }
}

fn drawing(error: impl std::fmt::Display) -> ReportError {
    ReportError::Drawing { reason: error.to_string() }
}

fn drawn(colour: Colour) -> RGBColor {
    let [red, green, blue] = colour.on_paper();
    RGBColor(red, green, blue)
}

#[cfg(test)]
mod tests;
