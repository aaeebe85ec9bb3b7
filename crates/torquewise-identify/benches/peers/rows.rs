//! Time over the number of rows: a small library, least squares and STLSQ.

use crate::trial::{KINDS, grams, moves, select_each, timed, write_motion, write_terms};
use serde_json::{Map, Value, json};
use std::path::Path;
use torquewise_identify::{LibraryKind, Regression};
use torquewise_regression::select::stlsq::Stlsq;
use torquewise_stepwise::Candidates;

/// Rows of the log, which larger numbers of rows go through again and again.
const ROWS: usize = 10_000;
const REPEATS: [usize; 4] = [1, 10, 100, 1_000];

/// Seconds from rows in memory to weights, for each number of rows.
pub(crate) fn run(folder: &Path) -> Value {
    let motion = moves(ROWS);
    let library = LibraryKind::Product { gravity_order: 1, trig_order: 1 };
    let candidates =
        Candidates::new(&KINDS, library, Regression::OneShot, Vec::new()).expect("a library");
    let columns: Vec<usize> = (0..candidates.n_columns()).collect();
    write_motion(&folder.join("many.f64"), &motion);
    write_terms(&folder.join("many.txt"), &candidates, &columns);

    let mut times = Map::new();
    for repeats in REPEATS {
        let rows = ROWS * repeats;
        let sums = || grams(&candidates, &motion, repeats).remove(0);
        let (_, lstsq) = timed(&format!("{rows} rows, least squares"), || sums().weights());
        let (_, stlsq) = timed(&format!("{rows} rows, STLSQ"), || {
            let stlsq = Stlsq { ridge: 0.05, ..Stlsq::default() };
            select_each(&stlsq, &sums())
        });
        times.insert(rows.to_string(), json!({ "lstsq": lstsq, "pysindy": stlsq }));
    }
    json!({ "candidates": columns.len(), "seconds": times })
}
