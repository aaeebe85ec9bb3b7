//! What a figure of charts shows.

use crate::{Axis, Chart, Colour, Guide, Mark, Series, Stretches, chart_figure};
use torquewise_motion::ends;

const MARKS: [Mark; 7] = [
    Mark::Line,
    Mark::BroadLine,
    Mark::DashedLine,
    Mark::DottedLine,
    Mark::Cloud,
    Mark::Rings,
    Mark::Bars,
];

fn chart(mark: Mark) -> Chart {
    let points = vec![[1.0, 1.0], [2.0, f64::NAN], [3.0, 4.0], [4.0, 0.0], [5.0, f64::INFINITY]];
    let series = Series {
        spread: vec![[0.5, 2.0], [f64::NAN; 2], [0.0, 5.0], [1.0, 2.0], [2.0, f64::INFINITY]],
        ..Series::new("a & b", mark, Colour::Series(1), points)
    };
    Chart {
        title: "<b>".into(),
        x: Axis::named("time [s]"),
        y: Axis::log("error [%]"),
        series: vec![series.clone(), Series { label: "second".into(), ..series }],
        bands: vec![Stretches {
            label: "still".into(),
            colour: Colour::Faded,
            spans: vec![[1.0, 2.0], [f64::NAN, 2.0]],
        }],
        guides: vec![Guide::at_y(2.5, "limit"), Guide::at_x(2.0, "chosen")],
        ..Chart::default()
    }
}

fn with(series: Series) -> Chart {
    Chart { series: vec![series], ..Chart::default() }
}

fn drawn(chart: Chart) -> String {
    chart_figure("", &[chart], 1).unwrap()
}

fn numbers(svg: &str, element: &str, attribute: &str) -> Vec<f64> {
    let elements = svg.split('<').filter(|text| text.starts_with(element));
    let values = elements.filter_map(|text| text.split(&format!(" {attribute}=\"")).nth(1));
    let texts = values.filter_map(|text| text.split('"').next());
    texts.flat_map(|text| text.split([' ', ','])).filter_map(|n| n.parse().ok()).collect()
}

#[test]
fn a_figure_names_all_that_it_shows_and_escapes_it() {
    let charts: Vec<Chart> = MARKS.into_iter().map(chart).collect();

    let svg = chart_figure("Title", &charts, 2).unwrap();

    for words in ["Title", "&lt;b&gt;", "a &amp; b", "time [s]", "error [%]", "still", "limit: 2.5"]
    {
        assert!(svg.contains(words), "{words}");
    }
    assert!(svg.starts_with("<svg width=\"1000\"") && svg.ends_with("</svg>\n"));
    assert!(!svg.contains("NaN") && !svg.contains("inf"), "only numbers are drawn");
}

#[test]
fn a_chart_without_points_is_drawn() {
    for axis in [Axis::named("x"), Axis::log("x")] {
        let chart = Chart { x: axis.clone(), y: axis, ..Chart::default() };
        for columns in [0, 1, 3, usize::MAX] {
            let svg = chart_figure("Nothing", &[chart.clone(), Chart::default()], columns).unwrap();

            assert!(!svg.contains("NaN"));
        }
    }
    assert!(chart_figure("", &[], 2).is_ok());
}

#[test]
fn numbers_of_any_size_are_drawn() {
    for size in [f64::MIN_POSITIVE, 1e-300, 1e-9, 1e9, 1e300, f64::MAX] {
        for mark in MARKS {
            let points = vec![[0.0, 0.0], [size, size], [-size, 2.0 * size], [1.0, 1.0]];
            let spread = vec![[-size, size]; 4];
            let series = Series { spread, ..Series::new("a", mark, Colour::Faded, points) };
            let even = with(series);
            let log = Chart { x: Axis::log("x"), y: Axis::log("y"), ..even.clone() };

            assert!(chart_figure("Sizes", &[even, log], 2).is_ok(), "{size:e} {mark:?}");
        }
    }
}

