//! Exported C, Rust and Python, compiled and run: each computes what the model's own evaluation
//! does.

#![expect(clippy::unwrap_used, reason = "a test may panic")]

mod models;
mod witness;
mod run;
mod ros;
mod robots;

use models::{
    chain, coupled, energies, loaded, parallel, products, remembers, remembers_all, sliding, states,
};
use std::io::Read;
use std::path::Path;
use torquewise_export::{
    ExportError, Precision, Program, Quantity, fmu_archive, fmu_sources, test_vectors, to_c,
    to_latex, to_python, to_rust, torque_costs,
};
use torquewise_model::Model;
use witness::{expected, expected_along, worst};

/// The bound that controllers are promised; observed 1e-14 and below.
const AGREES: f64 = 1e-12;

/// Arms of three, six and seven joints, by energies, by torque equations and as chains.
fn arms() -> Vec<Model> {
    let of_three = [energies(3, 25, 1), products(3, 20, 2)];
    let of_more = [energies(6, 200, 3), parallel(6, 60, 5), energies(7, 300, 4)];
    let coupled = [coupled(3, true, 8), coupled(4, false, 9), coupled(6, false, 10)];
    let loaded = [loaded(chain(6, false, 5)), loaded(products(3, 20, 2))];
    let sliding = [sliding(3, true, 6), sliding(6, true, 7)];
    let chains = chains().into_iter().chain(coupled).chain(sliding);
    of_three.into_iter().chain(of_more).chain(chains).chain(loaded).collect()
}

/// Arms that are rigid chains, of axes at right angles and skew ones.
fn chains() -> Vec<Model> {
    let arms = [(2, false), (3, false), (3, true), (4, false), (6, false), (6, true), (7, false)];
    (1..).zip(arms).map(|(seed, (n, skew))| chain(n, skew, seed)).collect()
}

/// What runs exported code of a program at some states in a folder.
type Run<'a> = &'a dyn Fn(&Path, &Program, &[models::State]) -> Vec<Vec<f64>>;

/// Whether code computes what the model predicts, at states and along a path that it remembers.
fn check(tool: &str, at_states: Option<Run<'_>>, along: Run<'_>) {
    if !run::has(tool) {
        return;
    }
    for (model, run) in at_states.iter().flat_map(|run| arms().into_iter().map(move |m| (m, run))) {
        let folder = tempfile::tempdir().unwrap();
        let states = states(model.n_joints(), 1000, 7);

        let found = run(folder.path(), &Program::of(&model).unwrap(), &states);

        let error = worst(&found, &expected(&model, &states));
        println!("{} joints: {error:.1e}", model.n_joints());
        assert!(error < AGREES, "{} joints: {error:.1e}", model.n_joints());
    }
    let remembering = [remembers(energies(3, 25, 1)), remembers_all(loaded(chain(6, false, 5)))];
    let remembering = remembering.map(|model| (models::way(model.n_joints()), model));
    // Code that remembers nothing has no state; a unit is called the same way.
    let forgetful = at_states.is_none().then(|| (states(6, 1000, 7), energies(6, 200, 3)));
    for (way, model) in remembering.into_iter().chain(forgetful) {
        let folder = tempfile::tempdir().unwrap();

        let found = along(folder.path(), &Program::of(&model).unwrap(), &way);

        assert_along(&model, &found, &way);
    }
}

#[test]
fn exported_c_computes_what_the_model_predicts_and_remembers_the_path() {
    let code = |program: &Program| to_c(program, "arm", Precision::Double).unwrap();
    check(
        "cc",
        Some(&|folder, program, states| run::c(folder, &code(program), "double", states)),
        &|folder, program, way| run::c_along(folder, &code(program), way),
    );
}

#[test]
fn exported_rust_computes_what_the_model_predicts_and_remembers_the_path() {
    let code = |program: &Program| to_rust(program, Precision::Double).unwrap();
    check(
        "rustc",
        Some(&|folder, program, states| run::rust(folder, &code(program), states)),
        &|folder, program, way| run::rust_along(folder, &code(program), way),
    );
}

