//! Small logs, of which the library and the command line make one model.

use crate::terminal::Terminal;
use serde_json::Value;
use std::fs;
use std::path::Path;
use torquewise::{Fit, FitOptions, Log, Model};

#[test]
fn each_log_of_the_conformance_set_gives_one_model() {
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
    }
}
