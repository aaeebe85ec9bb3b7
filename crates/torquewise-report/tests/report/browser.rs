//! Whether a report works in a real browser: drawn, read out, zoomed into, narrow, dark, printed.
//!
//! Chromium is driven over its DevTools protocol. It is the program named by `TORQUEWISE_CHROMIUM`
//! or the first of `chromium`, `chromium-browser` and `google-chrome`; without one the tests say
//! that they skip, or fail where `TORQUEWISE_BROWSER_REQUIRED=1`.

#![expect(clippy::unwrap_used, reason = "a test may panic")]

use crate::chromium::{Chromium, Tab};
use serde_json::json;
use std::path::PathBuf;
use tempfile::TempDir;
use torquewise_identify::{Plan, diagnose, reconstruct};
use torquewise_model::check;
use torquewise_motion::Motion;
use torquewise_report::html::{
    Axis, Band, Chart, Colour, Guide, Item, Mark, Page, Section, Series,
};
use torquewise_report::{CallCost, Findings, LogFile, Origin, fit_report};
use torquewise_sim::{Arm, MotionPlan, Noise, add_noise, simulate};

/// What a hostile log may call a joint.
const HOSTILE: &str = "</script><img src=x onerror=\"throw 1\">'";

/// A short log of an arm of two joints, the first of which has a hostile name.
fn log() -> Motion {
    let arm = Arm::builtin("planar-2").unwrap();
    let plan = MotionPlan { seconds: 30.0, rate: 100.0, ..MotionPlan::default() };
    let clean = simulate(&arm, &plan).unwrap().motion;
    let mut signals = add_noise(&clean, &Noise::case(2).unwrap(), 5).unwrap().into_signals();
    signals.joints[0] = HOSTILE.into();
    Motion::new(signals).unwrap()
}

fn report() -> String {
    let log = log();
    let found = reconstruct(&log, &Plan::default(), &mut |_| ()).unwrap();
    let diagnosis = diagnose(&found.model, &found.patterns, &log).unwrap();
    let row_of = |signal: faer::MatRef<'_, f64>, row| (0..2).map(|j| signal[(row, j)]).collect();
    let states: Vec<_> =
        (0..20).map(|k| (row_of(log.q(), 100 * k), row_of(log.dq(), 100 * k))).collect();
    let checks = check(&found.model, &states).unwrap();
    let (found, test, checks) = (&found, Some(&diagnosis), Some(&checks));
    let cost = CallCost { operations: 1234, functions: 8, seconds: 5e-7 };
    let costs = vec![cost; found.model.stages.len() + 1];
    let logs = &[LogFile { name: HOSTILE.into(), date: "2001-02-03".into() }];
    let origin =
        Origin { logs, tests: logs, version: "1.2.3", command: HOSTILE, ..Origin::default() };
    let findings = Findings { found, diagnosis: &diagnosis, checks, test, costs: &costs, origin };
    fit_report(&findings).unwrap()
}

/// One chart of each kind of mark, axis and decoration.
fn every_kind_of_chart() -> String {
    let points = || (1..40).map(|k| [f64::from(k), 10_f64.powf(0.1 * f64::from(k % 20))]).collect();
    let mut charts = Vec::new();
    for mark in Mark::ALL {
        for (x, y) in [(Axis::named("x"), Axis::named("y")), (Axis::log("x"), Axis::log("y"))] {
            let mut series = Series::new("points", mark, Colour::Series(1), points());
            series.spread = series.points.iter().map(|[_, y]| [0.5 * y, 2.0 * y]).collect();
            let others = vec![[0.5, 1.0], [2.5, f64::NAN], [3.0, 40.0]];
            charts.push(Chart {
                title: format!("{mark:?}, logarithmic: {}", x.log),
                x,
                y,
                series: vec![series, Series::line("others", others)],
                bands: vec![Band {
                    label: "band".into(),
                    colour: Colour::Faded,
                    spans: vec![[3.0, 9.0]],
                }],
                guides: vec![Guide::at_x(5.0, "here"), Guide::at_y(20.0, "there")],
                ..Chart::default()
            });
        }
    }
    charts.push(Chart { title: "nothing".into(), ..Chart::default() });
    charts.push(Chart {
        title: "one point at a named place".into(),
        x: Axis { places: vec!["case 1".into()], ..Axis::default() },
        series: vec![Series::line("point", vec![[0.0, 1.0]])],
        ..Chart::default()
    });
    let sections = vec![Section { heading: "Charts".into(), items: vec![Item::Charts(charts)] }];
    Page { title: "Every kind of chart".into(), sections, ..Page::default() }.to_html().unwrap()
}

