//! The whole library of SINDy, three joints: least squares, STLSQ, the path of the LASSO.

use crate::trial::{KINDS, N, grams, moves, select_each, timed, write, write_motion, write_terms};
use faer::Mat;
use serde_json::{Map, Value, json};
use std::path::Path;
use torquewise_identify::{LibraryKind, Regression};
use torquewise_motion::Motion;
use torquewise_regression::select::lasso::{Lasso, lasso_path};
use torquewise_regression::select::stlsq::Stlsq;
use torquewise_regression::{NormalEquations, PreparedDesign};
use torquewise_stepwise::Candidates;

const ROWS: usize = 20_000;
/// The joint that the LASSO explains.
const JOINT: usize = 1;
/// Order of the largest library.
const ORDER: u8 = 4;

/// Times at each order of the library.
pub(crate) fn run(folder: &Path) -> Value {
    let motion = moves(ROWS);
    write_motion(&folder.join("rows.f64"), &motion);
    let mut sizes = Map::new();
    for order in 1..=ORDER {
        let (p, times) = sindy(&motion, order, folder);
        sizes.insert(p.to_string(), times);
    }
    json!({ "rows": ROWS, "candidates": sizes })
}

/// Number of candidates and times at one order; the weights are written at the largest.
fn sindy(motion: &Motion, order: u8, folder: &Path) -> (usize, Value) {
    let library = LibraryKind::Product { gravity_order: 2, trig_order: order };
    let candidates =
        Candidates::new(&KINDS, library, Regression::OneShot, Vec::new()).expect("a library");
    let p = candidates.n_columns();
    let route = PreparedDesign::cheaper(&candidates.design, N, ROWS).route();
    let columns: Vec<usize> = (0..p).collect();
    let mut out = json!({ "route": format!("{route:?}") });

    let (all, seconds) = timed("gram", || grams(&candidates, motion, 1).remove(0));
    out["gram"] = seconds;
    let (weights, seconds) = timed("lstsq", || all.weights());
    out["lstsq"] = seconds;
    // With the ridge that PySINDy has by default, and without.
    for (name, ridge) in [("stlsq", 0.05), ("stlsq_without_ridge", 0.0)] {
        let (active, seconds) = timed(name, || {
            let stlsq = Stlsq { ridge, ..Stlsq::default() };
            let selected = select_each(&stlsq, &all);
            selected.iter().map(|selection| selection.active.len()).sum::<usize>()
        });
        out[name] = seconds;
        out[format!("{name}_active")] = json!(active);
    }
    let lasso = Lasso { ratio: 1e-3, gap_tolerance: 1e-5, max_sweeps: 100_000, ..Lasso::default() };
    let (own, energy) = (all.cross.col_as_slice(JOINT), all.energy[JOINT]);
    let second = NormalEquations::new(all.gram.clone(), own, energy, all.rows);
    let second = second.expect("finite sums");
    let (path, seconds) =
        timed("lasso", || lasso_path(&second, &lasso).expect("settings within range"));
    let gap = path.iter().map(|point| point.gap).fold(0.0, f64::max);
    let energy = energy / ROWS as f64;
    out["lasso"] = seconds;
    out["gap"] = json!(gap / energy);
    if order == ORDER {
        let flat = |w: &Mat<f64>| {
            w.col_iter().flat_map(|c| c.iter().copied().collect::<Vec<_>>()).collect::<Vec<f64>>()
        };
        write(&folder.join("ours_lstsq.f64"), flat(&weights).into_iter());
        let lambdas = path.iter().map(|point| point.lambda);
        write(&folder.join("lambdas.f64"), lambdas);
        let points = path.iter().flat_map(|point| point.coefficients.iter().copied());
        write(&folder.join("ours_lasso.f64"), points);
    }
    write_terms(&folder.join(format!("terms{p}.txt")), &candidates, &columns);
    (p, out)
}
