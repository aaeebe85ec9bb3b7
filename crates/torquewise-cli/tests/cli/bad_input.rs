//! Input that is wrong: told what, where and what to do, and no file is left behind.

use crate::terminal::Terminal;

/// `log.csv` of a [`Terminal::with_log`], one cell replaced; row 0 is the header.
fn with_cell(terminal: &Terminal, row: usize, column: usize, cell: &str) -> String {
    let log = terminal.read("log.csv");
    let mut rows: Vec<Vec<&str>> = log.lines().map(|line| line.split(',').collect()).collect();
    rows[row][column] = cell;
    rows.iter().map(|row| row.join(",") + "\n").collect()
}

/// Refuses `bad.csv` in every command that reads logs with torque.
fn refuse_everywhere(terminal: &Terminal, words: &[&str]) {
    for line in [
        "inspect bad.csv",
        "patterns bad.csv -o out.csv",
        "fit bad.csv -o out.json",
        "evaluate model.json bad.csv",
        "predict model.json bad.csv -o out.csv",
        "compare bad.csv --test log.csv",
    ] {
        terminal.refused(line, words);
    }
}

#[test]
fn an_empty_file_is_refused() {
    let terminal = Terminal::with_model();
    terminal.write("bad.csv", "");

    refuse_everywhere(&terminal, &["bad.csv is empty", "a log begins with a header"]);
}

#[test]
fn a_header_without_rows_is_refused() {
    let terminal = Terminal::with_model();
    let log = terminal.read("log.csv");
    terminal.write("bad.csv", log.lines().next().unwrap());

    refuse_everywhere(&terminal, &["bad.csv has a header but no rows", "record"]);
}

#[test]
fn a_ragged_row_is_refused() {
    let terminal = Terminal::with_model();
    terminal.write("bad.csv", &with_cell(&terminal, 7, 2, "0.1,0.2"));

    let words = ["bad.csv, row 7 (line 8)", "10 fields", "header has 9", "complete or drop"];
    refuse_everywhere(&terminal, &words);
}

#[test]
fn a_value_that_is_not_finite_is_refused() {
    let terminal = Terminal::with_model();
    for (cell, shown) in [("NaN", "NaN"), ("inf", "inf"), ("-Infinity", "-inf")] {
        terminal.write("bad.csv", &with_cell(&terminal, 2000, 4, cell));

        refuse_everywhere(&terminal, &["row 2000", "column dq2", shown, "repair or drop"]);
    }
}

#[test]
fn a_word_among_the_numbers_is_refused() {
    let terminal = Terminal::with_model();
    terminal.write("bad.csv", &with_cell(&terminal, 5, 8, "stop"));

    refuse_everywhere(&terminal, &["row 5", "column tau2", "\"stop\" is not a number"]);
}

#[test]
fn time_that_runs_backward_is_refused() {
    let terminal = Terminal::with_model();
    terminal.write("bad.csv", &with_cell(&terminal, 100, 0, "0.5"));

    refuse_everywhere(&terminal, &["row 100", "t = 0.5 s does not follow", "sort the rows"]);
}

#[test]
fn joints_of_q_and_tau_must_agree() {
    let terminal = Terminal::with_model();
    terminal.write("bad.csv", &with_cell(&terminal, 0, 8, "tau3"));
    refuse_everywhere(&terminal, &["bad.csv has column tau3 but no q3"]);

    terminal.write("bad.csv", &with_cell(&terminal, 0, 8, "current"));
    refuse_everywhere(&terminal, &["bad.csv has column q2 but no tau2", "add tau2"]);
}

#[test]
fn a_log_without_torque_cannot_be_fitted_or_judged() {
    let terminal = Terminal::with_model();
    let log = terminal.read("log.csv").replace("tau1", "current1").replace("tau2", "current2");
    terminal.write("bare.csv", &log);

    for line in [
        "fit bare.csv -o out.json",
        "evaluate model.json bare.csv",
        "compare bare.csv --test log.csv",
        "compare log.csv --test bare.csv",
    ] {
        terminal.refused(line, &["bare.csv has no torque", "record columns tau1"]);
    }
}

#[test]
fn five_rows_are_too_few() {
    let terminal = Terminal::with_log();
    let log = terminal.read("log.csv");
    let few: Vec<&str> = log.lines().take(6).collect();
    terminal.write("few.csv", &few.join("\n"));

    terminal.refused("fit few.csv -o out.json", &["5 rows", "at least 50", "longer"]);
    assert_eq!(terminal.json("inspect few.csv")["rows"], 5, "but they can be looked at");
}

