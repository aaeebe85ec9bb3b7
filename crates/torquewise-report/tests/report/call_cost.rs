//! A report says what each step of a model costs a controller, and which step to take.

use crate::{findings, fitted};
use torquewise_export::Cost;
use torquewise_report::{Findings, ReportError, fit_report};

/// A report of three steps and the whole, of so many operations.
fn report(whole: usize, n_costs: usize) -> Result<String, ReportError> {
    let (found, diagnosis) = fitted(20.0, |_| ());
    assert_eq!(found.model.stages.len(), 3);
    let cost = |operations| Cost { operations, functions: 6 };
    let costs = &[345, 2_345, 4_321, whole].map(cost)[..n_costs];
    fit_report(&Findings { costs, ..findings(&found, &diagnosis) })
}

#[test]
fn the_most_accurate_that_fits_a_rate_is_named() {
    let (quick, slow) = (report(6_543, 4).unwrap(), report(12_345, 4).unwrap());

    assert!(quick.contains("Cost in a controller") && quick.contains("6\u{202f}543"));
    // They take 2.4 and 4.5 µs; a tenth of the period of 40 kHz is 2.5 µs.
    let all = "“refit” at 1\u{202f}kHz, 4\u{202f}kHz, 10\u{202f}kHz, 40\u{202f}kHz.";
    assert!(quick.contains(all), "2.4 µs fit everywhere");
    assert!(slow.contains("“refit” at 1\u{202f}kHz, 4\u{202f}kHz, 10\u{202f}kHz; “"));
    assert!(!slow.contains(all));
    assert!(matches!(report(2_345, 3), Err(ReportError::Costs { .. })));
}
