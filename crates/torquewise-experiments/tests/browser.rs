//! The report of the experiments in a real browser: no complaint, no request, no overflow.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

#[path = "../../torquewise-report/tests/browser/chromium.rs"]
#[expect(dead_code, reason = "other tests ask the browser for more")]
mod chromium;

use chromium::Chromium;
use tempfile::TempDir;
use torquewise_experiments::{Settings, page, reproduce};

#[test]
fn the_report_of_the_experiments_opens_without_an_error_or_a_request() {
    let Some(mut browser) = Chromium::start() else { return };
    let settings = Settings { seconds: 30.0, seeds: 1, ..Settings::quick(4) };
    let results = reproduce(&settings, &|_| {}).unwrap();
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("report.html");
    std::fs::write(&path, page(&results).unwrap()).unwrap();

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
