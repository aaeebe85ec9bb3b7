//! Exported C, Rust and Python, compiled and run: each computes what the model's own evaluation
//! does.

#![expect(clippy::unwrap_used, reason = "a test may panic")]

mod models;
mod witness;
mod run;

use models::{energies, products, states};
use torquewise_export::{Precision, Program, to_c, to_python, to_rust};
use torquewise_model::Model;
use witness::{expected, worst};

/// The bound that controllers are promised; observed 1e-14 and below.
const AGREES: f64 = 1e-12;

/// Arms of three, six and seven joints, by energies and by torque equations.
fn arms() -> Vec<Model> {
    vec![energies(3, 25, 1), products(3, 20, 2), energies(6, 200, 3), energies(7, 300, 4)]
}

fn check(model: &Model, run: impl Fn(&Program, &[models::State]) -> Vec<Vec<f64>>) {
    let program = Program::of(model).unwrap();
    let states = states(model.n_joints(), 1000, 7);

    let found = run(&program, &states);

    let error = worst(&found, &expected(model, &states));
    println!("{} joints: {error:.1e}", model.n_joints());
    assert!(error < AGREES, "{} joints: {error:.1e}", model.n_joints());
}

#[test]
fn exported_c_computes_what_the_model_predicts() {
    if !run::has("cc") {
        return;
    }
    for model in arms() {
        let folder = tempfile::tempdir().unwrap();
        check(&model, |program, states| {
            let code = to_c(program, "arm", Precision::Double).unwrap();
            run::c(folder.path(), &code, "double", states)
        });
    }
}

#[test]
fn single_precision_c_is_as_good_as_single_precision() {
    if !run::has("cc") {
        return;
    }
    let (model, folder) = (energies(6, 200, 3), tempfile::tempdir().unwrap());
    let program = Program::of(&model).unwrap();
    let single = |x: &f64| f64::from(*x as f32);
    let states: Vec<models::State> = states(6, 1000, 7)
        .iter()
        .map(|state| state.each_ref().map(|signal| signal.iter().map(single).collect()))
        .collect();

    let code = to_c(&program, "arm", Precision::Single).unwrap();
    let found = run::c(folder.path(), &code, "float", &states);

    // Some hundred roundings of 6e-8.
    let error = worst(&found, &expected(&model, &states));
    assert!(error < 1e-5 && error > 1e-9, "{error:.1e}");
    assert!(!code.contains("double"));
}

#[test]
fn exported_rust_computes_what_the_model_predicts() {
    if !run::has("rustc") {
        return;
    }
    for model in arms() {
        let folder = tempfile::tempdir().unwrap();
        check(&model, |program, states| {
            let code = to_rust(program, Precision::Double).unwrap();
            run::rust(folder.path(), &code, states)
        });
    }
}

#[test]
fn exported_python_computes_what_the_model_predicts() {
    if !run::has("python3") {
        return;
    }
    for model in arms() {
        let folder = tempfile::tempdir().unwrap();
        check(&model, |program, states| run::python(folder.path(), &to_python(program), states));
    }
}