#[test]
fn a_joint_that_never_moves_is_named_in_a_warning() {
    let terminal = Terminal::with_log();
    let log = terminal.read("log.csv");
    let still = log.lines().skip(1).map(|line| {
        let x: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
        let (t, q, dq, ddq) = (x[0], x[1], x[3], x[5]);
        let tau = [2.0 * ddq + 9.81 * q.cos(), 0.5 * ddq + 3.0 * (q + 0.3).cos()];
        format!("{t},{q},0.3,{dq},0,{ddq},0,{},{}", tau[0], tau[1])
    });
    let lines: Vec<String> = log.lines().take(1).map(str::to_owned).chain(still).collect();
    terminal.write("still.csv", &lines.join("\n"));

    let said = terminal.run("fit still.csv -o model.json --strict");

    assert_eq!(said.code, 3, "{said:?}");
    assert!(said.stderr.contains("warning: joint2 never moves"), "{said:?}");
    assert!(terminal.path("model.json").exists());
}

#[test]
fn half_a_model_is_refused() {
    let terminal = Terminal::with_model();
    let model = terminal.read("model.json");
    terminal.write("half.json", &model[..model.len() / 2]);

    for line in
        ["show half.json", "evaluate half.json log.csv", "predict half.json log.csv -o out.csv"]
    {
        terminal.refused(line, &["half.json", "cut off", "fit the model anew"]);
    }
}

#[test]
fn a_model_of_a_newer_version_is_refused() {
    let terminal = Terminal::with_model();
    let model = terminal.read("model.json").replacen("\"version\": 1", "\"version\": 99", 1);
    terminal.write("newer.json", &model);

    terminal.refused("show newer.json", &["version 99", "reads version 1", "fit the model anew"]);
}

#[test]
fn a_model_of_another_arm_is_refused() {
    let terminal = Terminal::with_model();
    terminal.done("simulate puma560-3 -o three.csv --seconds 2 --rate 50");
    terminal.write("named.csv", &format!("# joints: hip,knee\n{}", terminal.read("log.csv")));

    for (log, words) in [
        ("three.csv", ["model has 2 joints", "the log 3"]),
        ("named.csv", ["joint1, joint2", "hip, knee"]),
    ] {
        terminal.refused(&format!("evaluate model.json {log}"), &words);
        terminal.refused(&format!("predict model.json {log} -o out.csv"), &words);
    }
}

#[test]
fn a_step_that_was_not_taken_is_refused() {
    let terminal = Terminal::with_log();
    terminal.run("fit log.csv -o model.json --method sindy --trig-order 1");

    terminal.refused("predict model.json log.csv -o out.csv --step 2", &["steps 1 to 1", "step 2"]);
}

#[test]
fn a_missing_file_is_named_with_its_cause_and_the_advice_last() {
    let terminal = Terminal::with_log();

    terminal.refused("inspect gone.csv", &["gone.csv cannot be read", "because: ", "check"]);
    let said = terminal.run("simulate gone.toml -o new.csv");

    let last = said.stderr.lines().last().unwrap();
    assert_eq!(last, "help: check that it exists and may be read");
}

#[test]
fn an_output_is_refused_before_any_work() {
    let terminal = Terminal::with_model();
    std::fs::create_dir(terminal.path("folder")).unwrap();

    terminal.refused("fit log.csv -o no/such/model.json", &["no folder no/such", "create it"]);
    terminal.refused("fit log.csv -o folder", &["folder is a folder", "name a file"]);
    terminal.refused("predict model.json log.csv -o log.csv", &["log.csv is read by this"]);
    terminal.refused("patterns log.csv -o log.csv", &["log.csv is read by this"]);
    terminal.refused("predict model.json log.csv -o out.txt", &["\"txt\" is no log format"]);
    terminal.refused("simulate planar-2 -o gone/log.csv", &["no folder gone"]);
}

#[test]
fn an_arm_that_is_none_is_refused() {
    let terminal = Terminal::new();
    terminal.write("bad.toml", "name = 3");
    terminal.write("bad.urdf", "<robot name='x'/>");

    terminal.refused("simulate puma -o log.csv", &["no arm is called `puma`", "puma560-3"]);
    terminal.refused("simulate bad.toml -o log.csv", &["no arm in bad.toml", "DH table"]);
    terminal.refused("simulate bad.urdf -o log.csv", &["no arm in bad.urdf"]);
    terminal.refused(
        "simulate planar-2 -o log.csv --seconds=-1",
        &["length [s]", "is -1.0, expected more than 0"],
    );
}
