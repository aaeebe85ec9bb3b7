//! A report says what each step of a model costs a controller, and which step to take.

use crate::{findings, fitted};
use torquewise_report::{CallCost, Findings, ReportError, fit_report};

/// A report of three steps and the whole, which take 0.1, 1, 2 and so many µs.
fn report(whole: f64, n_costs: usize) -> Result<String, ReportError> {
    let (found, diagnosis) = fitted(20.0, |_| ());
    assert_eq!(found.model.stages.len(), 3);
    let cost = |seconds| CallCost { operations: 12_345, functions: 6, seconds };
    let costs = &[1e-7, 1e-6, 2e-6, whole].map(cost)[..n_costs];
    fit_report(&Findings { costs, ..findings(&found, &diagnosis) })
}

#[test]
fn the_most_accurate_that_fits_a_rate_is_named() {
    let (quick, slow) = (report(2.4e-6, 4).unwrap(), report(6e-6, 4).unwrap());

    assert!(quick.contains("Cost in a controller") && quick.contains("12\u{202f}345"));
    // A tenth of the period of 40 kHz is 2.5 µs.
    let all = "“refit” at 1\u{202f}kHz, 4\u{202f}kHz, 10\u{202f}kHz, 40\u{202f}kHz.";
    assert!(quick.contains(all), "2.4 µs fit everywhere");
    assert!(slow.contains("“refit” at 1\u{202f}kHz, 4\u{202f}kHz, 10\u{202f}kHz; “"));
    assert!(!slow.contains(all));
    assert!(matches!(report(1e-6, 3), Err(ReportError::Costs { .. })));
}
