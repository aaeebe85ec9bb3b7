//! Keys that programs rely on.

use crate::spoilt::Table;
use crate::terminal::{Terminal, each, numbers, texts};
use serde_json::Value;

#[test]
fn simulate_lists_arms_and_says_what_it_wrote() {
    let terminal = Terminal::new();

    let arms = terminal.json("simulate --list");
    let log = terminal.json("simulate planar-2 -o log.csv --seconds 4 --rate 50 --motion sines");

    assert!(texts(&arms["arms"], "name").contains(&"puma560-3".to_owned()));
    assert_eq!(arms["arms"][0]["joints"], 2);
    assert_eq!((&log["rows"], &log["file"]), (&200.into(), &"log.csv".into()));
    assert_eq!(log["patterns"][2]["rows"], 200, "sines never rest");
}

#[test]
fn inspect_says_what_a_log_holds_and_lacks() {
    let terminal = Terminal::with_log();
    let bare = Table::of(&terminal, "log.csv").without(&["dq1", "dq2", "ddq1", "ddq2", "tau1"]);
    terminal.write("bare.csv", &bare.renamed(&[("tau2", "celsius")]).text());

    let (whole, bare) = (terminal.json("inspect log.csv"), terminal.json("inspect bare.csv"));

    assert_eq!((&whole["rows"], &whole["gaps"]), (&3000.into(), &0.into()));
    assert!((whole["rate_hz"].as_f64().unwrap() - 50.0).abs() < 1e-6);
    assert_eq!(whole["missing"], serde_json::json!([]));
    assert!(whole["joints"][1]["tau_std"].as_f64().unwrap() > 0.0);
    assert_eq!(bare["missing"], serde_json::json!(["dq", "ddq", "tau"]));
    assert_eq!(bare["ignored_columns"], serde_json::json!(["celsius"]));
    assert_eq!(bare["joints"][1]["tau_std"], Value::Null);
}

#[test]
fn patterns_are_always_three_in_the_same_order() {
    let terminal = Terminal::with_log();
    terminal.done("simulate planar-2 -o sines.csv --seconds 20 --rate 50 --motion sines");

    let names = ["standstill", "uniform velocity", "variable velocity"];
    let (all, sines) = (terminal.json("patterns log.csv"), terminal.json("patterns sines.csv"));

    assert_eq!(all["clusters"], 3);
    assert!(numbers(&all["inertia"]).len() >= 3);
    for found in [&all, &sines] {
        assert_eq!(texts(&found["patterns"], "name"), names);
    }
    assert_eq!(sines["patterns"][0]["rows"], 0);
    assert_eq!(terminal.run("patterns sines.csv --strict").code, 3, "patterns are missing");
}

#[test]
fn fit_counts_candidates_and_active_terms() {
    let terminal = Terminal::with_log();

    let fit = terminal.json("fit log.csv -o model.json --library product");

    let names = ["standstill", "uniform velocity", "variable velocity"];
    assert_eq!(texts(&fit["steps"], "name"), names);
    let sum = |values: &Value| numbers(values).iter().sum::<f64>();
    assert_eq!(each(&fit["steps"], "candidates"), numbers(&fit["candidates_by_step"]));
    assert_eq!(Some(sum(&fit["candidates_by_step"])), fit["candidates"].as_f64());
    for step in fit["steps"].as_array().unwrap() {
        assert_eq!(step["active"].as_array().unwrap().len(), 2);
        assert!(step["seconds"].as_f64().unwrap() > 0.0 && step["rows"].as_u64().unwrap() > 0);
    }
    assert_eq!(Some(sum(&fit["active"])), fit["active_total"].as_f64());
    assert!(fit["seconds"].as_f64().unwrap() > 0.0);
    assert_eq!((&fit["file"], &fit["warnings"]), (&"model.json".into(), &serde_json::json!([])));
    assert!(fit["noise"]["ddq"].is_array());
    let sindy = terminal.json("fit log.csv -o model.json --method sindy --trig-order 2");
    // 13 functions of two angles up to order 2, 15 of the motion up to degree 2.
    assert_eq!((each(&sindy["steps"], "rows").len(), &sindy["candidates"]), (1, &(13 * 15).into()));
}

#[test]
fn show_lists_terms_with_kind_and_uncertainty() {
    let terminal = Terminal::with_model();

    let shown = terminal.json("show model.json --check");
    let printed: Value =
        serde_json::from_str(&terminal.done("show model.json --format json")).unwrap();

    let terms = shown["joints"][0]["terms"].as_array().unwrap();
    assert!(terms.iter().all(|term| term["std_error"].is_number() && term["term"].is_string()));
    for kind in ["gravity", "coriolis", "inertia"] {
        assert!(terms.iter().any(|term| term["kind"] == kind), "{kind}");
    }
    assert_eq!(shown["checks"]["passed"], true);
    assert_eq!(printed["joints"], shown["joints"]);
}

#[test]
fn predict_names_its_columns() {
    let terminal = Terminal::with_model();

    let torque = terminal.json("predict model.json log.csv -o torque.csv --parts");

    let columns: Vec<String> = serde_json::from_value(torque["columns"].clone()).unwrap();
    assert_eq!(columns[..5], ["t", "tau_hat1", "tau_hat2", "inertia1", "inertia2"]);
    assert!(terminal.read("torque.csv").starts_with(&columns.join(",")));
    assert_eq!(torque["rows"], 3000);
}

#[test]
fn compare_sets_both_methods_beside_each_other() {
    let terminal = Terminal::with_log();
    terminal.done("simulate planar-2 -o test.csv --seconds 20 --rate 50 --motion sines");

    let both = terminal.json("compare log.csv --test test.csv --trig-order 2");

    for method in ["stepwise", "sindy"] {
        let found = &both[method];
        assert_eq!(numbers(&found["nrmse_percent"]).len(), 2, "{method}");
        assert_eq!(numbers(&found["active"]).len(), 2, "{method}");
        assert!(found["seconds"].as_f64().unwrap() > 0.0, "{method}");
    }
    let candidates = |method: &str| both[method]["candidates"].as_u64().unwrap();
    assert!(candidates("stepwise") < candidates("sindy"));
}

#[test]
fn a_demo_speaks_json_too() {
    let terminal = Terminal::new();

    let demo = terminal.json("demo --arm planar-2 -o out --seconds 60 --rate 50 --case 1");

    assert_eq!(demo["methods"].as_array().unwrap().len(), 3);
    assert_eq!(texts(&demo["patterns"], "name").len(), 3);
}

#[test]
fn a_failure_is_an_object_with_the_error() {
    let terminal = Terminal::new();

    let said = terminal.run("inspect gone.csv --json");

    assert_eq!(said.code, 1);
    let object: Value = serde_json::from_str(&said.stdout).unwrap();
    assert!(object["error"].as_str().unwrap().contains("gone.csv"));
    assert!(said.stderr.starts_with("error: "));
}