/// A page in a file, and a browser to look at it; `None` where there is no browser.
pub(crate) struct Desk {
    browser: Chromium,
    folder: TempDir,
}

impl Desk {
    pub(crate) fn new() -> Option<Self> {
        Some(Self { browser: Chromium::start()?, folder: TempDir::new().unwrap() })
    }

    pub(crate) fn open(&mut self, html: &str) -> Tab {
        let path: PathBuf = self.folder.path().join("page.html");
        std::fs::write(&path, html).unwrap();
        let mut tab = self.browser.tab();
        tab.open(&path);
        tab.value(READ_PIXELS);
        tab
    }
}

/// Charts whose canvas has any ink on it.
const DRAWN: &str = "[...document.querySelectorAll('figure.chart canvas')]\
    .filter((canvas) => pixels(canvas).some((value) => value > 0)).length";
/// Whether the predicted torque of the first chart has left its colour there.
const PREDICTED_INK: &str = "(() => { \
    const all = pixels(document.querySelector('#chart-1 canvas')); \
    for (let k = 0; k < all.length; k += 4) \
    if (all[k] === 0 && all[k + 1] === 114 && all[k + 2] === 178) return true; return false; })()";
/// Makes `pixels` known: red, green, blue and alpha of a copy of a canvas, row by row.
const READ_PIXELS: &str = "window.pixels = (canvas) => { \
    const { width, height } = canvas; \
    const often = { willReadFrequently: true }; \
    const copy = new OffscreenCanvas(width, height).getContext('2d', often); \
    copy.drawImage(canvas, 0, 0); \
    return copy.getImageData(0, 0, width, height).data; }; 0";
/// Opens all that is folded, and waits until its charts have their size.
pub(crate) const UNFOLD: &str = "(async () => { \
    document.querySelectorAll('details').forEach((own) => { own.open = true; }); \
    await new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))); \
    return 0; })()";
/// By how much the page is wider than the window.
pub(crate) const OVERFLOW: &str = "document.documentElement.scrollWidth - innerWidth";
const X_LIMITS: &str = "[...document.querySelectorAll('figure.chart')].filter((figure) => \
    figure.plot.linked === 'time').map(({ plot: { scales: { x } } }) => [x.min, x.max])";
const READOUTS: &str = "[...document.querySelectorAll('.readout:not([hidden])')].map((box) => \
    box.textContent)";

#[test]
fn a_report_is_drawn_without_an_error_or_a_request() {
    let Some(mut desk) = Desk::new() else { return };

    let mut tab = desk.open(&report());

    let charts = tab.value("document.querySelectorAll('figure.chart').length").as_u64().unwrap();
    assert!(charts >= 14, "{charts} charts");
    assert_eq!(tab.value(DRAWN), charts);
    assert_eq!(tab.value(PREDICTED_INK), true, "not the axes alone");
    assert_eq!(tab.value("document.images.length"), 0, "no tag comes from a name");
    assert!(tab.value("document.querySelectorAll('math').length").as_u64().unwrap() > 10);
    assert_eq!(tab.complaints(), [""; 0]);
    assert_eq!(tab.requests(), 1, "the page alone");
}

#[test]
fn every_kind_of_chart_is_drawn_and_read_out() {
    let Some(mut desk) = Desk::new() else { return };

    let mut tab = desk.open(&every_kind_of_chart());

    assert_eq!(tab.value(DRAWN), 16);
    for chart in 1..=14 {
        let [x, y] = tab.middle(&format!("#chart-{chart} .u-over"));
        for step in 0..24 {
            tab.mouse("mouseMoved", [x - 60.0 + 5.0 * f64::from(step), y + 20.0], 0);
        }
    }
    assert_eq!(tab.complaints(), [""; 0]);
}

#[test]
fn a_gap_is_not_bridged_by_the_points_of_another_curve() {
    let Some(mut desk) = Desk::new() else { return };
    let dense = (0..9).map(|k| [f64::from(k), 0.0]).collect();
    let broken = vec![[0.5, 1.0], [1.5, 1.0], [4.5, f64::NAN], [6.5, 1.0], [7.5, 1.0]];
    let series = vec![Series::line("dense", dense), Series::line("broken", broken)];
    let items = vec![Item::Charts(vec![Chart { series, ..Chart::default() }])];
    let sections = vec![Section { heading: "A gap".into(), items }];
    let page = Page { title: "A gap".into(), sections, ..Page::default() };

    let mut tab = desk.open(&page.to_html().unwrap());

    let gaps = "document.querySelector('#chart-1').plot.data[2].filter((y) => y === null).length";
    // The gap itself, and the five rows of the other curve from x = 2 to x = 6.
    assert_eq!(tab.value(gaps), 6);
}

