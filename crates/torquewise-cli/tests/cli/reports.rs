//! Reports, figures and experiments: what is written, and that it tells what was found.

use crate::spoilt::Table;
use crate::terminal::{Terminal, assert_says, each, numbers, texts};
use serde_json::Value;

#[test]
fn a_report_stands_beside_the_model_and_names_its_terms() {
    let terminal = Terminal::with_log();

    let fit = terminal.json("fit log.csv -o model.json --report report.html");

    assert_eq!(fit["report"], "report.html");
    // What the report says of controllers is what the exported code computes.
    let costs = fit["costs"]["torque"].as_array().unwrap();
    let exported = terminal.json("export model.json --to c -o arm.c");
    let whole = costs.last().unwrap();
    assert_eq!(whole["operations"], exported["costs"]["torque"]["operations"]);
    assert_eq!(whole["functions"], exported["costs"]["torque"]["functions"]);
    assert_eq!(fit["costs"], terminal.json("show model.json --cost")["costs"]);
    assert_eq!((costs.len(), &whole["after"]), (4, &"refit".into()));
    let report = terminal.read("report.html");
    assert!(report.starts_with("<!doctype html>"), "{}", &report[..60]);
    let foot = "-o model.json --report report.html";
    let version = concat!("torquewise ", env!("CARGO_PKG_VERSION"), ". Report: 20");
    assert_says(&report, &["Torque model from log.csv", "standstill", "<math", "physical checks"]);
    assert_says(&report, &[foot, version]);
    assert!(!report.contains("src=\"http") && !report.contains("href=\"http"), "no network");
}

#[test]
fn a_model_can_be_judged_by_another_log_at_once() {
    let terminal = Terminal::with_log();
    terminal.done("simulate planar-2 -o test.csv --motion sines --seconds 10 --rate 50 --seed 8");

    let fit = terminal.json("fit log.csv -o model.json --test test.csv --report report.html");

    let evaluated = terminal.json("evaluate model.json test.csv");
    assert_eq!(fit["test"]["joints"], evaluated["joints"]);
    for key in ["verdict", "because"] {
        assert_eq!([&fit[key], &fit["test"][key]], [&evaluated[key]; 2]);
    }
    let report = terminal.read("report.html");
    assert!(report.contains("tested on test.csv") && report.contains("On the fitted log"));

    let other = Table::of(&terminal, "test.csv").scaled(&["tau2"], 1.6).text();
    terminal.write("test.csv", &other);
    let said = terminal.done("fit log.csv -o model.json --test test.csv --report report.html");
    let words = [
        "verdict: usable: test torque of joint2 is missed by more than 30 % of its spread",
        "test error 0.00 to 41.25 % of the spread",
    ];
    assert_says(&said, &words);
    assert_says(&terminal.done("evaluate model.json test.csv"), &words);
    // What a test says of a model goes wherever the model does.
    let other = Table::of(&terminal, "test.csv").scaled(&["tau2"], -1.0).text();
    terminal.write("turned.csv", &other);
    terminal.run("fit log.csv -o turned.json --test turned.csv --report turned.html");
    let exported = terminal.run("export turned.json --to c -o turned.c").stderr;
    assert!(exported.contains("do not let this code move an arm"), "{exported}");
    let report = terminal.read("turned.html");
    assert!(report.contains("Fit again before a model") && !report.contains("--to c"));
    let said = terminal.done("fit log.csv -o model.json --test test.csv --test log.csv");
    assert!(said.contains("On the test logs, 2 together:"), "{said}");
    assert!(terminal.read("report.html").contains("<strong>Usable</strong>"));
    let still = Table::of(&terminal, "test.csv").scaled(&["tau1", "tau2"], 0.0).text();
    terminal.write("test.csv", &still);
    let said = terminal.run("fit log.csv -o model.json --test test.csv").stdout;
    assert!(said.contains("held-out error") && !said.contains("test error"), "{said}");
}

#[test]
fn one_output_does_not_replace_another() {
    let terminal = Terminal::with_log();
    terminal.done("simulate puma560-3 -o other.csv --seconds 5 --rate 50");

    for report in ["m.html", "./m.html"] {
        terminal.refused(&format!("fit log.csv -o m.html --report {report}"), &["written twice"]);
    }
    terminal.refused("simulate planar-2 -o a.csv --truth ./a.csv", &["written twice"]);
    terminal.refused("fit log.csv -o m.json --report r.pdf", &["expected .html"]);
    terminal.refused("orders log.csv -o o.png", &["expected .svg"]);
    terminal.refused("fit log.csv -o m.json --test other.csv", &["another arm", "joint3"]);
    terminal.refused("reproduce --quick -o log.csv", &["log.csv is a file", "name a folder"]);
}

#[test]
fn orders_grow_until_nothing_is_left() {
    let terminal = Terminal::with_log();

    let found = terminal.json("orders log.csv -o orders.svg --whole-order 2 --trig-order 3");

    let expected = ["SINDy", "standstill", "uniform velocity", "variable velocity", "energy"];
    assert_eq!(texts(&found["libraries"], "name"), expected);
    for library in found["libraries"].as_array().unwrap() {
        let best = &library["chosen"];
        assert!(library["points"].as_array().unwrap().contains(best), "{library}");
        let residuals = numbers(&best["residual_percent"]);
        // The arm is held exactly by every library of these orders but the whole one, at most 2.
        let limit = if library["name"] == "SINDy" { 20.0 } else { 1e-2 };
        assert!(residuals.into_iter().all(|residual| residual < limit), "{library}");
    }
    assert!(terminal.read("orders.svg").starts_with("<svg"));
    let text = terminal.done("orders log.csv --whole-order 2 --trig-order 2 --interaction 2");
    assert!(text.contains("<- chosen") && text.contains("variable velocity"), "{text}");
}

#[test]
fn every_term_shows_how_often_resampled_logs_keep_it() {
    let terminal = Terminal::new();
    terminal.done("simulate planar-2 -o log.csv --seconds 60 --rate 50 --seed 3 --case 3");
    let fit = terminal.run("fit log.csv -o model.json");
    assert!(matches!(fit.code, 0 | 3), "{fit:?}");

    let (text, shown) = (terminal.done("show model.json"), terminal.json("show model.json"));

    let shares = each(&shown["energies"], "inclusion");
    assert!(shares.iter().all(|share| (0.0..=1.0).contains(share)), "{shares:?}");
    let shown = text.lines().filter(|line| line.ends_with(" %)")).count();
    let left_out = text.lines().find(|line| line.ends_with("ask for `all` to see them"));
    assert!(shown >= 5 && left_out.is_some(), "{text}");
}

#[test]
fn the_experiments_leave_report_results_and_figures() {
    let terminal = Terminal::new();

    let found = terminal.json("reproduce -o out --quick --seeds 1 --seed 2");

    let results: Value = serde_json::from_str(&terminal.read("out/results.json")).unwrap();
    assert!(results["studies"].is_array() && found["claims"].as_array().unwrap().len() == 10);
    let report = terminal.read("out/report.html");
    for claim in found["claims"].as_array().unwrap() {
        assert_says(&report, &[claim["claim"].as_str().unwrap()]);
    }
    let figures = found["figures"].as_array().unwrap();
    assert!(figures.len() > 8, "{figures:?}");
    for figure in figures {
        assert!(terminal.read(figure.as_str().unwrap()).starts_with("<svg"), "{figure}");
    }
}