#[test]
fn exported_python_computes_what_the_model_predicts_and_remembers_the_path() {
    let code = |program: &Program| to_python(program).unwrap();
    check(
        "python3",
        Some(&|folder, program, states| run::python(folder, &code(program), states)),
        &|folder, program, way| run::python_along(folder, &code(program), way),
    );
}

#[test]
fn a_unit_gives_the_torque_to_whoever_calls_fmi_and_remembers_the_path() {
    check("cc", None, &run::unit);
}

#[test]
fn single_precision_c_is_as_good_as_single_precision() {
    if !run::has("cc") {
        return;
    }
    let (model, folder) = (remembers(energies(6, 200, 3)), tempfile::tempdir().unwrap());
    let program = Program::of(&model).unwrap();
    #[expect(clippy::cast_possible_truncation, reason = "single precision is meant")]
    let single = |x: &f64| f64::from(*x as f32);
    let single = |state: &models::State| state.each_ref().map(|x| x.iter().map(single).collect());
    let states: Vec<models::State> = states(6, 1000, 7).iter().map(single).collect();

    let code = to_c(&program, "arm", Precision::Single).unwrap();
    let found = run::c(folder.path(), &code, "float", &states);

    // Some hundred roundings of 6e-8.
    let error = worst(&found, &expected(&model, &states));
    assert!(error < 1e-5 && error > 1e-9, "{error:.1e}");
    assert!(!code.contains("double"));
}

#[test]
fn the_cost_is_what_a_call_carries_out() {
    if !run::has("python3") {
        return;
    }
    for model in arms() {
        let (program, folder) = (Program::of(&model).unwrap(), tempfile::tempdir().unwrap());

        let done = run::counted(folder.path(), &to_python(&program).unwrap());

        for (quantity, done) in Quantity::ALL.into_iter().zip(done) {
            let cost = program.cost(quantity);
            if done[1] as u64 == i64::MAX as u64 {
                assert!(model.chain.is_none());
                continue;
            }
            assert_eq!(done[1], cost.functions, "{}", quantity.name());
            if quantity == Quantity::Torque {
                // A change of sign may vanish in a subtraction.
                let signs = 1 + cost.operations / 50;
                assert!(done[0].abs_diff(cost.operations) <= signs, "{done:?}, {cost}");
            }
        }
    }
}

#[test]
fn a_chain_costs_its_recursion_and_not_its_terms() {
    let cost = |model: &Model| Program::of(model).unwrap().cost(Quantity::Torque);

    let chain = chain(6, false, 5);

    // Khalil and Kleinfinger (1987) count 738 for six joints anyhow, some 500 at right angles; 58
    // are friction and drives.
    let costs = cost(&chain);
    println!("{costs}");
    assert!(costs.operations < 800, "{costs}");
    assert_eq!(torque_costs(&chain).unwrap(), [costs]);
}

#[test]
fn a_unit_is_an_archive_of_its_files_and_the_same_each_time() {
    let program = Program::of(&energies(3, 25, 1)).unwrap();
    let sources = fmu_sources(&program, "arm").unwrap();
    let binary = ("binaries/linux64/arm.so", &b"binary"[..]);

    let bytes = fmu_archive(&sources, Some(binary)).unwrap();

    assert_eq!(bytes, fmu_archive(&sources, Some(binary)).unwrap());
    let mut archive = zip::ZipArchive::new(std::io::Cursor::new(bytes)).unwrap();
    for (path, text) in &sources {
        let mut found = String::new();
        archive.by_name(path).unwrap().read_to_string(&mut found).unwrap();
        assert_eq!(&found, text);
    }
    assert_eq!(archive.len(), sources.len() + 1);
}

#[test]
fn a_latex_document_closes_what_it_opens_and_says_what_its_friction_follows() {
    let arm = energies(3, 25, 1);
    for (model, followed) in [
        (arm.clone(), Some([false, false])),
        (loaded(arm.clone()), Some([false, true])),
        (products(3, 20, 2), None),
        (remembers(arm), Some([true, true])),
    ] {
        let text = to_latex(&model, "version_1");

        assert_eq!(text.matches("\\begin{").count(), text.matches("\\end{").count());
        let plain = text.replace("\\{", "").replace("\\}", "");
        assert_eq!(plain.matches('{').count(), plain.matches('}').count());
        assert!(text.contains("version\\_1") && text.trim_end().ends_with("\\end{document}"));
        let found = [text.contains("\\mathrm{d}x_\\delta"), text.contains("$G_j$")];
        assert_eq!(found, followed.unwrap_or(found));
    }
}

