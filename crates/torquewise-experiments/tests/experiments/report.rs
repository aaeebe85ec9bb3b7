//! The report of the experiments: all that was found, and no complaint of a real browser.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

#[path = "../../../torquewise-report/tests/report/chromium.rs"]
#[expect(dead_code, reason = "other tests ask the browser for more")]
mod chromium;

use crate::smallest;
use chromium::Chromium;
use tempfile::TempDir;
use torquewise_experiments::{Results, figures, page, reproduce};
use torquewise_report::html::markup::escape;

#[test]
fn the_report_shows_every_claim_and_figure_and_opens_without_an_error_or_a_request() {
    let results = reproduce(&smallest(4), &|_| {}).unwrap();

    let html = page(&results).unwrap();

    shows_everything(&results, &html);
    opens_in_a_browser(&html);
}

fn shows_everything(results: &Results, html: &str) {
    for claim in &results.claims {
        assert!(html.contains(&escape(claim.claim)), "{}", claim.claim);
    }
    for figure in figures(results) {
        for chart in &figure.charts {
            // The template writes a slash as an entity, too.
            let title = escape(&chart.title).replace('/', "&#x2f;");
            assert!(html.contains(&title), "{title}");
        }
        assert!(!figure.svg().unwrap().contains("NaN"), "{}", figure.name);
    }
}

fn opens_in_a_browser(html: &str) {
    let Some(mut browser) = Chromium::start() else { return };
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("report.html");
    std::fs::write(&path, html).unwrap();

    let mut tab = browser.tab();
    tab.open(&path);

    let charts = tab.value("document.querySelectorAll('figure.chart canvas').length");
    assert!(charts.as_u64().unwrap() > 20, "{charts} charts");
    assert_eq!(tab.requests(), 1, "the page alone");
    for (width, scheme) in [(380, "dark"), (1280, "light")] {
        tab.resize(width, 800);
        tab.emulate_media("screen", scheme);
        let overflow = tab.value("document.documentElement.scrollWidth - innerWidth");
        assert_eq!(overflow, 0, "at {width}");
    }
    assert_eq!(tab.complaints(), [""; 0]);
}
