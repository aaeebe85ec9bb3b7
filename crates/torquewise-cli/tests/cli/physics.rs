//! Models that no arm can be: said first by `fit`, shown by `show --check`, refused by `export`.

use crate::spoilt::{Table, assert_warns, noise};
use crate::terminal::{Terminal, numbers};
use serde_json::{Value, json};

/// A fitted model, and as `changed.json` what a change makes of its file.
pub(crate) fn changed(change: impl FnOnce(&mut Value)) -> Terminal {
    let terminal = Terminal::with_model();
    let mut model: Value = serde_json::from_str(&terminal.read("model.json")).unwrap();
    change(&mut model);
    terminal.write("changed.json", &model.to_string());
    terminal
}

/// Multiplies what M₁₁ holds beside its constant.
fn scale_m11(model: &mut Value, factor: f64) {
    let terms = model["form"]["energy"].as_array_mut().unwrap();
    let varying = terms.iter_mut().find(|term| {
        let function = &term["term"]["function"]["factors"];
        term["term"]["place"] == json!({ "inertia": [0, 0] }) && function != &json!([])
    });
    let coefficient = &mut varying.unwrap()["coefficient"];
    *coefficient = json!(factor * coefficient.as_f64().unwrap());
}

#[test]
fn fit_says_first_that_the_mass_matrix_is_not_positive_definite() {
    let terminal = Terminal::new();
    terminal.done("simulate puma560-3 -o log.csv --seconds 20 --rate 50 --case 3 --seed 1");

    let said = terminal.run("fit log.csv -o model.json --library product --strict");
    let fit = terminal.json("fit log.csv -o model.json --library product");

    assert_warns(&said, &["export refuses the model; record more motion"]);
    assert!(said.stdout.starts_with("NOT PHYSICAL: M(q) has the eigenvalue -"), "{said:?}");
    assert!(said.stdout.lines().next().unwrap().contains(" at q = ("), "{said:?}");
    assert_eq!(fit["mass_matrix"]["positive_definite"], false);
    assert_eq!(fit["mass_matrix"]["q"].as_array().unwrap().len(), 3);
}

#[test]
fn export_refuses_any_model_that_is_not_positive_definite_unless_forced() {
    let terminal = changed(|model| scale_m11(model, -20.0));

    terminal.refused(
        "export changed.json --to c -o arm.c",
        &["M(q) has the eigenvalue -", "at q = (", "fit anew", "--force"],
    );
    let forced = terminal.run("export changed.json --to c -o arm.c --force --strict");

    assert_eq!(forced.code, 3, "{forced:?}");
    assert!(forced.stderr.starts_with("warning: M(q) has the eigenvalue -"), "{forced:?}");
    assert!(terminal.read("arm.c").contains("arm_torque"));
    terminal.done("export model.json --to c -o arm.c --force");
}

#[test]
fn the_check_looks_beyond_the_training_range() {
    let terminal = changed(|model| {
        scale_m11(model, 20.0);
        model["training"]["q_range"] = json!([[-0.1, 0.1], [-0.1, 0.1]]);
    });

    let said = terminal.run("show changed.json --check --strict");
    let checks = &terminal.json("show changed.json --check --states 500")["checks"];

    assert_warns(&said, &["in a whole turn"]);
    assert!(said.stdout.contains("M(q) positive definite  yes  training range"), "{said:?}");
    assert!(said.stdout.contains("M(q) positive definite  NO   whole turn"), "{said:?}");
    assert_eq!((&checks["feasible"], &checks["passed"]), (&json!(false), &json!(false)));
    assert_eq!(checks["states"], 1000);
    let smallest = |range: &str| checks[range]["smallest_eigenvalue"].as_f64().unwrap();
    assert!(smallest("trained") > 0.0 && smallest("whole_turn") < 0.0, "{checks}");
    assert_eq!(checks["smallest_eigenvalue"], checks["whole_turn"]["smallest_eigenvalue"]);
    terminal.done("export changed.json --to c -o arm.c");
}

#[test]
fn the_check_tells_whether_friction_takes_power() {
    let law = |law: Value, coefficient: f64| {
        let term = json!({ "shaft": [0.0, 1.0], "law": law });
        json!({ "term": term, "coefficient": coefficient, "std_error": 0.01 })
    };
    let offset = law(json!("offset"), -3.0);
    let driving = law(json!({ "coulomb": { "width": 0.0 } }), -0.7);
    let taking = changed(|model| model["friction"] = json!([offset, law(json!("viscous"), 1.0)]));
    let giving = changed(|model| model["friction"] = json!([offset, driving]));

    let sound = &taking.json("show changed.json --check")["checks"];
    let said = giving.run("show changed.json --check --strict");
    let unsound = &giving.json("show changed.json --check")["checks"];

    assert_eq!((&sound["friction_passive"], &sound["feasible"]), (&json!(true), &json!(true)));
    assert_eq!((&unsound["friction_passive"], &unsound["feasible"]), (&json!(false), &json!(true)));
    assert_warns(&said, &["drives it with"]);
    assert!(said.stdout.contains("friction takes power    NO   friction of the shaft of joint 2"));
}