/// Numbers at the axes of the first charts: from left to right, and up.
const TICKS: &str = "[...document.querySelectorAll('figure.chart')].map(({ plot: { axes } }) => \
    axes.map((axis) => axis._values))";

fn page_of(charts: Vec<Chart>) -> String {
    let sections = vec![Section { heading: "Charts".into(), items: vec![Item::Charts(charts)] }];
    Page { title: "Charts".into(), sections, ..Page::default() }.to_html().unwrap()
}

#[test]
fn numbers_at_an_axis_are_round() {
    let Some(mut desk) = Desk::new() else { return };
    let chart = |x: Axis, y: Axis| Chart {
        x: Axis { range: Some([1.0, 3.0]), ..x },
        y,
        series: vec![Series::line("a", vec![[1.0, 1.0], [3.0, 1.0]])],
        ..Chart::default()
    };
    let log = |low, high| Axis { range: Some([low, high]), ..Axis::log("y") };
    let charts = vec![
        chart(Axis::whole("count"), log(0.008, 20.0)),
        chart(Axis::log("x"), log(0.9, 12.0)),
        chart(Axis { whole: true, ..Axis::log("x") }, log(3e-14, 2e-11)),
        chart(Axis::named("x"), log(0.98, 1.31)),
    ];

    let mut tab = desk.open(&page_of(charts));

    let ticks = tab.value(TICKS);
    assert_eq!(ticks[0], json!([["1", "2", "3"], ["0.01", "0.1", "1", "10"]]));
    assert_eq!(ticks[1], json!([["1.0", "1.5", "2.0", "2.5", "3.0"], ["1", "2", "5", "10"]]));
    assert_eq!(ticks[2], json!([["1", "2", "3"], ["1e-13", "1e-12", "1e-11"]]));
    assert_eq!(ticks[3][1], json!(["1.0", "1.1", "1.2", "1.3"]));
    assert_eq!(tab.complaints(), [""; 0]);
}

#[test]
fn names_at_an_axis_turn_where_they_have_no_room() {
    let Some(mut desk) = Desk::new() else { return };
    let chart = |names: Vec<String>| Chart {
        series: vec![Series::line("a", vec![[0.0, 1.0], [1.0, 2.0]])],
        x: Axis { places: names, ..Axis::named("x") },
        ..Chart::default()
    };
    let few = ["case 1", "case 2", "case 3"].map(String::from).to_vec();
    let many = (0..40).map(|k| format!("M{k} sin(2*q2)*cos(q3)")).collect();
    let mut tab = desk.open(&page_of(vec![chart(few), chart(many)]));
    // How the names stand, how many there are, and whether each has its line and its length.
    let state = "[...document.querySelectorAll('figure.chart')].map(({ plot }) => { \
        const { _rotate, _values, _splits, _size } = plot.axes[0]; \
        const shown = _splits.filter((_, k) => _values[k]); \
        const at = shown.map((v) => plot.valToPos(v, 'x')); \
        const apart = Math.min(...at.slice(1).map((x, k) => x - at[k])); \
        const longest = Math.max(...shown.map((_, k) => _values[k].length)); \
        return [_rotate, shown.length, apart >= (_rotate ? 12 : longest * 5), \
        _rotate ? _size > 4 * longest : true, plot.bbox.height > 100]; })";

    for (width, turned, shown) in [(1280, 90, 40), (380, 90, 20)] {
        tab.resize(width, 800);

        let found = tab.value(state);
        assert_eq!(found[0], json!([0, 3, true, true, true]), "at {width}");
        assert_eq!(found[1][0], turned, "{found} at {width}");
        assert!(found[1][1].as_u64().unwrap() <= shown, "{found} at {width}");
        assert_eq!(json!(found[1].as_array().unwrap()[2..]), json!([true, true, true]), "{found}");
    }
    assert_eq!(tab.complaints(), [""; 0]);
}

#[test]
fn pointing_at_a_curve_reads_it_out() {
    let Some(mut desk) = Desk::new() else { return };
    let mut tab = desk.open(&report());
    let at = tab.middle("#chart-1 .u-over");

    tab.mouse("mouseMoved", at, 0);

    let shown = tab.value(READOUTS);
    assert_eq!(shown.as_array().unwrap().len(), 1, "one box only, though charts are linked");
    let text = shown[0].as_str().unwrap();
    assert!(["time", "measured", "predicted"].iter().all(|word| text.contains(word)), "{text}");
    assert!(text.chars().any(|c| c.is_ascii_digit()), "{text}");
    tab.mouse("mouseMoved", [1.0, 1.0], 0);
    assert_eq!(tab.value(READOUTS), json!([]), "gone with the pointer");
}

