//! Time over the number of rows: a small library, least squares.

use crate::trial::{N, blocks, moves, problem, timed, write_motion, write_terms};
use serde_json::{Map, Value, json};
use std::path::Path;
use torquewise_identify::candidates::Candidates;
use torquewise_identify::{LibraryKind, Method};
use torquewise_sparse::accumulate::{Prepared, cheaper_route};
use torquewise_sparse::row_sums::RowAdder;

/// Rows of the log, which larger numbers of rows go through again and again.
const ROWS: usize = 10_000;
const REPEATS: [usize; 4] = [1, 10, 100, 1_000];

/// Seconds from rows in memory to weights, for each number of rows.
pub(crate) fn run(folder: &Path) -> Value {
    let motion = moves("puma560-3", ROWS, 3);
    let library = LibraryKind::Product { gravity_order: 1, trig_order: 1 };
    let candidates = Candidates::new(N, library, Method::Sindy).expect("a library");
    let columns: Vec<usize> = (0..candidates.len()).collect();
    write_motion(&folder.join("many.f64"), &motion);
    write_terms(&folder.join("many.txt"), &candidates, &columns);

    let mut times = Map::new();
    for repeats in REPEATS {
        let rows = ROWS * repeats;
        let (_, seconds) = timed(&format!("{rows} rows"), || {
            let route = cheaper_route(&candidates.design, N, rows);
            let prepared = Prepared::new(&candidates.design, route);
            let mut adder = RowAdder::new(&prepared, N);
            for _ in 0..repeats {
                for block in blocks(&motion) {
                    adder.push(block).expect("a block that fits");
                }
            }
            let sums = adder.finish().expect("sums within range");
            let (all, cross, _) = problem(sums.grams(&prepared, N, &columns).remove(0), 0);
            all.refit_each(&columns, cross.as_ref()).expect("columns of the library")
        });
        times.insert(rows.to_string(), seconds);
    }
    json!({ "candidates": columns.len(), "seconds": times })
}