#[test]
fn bounds_hold_the_torque_of_another_motion() {
    let terminal = Terminal::new();
    terminal.done("simulate puma560-3 -o train.csv --seconds 60 --rate 100 --case 2 --seed 1");
    terminal.done(
        "simulate puma560-3 -o test.csv --motion sines --seconds 30 --rate 100 --case 2 --seed 2",
    );
    terminal.done("fit train.csv -o model.json --library chain --friction none");

    terminal.done("predict model.json test.csv -o bounds.csv --interval 95");

    let said = numbers(&terminal.json("evaluate model.json test.csv")["interval_coverage_percent"]);
    let [log, bounds] = ["test.csv", "bounds.csv"].map(|file| Table::of(&terminal, file));
    for joint in 1..=3 {
        let of = |table: &Table, name: &str| table.column(&format!("{name}{joint}"));
        let (tau, low, high) = (of(&log, "tau"), of(&bounds, "tau_low"), of(&bounds, "tau_high"));
        let within = (0..tau.len()).filter(|&k| low[k] <= tau[k] && tau[k] <= high[k]).count();
        let share = within as f64 / tau.len() as f64;
        assert!((0.90..=0.98).contains(&share), "joint {joint}: {share}");
        assert!((said[joint - 1] - 100.0 * share).abs() < 1e-9, "joint {joint}: {share} {said:?}");
    }
}

#[test]
fn what_dry_friction_may_hold_at_rest_widens_bounds_and_does_not_count() {
    let terminal = Terminal::holding("log.csv", &Table::recorded().text());
    terminal.run("fit log.csv -o arm.json");
    let pose = terminal.json("predict arm.json --q 0.3,-0.8");
    let gravity = numbers(&pose["tau"]);
    // Of 0.4 N·m that both joints break away at.
    for (held, is_judged) in [(0.3, false), (4.0, true)] {
        let mut still = Table::recorded();
        still.rows.truncate(800);
        for (place, value) in [(1, 0.3), (2, -0.8), (3, 0.0), (4, 0.0)] {
            still.rows.iter_mut().for_each(|row| row[place] = value);
        }
        for joint in [0, 1] {
            let tau = |row: usize, _: f64, _: &[f64]| gravity[joint] + held + 0.05 * noise(row);
            still = still.with(&format!("tau{}", joint + 1), tau);
        }
        terminal.write("still.csv", &still.text());

        let said = terminal.json("evaluate arm.json still.csv");

        let covered = numbers(&said["interval_coverage_percent"]);
        assert_eq!(covered.iter().all(|held| *held > 95.0), !is_judged, "{said}");
        let because = said["because"].to_string();
        assert_eq!(because.contains("no joint of the test moves"), !is_judged, "{said}");
        let is_told = |word: &str| said["notes"].to_string().contains(word);
        let second = if is_judged { " % counts) and joint2 (" } else { "joint1 and joint2" };
        assert!(is_told("at rest dry friction may hold joint1") && is_told(second), "{said}");
        let line = "contacts arm.json still.csv --free log.csv -o external.csv";
        let contacts = terminal.json(line)["contacts"].as_array().unwrap().len();
        assert_eq!(contacts > 0, is_judged);
        let pose =
            terminal.run("inspect still.csv").stdout + &terminal.run("patterns still.csv").stdout;
        assert!(!["gravity", "leads"].iter().any(|word| pose.contains(word)), "{pose}");
        let rests = |line: &&str| line.starts_with("standstill") && line.ends_with(" 100.0");
        assert_eq!(pose.lines().filter(rests).count(), 2, "{pose}");
    }
}

#[test]
fn errors_of_the_arm_count_what_joints_disagree_about() {
    let terminal = Terminal::new();
    terminal.done("simulate puma560-3 -o log.csv --seconds 40 --rate 100 --case 2 --seed 1");
    let table = Table::of(&terminal, "log.csv").scaled(&["tau3"], 1.15);
    terminal.write("gain.csv", &table.text());

    // The joints that lie before the second and the third: on it, and a link of 0.4318 m away.
    let errors = |log: &str| -> Vec<f64> {
        terminal.run(&format!("fit {log}.csv --library chain -o {log}.json"));
        let geometry = &terminal.json(&format!("show {log}.json"))["geometry"];
        let of = |(joint, truth): (usize, f64)| {
            let distance = &geometry[joint]["distance_to_previous_m"];
            let [value, error] = ["value", "std_error"].map(|key| distance[key].as_f64().unwrap());
            assert!((value - truth).abs() < 2.0 * error, "{log} {joint}: {distance}");
            error
        };
        [(1, 0.0), (2, 0.4318)].map(of).to_vec()
    };
    let (sound, torn) = (errors("log"), errors("gain"));

    assert!(torn[0] > 4.0 * sound[0] && torn[1] > 2.0 * sound[1], "{torn:?} {sound:?}");
}