/// The model's own observer takes the rate of M by differences, right to some 1e-8.
const OBSERVES: f64 = 1e-6;

fn assert_along(model: &Model, found: &[Vec<f64>], way: &[models::State]) {
    let (n, expected) = (model.n_joints(), expected_along(model, way));
    for (first, bound) in [(0, AGREES), (n, AGREES), (2 * n, OBSERVES), (3 * n, AGREES)] {
        let part = |rows: &[Vec<f64>]| -> Vec<Vec<f64>> {
            rows.iter().map(|row| row[first..first + n].to_vec()).collect()
        };
        let error = worst(&part(found), &part(&expected));
        println!("{n} joints, outputs from {first}: {error:.1e}");
        assert!(error < bound, "{n} joints, outputs from {first}: {error:.1e}");
    }
}

#[test]
fn a_latex_document_is_typeset_within_its_margins() {
    let mut arms = [energies(6, 200, 3), products(3, 20, 2)];
    arms[1].joints = ["größe_1 %", "λ ^ 軸", "\\input{x} #~"].map(String::from).to_vec();
    for model in arms {
        let folder = tempfile::tempdir().unwrap();

        let Some(log) = run::typeset(folder.path(), &to_latex(&model, "version_1")) else { return };

        // `Overfull \hbox (43.5pt too wide)`; some points stay within the margins.
        let wide = log.split("Overfull \\hbox (").skip(1).map(|rest| rest.split("pt").next());
        let widths: Vec<f64> = wide.map(|points| points.unwrap().parse().unwrap()).collect();
        assert!(widths.iter().all(|points| *points < 20.0), "{widths:?}");
    }
}

#[test]
fn test_vectors_are_what_the_model_returns() {
    for model in [energies(3, 25, 1), chain(3, true, 4)] {
        let text = test_vectors(&model, 20, 5).unwrap();

        assert_eq!(text, test_vectors(&model, 20, 5).unwrap());
        assert_ne!(text, test_vectors(&model, 20, 6).unwrap());
        let rows = text.lines().skip(1).map(|line| line.split(',').map(|x| x.parse().unwrap()));
        let rows: Vec<Vec<f64>> = rows.map(Iterator::collect).collect();
        let state = |row: &Vec<f64>| [0, 3, 6].map(|first| row[first..first + 3].to_vec());
        let states: Vec<models::State> = rows.iter().map(state).collect();
        // The acceleration of the torque stands last, that of its numbers is expected there.
        let but_last = |row: &Vec<f64>| row[..row.len() - 3].to_vec();
        let values: Vec<Vec<f64>> = rows.iter().map(|row| but_last(row)[9..].to_vec()).collect();
        let expected: Vec<_> = expected(&model, &states).iter().map(but_last).collect();
        let error = worst(&values, &expected);
        assert!(error < AGREES, "{error:.1e}");
        for row in rows.iter().filter(|_| model.chain.is_some()) {
            for (found, ddq) in row[row.len() - 3..].iter().zip(&row[6..9]) {
                assert!((found - ddq).abs() < AGREES * (1.0 + ddq.abs()), "{found} for {ddq}");
            }
        }
    }
}

#[test]
fn a_name_that_is_none_and_a_number_that_is_too_large_are_refused() {
    let program = Program::of(&energies(3, 25, 1)).unwrap();
    for name in ["", "3arm", "my arm", "_arm", "größe"] {
        let refused = to_c(&program, name, Precision::Double);
        assert!(matches!(refused, Err(ExportError::Name { .. })), "{name}");
    }
    let mut large = products(3, 20, 2);
    if let torquewise_model::Form::Torque(joints) = &mut large.form {
        joints[0][0].coefficient = 1e300;
    }
    let program = Program::of(&large).unwrap();
    assert!(to_c(&program, "arm", Precision::Double).is_ok());
    let refused = to_rust(&program, Precision::Single);
    assert!(matches!(refused, Err(ExportError::NotSingle { .. })));
}