#[test]
fn nothing_is_drawn_beyond_the_axes() {
    let points: Vec<[f64; 2]> = (-50..50).map(|k| [f64::from(k), 3.0 * f64::from(k)]).collect();
    let spread: Vec<[f64; 2]> = points.iter().map(|[_, y]| [y - 100.0, y + 100.0]).collect();
    let axis = Axis { range: Some([-10.0, 10.0]), ..Axis::default() };
    let (colour, label) = (Colour::Faded, String::new());
    let bands = vec![Stretches { label, colour, spans: vec![[-99.0, 99.0]] }];
    for mark in MARKS {
        let series = Series::new("a", mark, colour, points.clone());
        let series = Series { spread: spread.clone(), ..series };
        let (x, y, bands) = (axis.clone(), axis.clone(), bands.clone());

        let svg = drawn(Chart { x, y, bands, ..with(series) });

        let places = numbers(&svg, "polyline", "points");
        let xs = places.iter().step_by(2).copied().chain(numbers(&svg, "circle", "cx"));
        let ys = places.iter().skip(1).step_by(2).copied().chain(numbers(&svg, "circle", "cy"));
        // Lines of the grid stand at the ends of the axes, whose ticks reach out.
        let ([left, _], [_, right]) =
            (ends(numbers(&svg, "line", "x1")), ends(numbers(&svg, "line", "x2")));
        let [top, bottom] = ends(numbers(&svg, "line", "y1"));
        let (xs, ys) = (ends(xs), ends(ys));
        assert!(left - 10.0 <= xs[0] && xs[1] <= right + 1.0, "{mark:?}: {xs:?}");
        assert!(top - 1.0 <= ys[0] && ys[1] <= bottom + 10.0, "{mark:?}: {ys:?}");
        let widths = numbers(&svg, "rect", "width").into_iter().skip(1);
        assert!(ends(widths)[1] <= right - left, "{mark:?}");
    }
}

#[test]
fn what_has_no_place_on_an_axis_is_not_drawn() {
    let points = vec![[1.0, 1.0], [2.0, 0.0], [3.0, 10.0], [0.0, 5.0], [4.0, -3.0]];
    let rings = with(Series::new("a", Mark::Rings, Colour::Series(0), points));
    let spans = vec![[1.0, 2.0], [f64::NAN, 2.0], [8.0, f64::INFINITY], [-2.0, -1.0]];
    let band = Stretches { label: String::new(), colour: Colour::Faded, spans };
    let line = with(Series::line("a", vec![[0.0, 0.0], [10.0, 1.0]]));

    let positive = drawn(Chart { x: Axis::log("x"), y: Axis::log("y"), ..rings });
    let bands = drawn(Chart { bands: vec![band], ..line });

    assert_eq!(positive.matches("<circle").count(), 2, "two rings");
    assert_eq!(numbers(&bands, "rect", "width").len() - 1, 2, "the paper not counted");
}

#[test]
fn long_series_are_thinned_with_their_peaks() {
    let height = |k: i32| if k == 77_777 { 10.0 } else { 0.1 * f64::from(k % 2) };
    let points: Vec<[f64; 2]> = (0..200_000).map(|k| [f64::from(k), height(k)]).collect();
    for mark in MARKS {
        let series = Series::new("a", mark, Colour::Series(0), points.clone());
        let y = Axis { range: Some([0.0, 10.0]), ..Axis::default() };

        let svg = drawn(Chart { y, ..with(series) });

        assert!(svg.len() < 600_000, "{mark:?}: {} bytes", svg.len());
        if mark == Mark::Line {
            let curve = svg.split("<polyline").max_by_key(|path| path.len()).unwrap();
            let places = numbers(&format!("<polyline{curve}"), "polyline", "points");
            let [peak, _] = ends(places.into_iter().skip(1).step_by(2));
            let [top, _] = ends(numbers(&svg, "line", "y1"));
            assert!((peak - top).abs() <= 1.0, "{peak} {top}");
        }
    }
}

#[test]
fn places_have_their_names_and_a_legend_those_of_several_series_with_points() {
    let names = ["energy", "product: |c| > 0.1"].map(String::from).to_vec();
    let x = Axis { places: names, ..Axis::default() };
    let points = |y| vec![[0.0, y], [1.0, y]];
    let only = Series::new("only", Mark::Rings, Colour::Series(0), points(1.0));
    let series = vec![Series::line("here", points(1.0)), Series::line("absent", points(f64::NAN))];

    let one = drawn(Chart { x, ..with(only) });
    let several = drawn(Chart { series, ..Chart::default() });

    assert!(one.contains("energy") && one.contains("product: |c| &gt; 0.1"));
    assert!(!one.contains("only"));
    assert!(several.contains("here") && !several.contains("absent"));
}
