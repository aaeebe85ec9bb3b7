//! simulate → inspect → patterns → fit → show → predict → evaluate → compare.

use crate::spoilt::{Table, assert_tells};
use crate::terminal::{Terminal, each};

fn nrmse_percent(tau: &[f64], tau_hat: &[f64]) -> f64 {
    let m = tau.len() as f64;
    let mean = tau.iter().sum::<f64>() / m;
    let variance = tau.iter().map(|tau| (tau - mean).powi(2)).sum::<f64>() / m;
    let error = tau.iter().zip(tau_hat).map(|(a, b)| (a - b).powi(2)).sum::<f64>() / m;
    100.0 * (error / variance).sqrt()
}

#[test]
fn evaluate_notes_and_predict_marks_where_a_log_leaves_the_range_of_the_fit() {
    let terminal = Terminal::with_model();
    let mut log = Table::of(&terminal, "log.csv");
    terminal.write("turned.csv", &log.clone().with("q1", |_, q1, _| q1 + 30.0).text());
    terminal.write("degrees.csv", &log.clone().with("q1", |_, q1, _| q1.to_degrees()).text());
    log.rows[49][3] = 9.5;
    terminal.write("fast.csv", &log.text());

    let [inside, outside] =
        ["log", "turned"].map(|log| terminal.run(&format!("evaluate model.json {log}.csv")));

    assert!(!inside.stderr.contains("leaves the range"), "{inside:?}");
    assert!(outside.stderr.contains("note: joint1 leaves the range"), "{outside:?}");
    let degrees = terminal.run("evaluate model.json degrees.csv").stderr;
    assert!(degrees.contains("joint1 leaves") && degrees.contains("degrees?"), "{degrees}");
    assert!(!outside.stderr.contains("degrees?"), "{outside:?}");
    for (log, beyond) in [("log", "0"), ("turned", "1")] {
        terminal.run(&format!("predict model.json {log}.csv -o torque.csv"));
        let marked = Table::of(&terminal, "torque.csv").column("outside_range");
        assert!(
            marked.len() > 1_000 && marked.iter().all(|own| own.to_string() == beyond),
            "{log}"
        );
    }
    let said = terminal.run("predict model.json fast.csv -o torque.csv --strict");
    assert_eq!(said.code, 3);
    assert!(said.stderr.starts_with("warning: ") && said.stderr.contains("dq to 9.50 rad/s"));
    assert!(terminal.path("torque.csv").exists());
}

#[test]
fn scoring_the_predicted_torque_by_hand_gives_what_evaluate_says() {
    let terminal = Terminal::new();
    terminal.done("simulate planar-2 -o log.csv --seconds 60 --rate 50 --seed 3 --case 3");
    terminal.run("fit log.csv -o model.json --library product");

    let scores = terminal.json("evaluate model.json log.csv");
    terminal.done("predict model.json log.csv -o torque.csv");

    let [log, torque] = ["log.csv", "torque.csv"].map(|file| Table::of(&terminal, file));
    for (joint, said) in (1..).zip(each(&scores["joints"], "nrmse_percent")) {
        let [measured, tau_hat, residual] = ["tau_measured", "tau_hat", "residual"]
            .map(|name| torque.column(&format!("{name}{joint}")));
        assert_eq!(measured, log.column(&format!("tau{joint}")));
        let own = nrmse_percent(&measured, &tau_hat);
        // Two sums of 3 000 rows taken in another order.
        assert!((own - said).abs() <= 1e-9 * own, "{own} {said}");
        for (row, residual) in residual.iter().enumerate() {
            let expected = measured[row] - tau_hat[row];
            assert_eq!(residual.to_bits(), expected.to_bits(), "row {row}");
        }
    }
}

