//! Small logs and the model that each must give, to the library and to the command line.

use crate::terminal::Terminal;
use serde_json::Value;
use std::fs;
use std::path::Path;
use torquewise::{Fit, FitOptions, Log, Model, Torque};

#[test]
fn each_log_of_the_conformance_set_gives_its_arm() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/conformance");
    for name in ["energy", "product", "one_shot", "chain"] {
        let text = fs::read_to_string(folder.join(format!("{name}.json"))).unwrap();
        let case: Value = serde_json::from_str(&text).unwrap();
        let file = folder.join(case["log"].as_str().unwrap());
        let options = case["fit"].as_object().unwrap();

        let keywords = FitOptions::of_keywords(options).unwrap();
        let fit = Fit::new(&Log::open(&file).unwrap()).options(keywords).run().unwrap();
        let flags = options.iter().map(|(option, value)| {
            let flag = option.trim_start_matches("n_").replace('_', "-");
            format!("--{flag} {}", value.to_string().trim_matches('"'))
        });
        let flags = flags.collect::<Vec<_>>().join(" ");
        let line = format!("fit {} -o model.json {flags}", file.display());
        let terminal = Terminal::new();
        assert_eq!(terminal.run(&line).code, 0, "{line}");

        assert_eq!(Model::load(terminal.path("model.json")).unwrap(), fit.model, "{name}");
        // How many friction terms of a chain are worth keeping is no truth of the arm.
        if let Some(terms) = case.get("terms") {
            assert_eq!(*terms, fit.model.n_coefficients(), "{name}");
        }
        for (joint, percent) in errors(&fit.model, &case).into_iter().enumerate() {
            assert!(
                percent < case["within_percent"].as_f64().unwrap(),
                "{name} {joint}: {percent}"
            );
        }
    }
}

/// What is left of the true torque of each joint, of its RMS \[%\].
fn errors(model: &Model, case: &Value) -> Vec<f64> {
    let rows = |key: &str| serde_json::from_value::<Vec<Vec<f64>>>(case[key].clone()).unwrap();
    let ([q, dq, ddq, tau], torque) = (["q", "dq", "ddq", "tau"].map(rows), Torque::new(model));
    let found: Vec<Vec<f64>> =
        (0..tau.len()).map(|row| torque.at(&q[row], &dq[row], &ddq[row]).unwrap()).collect();
    let of = |joint: usize| {
        let square = |rest: &dyn Fn(usize) -> f64| (0..tau.len()).map(rest).sum::<f64>();
        let left = square(&|row| (found[row][joint] - tau[row][joint]).powi(2));
        100.0 * (left / square(&|row| tau[row][joint].powi(2))).sqrt()
    };
    (0..model.n_joints()).map(of).collect()
}
