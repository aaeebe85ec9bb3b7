//! What an SVG of charts shows.

use crate::svg::{colour, svg};
use torquewise_motion::Pattern;
use torquewise_report::html::{Axis, Band, Chart, Colour, Guide, Mark, Page, Series};

fn chart(mark: Mark) -> Chart {
    let series = Series {
        spread: vec![[0.5, 2.0], [f64::NAN, f64::NAN], [2.0, 5.0]],
        ..Series::new("a & b", mark, Colour::Series(1), vec![[1.0, 1.0], [2.0, f64::NAN], [3.0, 4.0]])
    };
    Chart {
        title: "<b>".into(),
        x: Axis::named("time [s]"),
        y: Axis::log("error [%]"),
        series: vec![series.clone(), Series { label: "second".into(), ..series }],
        bands: vec![Band { label: "still".into(), colour: Colour::Faded, spans: vec![[1.0, 2.0]] }],
        guides: vec![Guide::at_y(2.5, "limit"), Guide::at_x(2.0, "chosen")],
        ..Chart::default()
    }
}

#[test]
fn a_figure_names_all_that_it_shows_and_escapes_it() {
    let marks = [Mark::Line, Mark::BroadLine, Mark::DashedLine, Mark::DottedLine];
    let more = [Mark::Cloud, Mark::Rings, Mark::Bars];
    let charts: Vec<Chart> = marks.into_iter().chain(more).map(chart).collect();

    let text = svg("Title", &charts, 2);

    for words in ["Title", "&lt;b&gt;", "a &amp; b", "time [s]", "error [%]", "still", "limit"] {
        assert!(text.contains(words), "{words}");
    }
    assert!(text.starts_with("<svg") && text.ends_with("</svg>\n"));
    assert!(!text.contains("NaN") && !text.contains("inf"), "only numbers are drawn");
}

#[test]
fn a_chart_without_points_is_drawn() {
    let text = svg("Nothing", &[Chart::default()], 1);

    assert!(!text.contains("NaN"));
}

#[test]
fn the_palette_is_that_of_the_report() {
    let html = Page::default().to_html().unwrap();
    let patterns = Pattern::ALL.map(Colour::Pattern);
    let series = (0..6).map(Colour::Series).chain(patterns);

    for colour in series.chain([Colour::Measured, Colour::Faded]) {
        assert!(html.contains(colour::hex(colour)), "{colour:?}");
    }
}
