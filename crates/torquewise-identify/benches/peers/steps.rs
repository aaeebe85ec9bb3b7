//! The paper's method, three joints: three regressions in turn, each on the rows of its pattern.

use crate::trial::{KINDS, moves, test, timed, write, write_motion, write_terms};
use serde_json::{Value, json};
use std::path::Path;
use torquewise_identify::{LibraryOptions, UNWATCHED, reconstruct, score};
use torquewise_motion::Pattern;
use torquewise_stepwise::Candidates;

const ROWS: usize = 20_000;

/// Times of a whole fit: patterns, sums, selection, bias of the noise, refit, standard errors.
pub(crate) fn run(folder: &Path) -> Value {
    let (motion, test) = (moves(ROWS), test());
    let options = LibraryOptions { bags: 0, ..LibraryOptions::product() };
    let candidates = Candidates::new(&KINDS, options.library, options.regression, Vec::new())
        .expect("a library");
    let plan = options.into();
    let (found, seconds) = timed("fit", || reconstruct(&motion, &plan, UNWATCHED).expect("a log"));
    let scores = score(&found.model, &test).expect("a model of this arm");
    let errors: Vec<f64> = scores.joints.iter().map(|joint| joint.nrmse_percent).collect();

    write_motion(&folder.join("steps.f64"), &motion);
    write_motion(&folder.join("steps_test.f64"), &test);
    for (step, columns) in candidates.offered.iter().enumerate() {
        write_terms(&folder.join(format!("step{}.txt", step + 1)), &candidates, columns);
    }
    let place = |pattern: &Pattern| Pattern::ALL.iter().position(|other| other == pattern);
    let labels = found.patterns.label(&motion);
    let places = labels.iter().map(|pattern| place(pattern).map_or(-1.0, |place| place as f64));
    write(&folder.join("steps_patterns.f64"), places);
    json!({
        "rows": ROWS,
        "candidates": found.candidates,
        "fit": seconds,
        "active": found.model.n_coefficients(),
        "errors": errors,
    })
}
