//! The energy library, whose coefficients all joints share: three joints, then six.

use crate::trial::{N, errors, fitted, grams, moves, test, timed, write, write_motion};
use serde_json::{Value, json};
use std::path::Path;
use torquewise_identify::plan::{ChainOptions, FrictionKind, LibraryOptions, Regression};
use torquewise_identify::{LibraryKind, Plan};
use torquewise_model::library::energy_library;
use torquewise_model::{Form, Model, Weighted, to_json};
use torquewise_motion::Motion;
use torquewise_regression::normal_equations::NormalEquations;
use torquewise_regression::select::lasso::{Lasso, lasso_path};
use torquewise_stepwise::candidates::Candidates;

const ROWS: usize = 20_000;
/// Of six joints: what 9 947 candidates leave a peer memory for.
const FEW_ROWS: usize = 4_000;

/// All 84 candidates: sums and least squares, sums and the path of the LASSO, a whole fit.
pub(crate) fn three_joints(folder: &Path) -> Value {
    let (motion, test) = (moves("puma560-3", ROWS, 3), test("puma560-3"));
    write_files(folder, "energy3", &motion, &test);
    let library = LibraryKind::Energy { interaction: None };
    let candidates =
        Candidates::new(N, library, Regression::Stepwise, Vec::new()).expect("a library");
    let columns: Vec<usize> = (0..candidates.len()).collect();

    let (all, gram) = timed("gram", || stacked(&grams(&candidates, &motion, 1), &motion));
    let (_, lstsq) = timed("lstsq", || all.refit(&columns).expect("columns of the library"));
    let lasso = Lasso { ratio: 1e-3, gap_tolerance: 1e-5, max_sweeps: 100_000, ..Lasso::default() };
    let (path, seconds) =
        timed("lasso", || lasso_path(&all, &lasso).expect("settings within range"));
    write(&folder.join("energy3_lambdas.f64"), path.iter().map(|point| point.lambda));
    let plan = Plan::from(LibraryOptions { bags: 0, ..LibraryOptions::default() });
    let (found, fit) = fitted(&motion, &plan);
    json!({
        "rows": ROWS,
        "candidates": candidates.len(),
        "gram": gram,
        "lstsq": lstsq,
        "lasso": seconds,
        "fit": fit,
        "active": found.model.n_coefficients(),
        "errors": errors(&found.model, &test),
    })
}

/// A chain that is learned, and what it makes of the 9 947 candidates.
pub(crate) fn six_joints(folder: &Path) -> Value {
    let (motion, test) = (moves("generic-6", FEW_ROWS, 2), test("generic-6"));
    write_files(folder, "energy6", &motion, &test);
    let plan = Plan::from(ChainOptions { friction: FrictionKind::None, ..ChainOptions::default() });
    let (found, fit) = fitted(&motion, &plan);
    json!({
        "rows": FEW_ROWS,
        "candidates": energy_library(motion.n_joints(), None).len(),
        "fit": fit,
        "active": found.model.n_coefficients(),
        "errors": errors(&found.model, &test),
    })
}

/// One regression of all joints, the rows of each divided by the spread of its torque.
fn stacked(grams: &[NormalEquations], motion: &Motion) -> NormalEquations {
    let mut all = NormalEquations::zeros(grams[0].n_columns(), 1);
    for (joint, own) in grams.iter().enumerate() {
        let tau = motion.require_tau().expect("a torque").col(joint);
        let mean = tau.iter().sum::<f64>() / tau.nrows() as f64;
        let variance = tau.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / tau.nrows() as f64;
        all.add(own, variance.recip()).expect("equations of one library");
    }
    all
}

/// Rows to fit and to judge by, and the library as a model file of coefficients 1.
fn write_files(folder: &Path, task: &str, motion: &Motion, test: &Motion) {
    write_motion(&folder.join(format!("{task}.f64")), motion);
    write_motion(&folder.join(format!("{task}_test.f64")), test);
    let unit = |term| Weighted::new(term, 1.0);
    let terms = energy_library(motion.n_joints(), None).into_iter().map(unit).collect();
    let library =
        Model { joints: motion.joints().to_vec(), form: Form::Energy(terms), ..Model::default() };
    let text = to_json(&library).expect("a model of this arm");
    std::fs::write(folder.join(format!("{task}.json")), text).expect("a folder");
}