#[test]
fn dragging_zooms_all_charts_over_time_and_a_double_click_undoes_it() {
    let Some(mut desk) = Desk::new() else { return };
    let mut tab = desk.open(&report());
    tab.value(UNFOLD);
    let whole = tab.value(X_LIMITS);
    // The first two are of the test log.
    let [x, y] = tab.middle("#chart-3 .u-over");

    tab.mouse("mouseMoved", [x - 60.0, y], 0);
    tab.mouse("mousePressed", [x - 60.0, y], 1);
    tab.mouse("mouseMoved", [x + 60.0, y], 1);
    tab.mouse("mouseReleased", [x + 60.0, y], 1);
    let zoomed = tab.value(X_LIMITS);
    let reset = tab.value("document.querySelector('#chart-3 .reset').hidden");
    for clicks in [1, 2] {
        tab.mouse("mousePressed", [x, y], clicks);
        tab.mouse("mouseReleased", [x, y], clicks);
    }

    let limits = zoomed.as_array().unwrap();
    assert!(limits.len() >= 5 && limits.iter().all(|own| *own == limits[0]), "{zoomed}");
    let width =
        |limits: &serde_json::Value| limits[1].as_f64().unwrap() - limits[0].as_f64().unwrap();
    assert!(width(&limits[0]) < 0.5 * width(&whole[0]), "{whole} {zoomed}");
    assert_eq!(reset, false, "a button to undo it appears");
    assert_eq!(tab.value(X_LIMITS), whole);
    assert_eq!(tab.complaints(), [""; 0]);
}

#[test]
fn a_click_on_the_legend_hides_a_curve() {
    let Some(mut desk) = Desk::new() else { return };
    let mut tab = desk.open(&report());
    let at = tab.middle("#chart-1 button.key");

    tab.mouse("mousePressed", at, 1);
    tab.mouse("mouseReleased", at, 1);

    let shown = tab.value("document.querySelector('#chart-1').plot.series.map((s) => s.show)");
    assert_eq!(shown, json!([true, false, true]));
    let pressed = tab.value("document.querySelector('#chart-1 .key').getAttribute('aria-pressed')");
    assert_eq!(pressed, "false");
}

#[test]
fn the_theme_follows_the_reader_and_the_button() {
    let Some(mut desk) = Desk::new() else { return };
    let mut tab = desk.open(&report());
    let ground = "getComputedStyle(document.body).backgroundColor";
    let light = tab.value(ground);

    tab.emulate_media("screen", "dark");
    let dark = tab.value(ground);
    let at = tab.middle("#theme");
    tab.mouse("mousePressed", at, 1);
    tab.mouse("mouseReleased", at, 1);

    assert_eq!(light, "rgb(255, 255, 255)");
    assert_ne!(dark, light);
    assert_eq!(tab.value(ground), light, "the button turns it round");
    tab.emulate_media("print", "dark");
    assert_eq!(tab.value(ground), light, "paper is light");
}

#[test]
fn nothing_is_wider_than_a_narrow_screen() {
    let Some(mut desk) = Desk::new() else { return };
    let mut tab = desk.open(&report());

    for width in [380, 800, 1280] {
        tab.resize(width, 800);
        assert_eq!(tab.value(OVERFLOW), 0, "folded, at {width}");
        tab.value(UNFOLD);

        assert_eq!(tab.value(OVERFLOW), 0, "at {width}");
        let widest = tab.value(
            "Math.max(...[...document.querySelectorAll('.uplot')].map((u) => u.offsetWidth))",
        );
        assert!(widest.as_u64().unwrap() <= width, "{widest} at {width}");
    }
    assert_eq!(tab.complaints(), [""; 0]);
}

#[test]
fn paper_shows_what_was_folded_and_the_screen_comes_back_as_it_was() {
    let Some(mut desk) = Desk::new() else { return };
    let mut tab = desk.open(&report());
    let state = "[document.querySelectorAll('details[open]').length, \
        document.querySelector('#chart-1').plot.width, \
        'printing' in document.documentElement.dataset]";
    let before = tab.value(state);
    tab.value(
        "addEventListener('beforeprint', () => { \
         window.folded = document.querySelectorAll('details:not([open])').length; })",
    );

    let pdf = tab.pdf();

    assert!(pdf.starts_with(b"%PDF") && pdf.len() > 50_000, "{} bytes", pdf.len());
    assert_eq!(tab.value("window.folded"), 0, "nothing is folded on paper");
    assert_eq!(tab.value(state), before);
    assert_eq!(tab.complaints(), [""; 0]);
}
