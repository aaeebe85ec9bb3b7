//! What the page asks, answered as the library answers it.

use serde_json::{Value, json};
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Arc;
use torquewise::logs::LogInput;
use torquewise::{Fit, Log, NOBODY};
use torquewise_web::answer::{Answer, answer};
use torquewise_web::request::FileAt;

const CONFORMANCE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/conformance/");

/// The answer to a request about one file.
fn asked(request: &Value, content: &[u8]) -> Answer {
    let held = |file: &FileAt| LogInput::held(&file.name, Arc::new(content.to_vec()));
    answer(&request.to_string(), &held, NOBODY)
}

fn log(name: &str, content: &[u8]) -> Value {
    json!({ "files": [{ "name": name, "at": 0, "size": content.len() }] })
}

fn example(name: &str) -> Vec<u8> {
    asked(&json!({ "ask": "example", "name": name }), &[]).content
}

fn opened(name: &str, content: &[u8], profile: Value) -> Value {
    let mut request = log(name, content);
    request["ask"] = "open".into();
    request["profile"] = profile;
    asked(&request, content).json
}

#[test]
fn examples_are_read_and_the_raw_one_once_its_columns_are_named() {
    let profile = json!({
        "t": { "column": "tick_ms", "unit": "ms" },
        "q": { "columns": ["encoder_A", "encoder_B"], "unit": "deg" },
        "tau": { "columns": ["drive_A", "drive_B"], "unit": "A", "torque_constant": 2.5 },
    });
    for own in ["two-joints", "two-joints-other-motion", "raw-columns", "gantry"] {
        let (name, content) = (format!("{own}.csv"), example(own));

        let found = opened(&name, &content, Value::Null);

        assert!(found["columns"].as_array().unwrap().len() >= 5, "{name}");
        if own == "raw-columns" {
            assert_eq!(found["refused"]["is_unnamed"], true);
            let named = opened(&name, &content, profile.clone());
            let seconds = named["log"]["found"]["seconds"].as_f64().unwrap();
            assert!((59.0..60.0).contains(&seconds), "{seconds}");
            assert_eq!(named["log"]["is_filtered"], true);
        } else {
            assert_eq!(found["log"]["found"]["missing"], json!([]), "{name}");
        }
    }
}

#[test]
fn a_fit_is_that_of_the_library_and_its_model_predicts_and_is_exported() {
    let file = Path::new(CONFORMANCE).join("smooth.csv");
    let content = std::fs::read(&file).unwrap();
    let own = log("smooth.csv", &content);
    let request = json!({ "ask": "fit", "log": own, "options": { "seed": 3 }, "date": "today" });

    let found = asked(&request, &content).json;

    let options = torquewise::FitOptions { seed: 3, ..torquewise::FitOptions::default() };
    let fit = Fit::new(&Log::open(&file).unwrap()).options(options).run().unwrap();
    let model = torquewise::model::to_json(&fit.model).unwrap().replace("\"smooth\"", "");
    assert_eq!(found["model"].as_str().unwrap().replace("\"smooth\"", ""), model);
    assert_eq!(found["summary"]["verdict"], fit.verdict().grade.to_string());
    let model = &found["model"];
    let scores = asked(&json!({ "ask": "evaluate", "model": model, "log": own }), &content).json;
    assert!(scores["scores"]["joints"][0]["r2"].as_f64().unwrap() > 0.999, "{scores}");
    for (to, begins) in [("c", "/*"), ("fmu", "PK"), ("json", "{")] {
        let request =
            json!({ "ask": "export", "model": model, "to": to, "name": "1 arm", "force": false });
        let made = asked(&request, &[]);
        assert!(made.content.starts_with(begins.as_bytes()), "{to}: {}", made.json);
        assert_eq!(made.json["name"].as_str().unwrap().split('.').next(), Some("arm1_arm"));
    }
}

#[test]
fn what_is_wrong_is_told_with_what_to_do() {
    let told = |request: Value, content: &[u8]| -> [String; 2] {
        let problem = asked(&request, content).json["problem"].take();
        ["message", "help"].map(|key| problem[key].as_str().unwrap_or_default().to_owned())
    };
    let csv = b"t,q1,tau1\n0,1,2\n0.1,x,2\n";
    let mut request = json!({ "ask": "fit", "options": {}, "date": "", "log": log("a.csv", csv) });

    let [message, help] = told(request.clone(), csv);
    assert!(message.contains("a.csv") && message.contains("q1") && !help.is_empty(), "{message}");
    request["options"] = json!({ "library": "chain", "threshold": 0.1 });
    assert!(told(request, csv)[0].starts_with("threshold is not used by a learned chain"));
    let bag = opened("a.db3", b"SQLite format 3\0", Value::Null);
    assert!(bag["problem"]["help"].as_str().unwrap().contains("ros2 bag convert"), "{bag}");
    assert_eq!(told(json!({ "ask": "nothing" }), &[])[1], "reload the page");
}

#[test]
fn who_watches_a_fit_is_told_its_stages_and_can_stop_it() {
    let content = std::fs::read(Path::new(CONFORMANCE).join("rough.csv")).unwrap();
    let held = |file: &FileAt| LogInput::held(&file.name, Arc::new(content.clone()));
    let fit = json!({ "ask": "fit", "options": {}, "date": "", "log": log("a.csv", &content) });

    let stopped = answer(&fit.to_string(), &held, &|_| ControlFlow::Break(()));

    assert!(stopped.json["problem"]["message"].as_str().unwrap().starts_with("interrupted"));
}