#[test]
fn the_log_of_a_model_is_predicted_within_its_range() {
    let terminal = Terminal::holding("log.csv", &Table::recorded().text());
    terminal.done("fit log.csv -o model.json");

    let said = terminal.run("predict model.json log.csv -o torque.csv");

    assert!(!said.stderr.contains("leaves the range"), "{said:?}");
    // Where its filter has not settled there is no row.
    let torque = Table::of(&terminal, "torque.csv");
    assert!(torque.rows.len() < 2_000 && torque.rows[0][0] > 0.1, "{}", torque.rows.len());
    let residual = torque.column("residual1").iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    assert!(residual < 0.5, "{residual}");
}

#[test]
fn a_log_without_torque_can_be_predicted() {
    let terminal = Terminal::with_model();
    let bare = Table::of(&terminal, "log.csv").without(&["tau1", "tau2"]);
    terminal.write("bare.csv", &bare.text());

    terminal.done("predict model.json log.csv -o with.csv");
    terminal.done("predict model.json bare.csv -o without.csv");

    assert!(terminal.read("without.csv").starts_with("t,tau_hat1,tau_hat2,outside_range\n"));
    let [with, without] = ["with.csv", "without.csv"].map(|file| Table::of(&terminal, file));
    for name in ["t", "tau_hat1", "tau_hat2"] {
        assert_eq!(with.column(name), without.column(name));
    }
}

#[test]
fn the_first_step_knows_gravity_alone() {
    let terminal = Terminal::with_model();

    terminal.done("predict model.json log.csv -o torque.csv --parts --step 1");

    let torque = Table::of(&terminal, "torque.csv");
    for part in ["inertia1", "coriolis2"] {
        assert!(torque.column(part).iter().all(|part| *part == 0.0));
    }
    assert!(torque.column("gravity1").iter().any(|part| part.abs() > 1.0));
}

#[test]
fn rows_are_labelled_as_they_truly_move() {
    let terminal = Terminal::new();
    let simulate = "simulate puma560-3 -o log.csv --seconds 120 --rate 50 --case 2";
    terminal.done(&format!("{simulate} --truth truth.csv"));

    let found = terminal.json("patterns log.csv -o found.csv");

    let (truth, labels) = (terminal.read("truth.csv"), terminal.read("found.csv"));
    assert!(labels.starts_with("row,pattern\n1,"), "rows are counted from 1");
    let right = truth.lines().zip(labels.lines()).filter(|(a, b)| a == b).count();
    assert_eq!((truth.lines().count(), labels.lines().count()), (6001, 6001));
    assert!(right > 5880, "{right} of 6001 lines agree");
    assert_eq!(each(&found["patterns"], "rows").iter().sum::<f64>().to_bits(), 6000_f64.to_bits());
}

#[test]
fn a_recorded_arm_comes_from_a_file() {
    let joint = "a = 0.5\nalpha = 0.0\nd = 0.0\nmass = 2.0\ncom = [-0.2, 0.0, 0.0]\n\
                 inertia = [0.01, 0.02, 0.03, 0.0, 0.0, 0.0]\n";
    let table = format!("name = 'one'\n[[joints]]\nname = 'pivot'\n{joint}");
    let terminal = Terminal::holding("one.toml", &table);

    let log = terminal.json("simulate one.toml -o log.parquet --seconds 2 --rate 100");

    assert_eq!(log["joints"], serde_json::json!(["pivot"]));
    assert_eq!(terminal.json("inspect log.parquet")["rows"], 200);
}

#[test]
fn the_demo_leaves_log_models_figure_and_report() {
    let terminal = Terminal::new();

    let said = terminal.run("demo --arm planar-2 -o out --seconds 60 --rate 50");

    let words = ["standstill", "Equations found", "one-shot SINDy", "report: out/report.html"];
    assert_tells(&said, &words);
    let svg = terminal.read("out/torque.svg");
    assert!(svg.starts_with("<svg") && svg.contains("energy library"));
    assert!(terminal.read("out/report.html").contains("<h2>Verdict"));
    for model in ["energy", "product", "sindy"] {
        terminal.json(&format!("evaluate out/{model}.json out/log.csv"));
    }
}
