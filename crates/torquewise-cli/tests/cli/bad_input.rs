//! Input that is wrong: told what, where and what to do, and no file is left behind.

use crate::terminal::Terminal;

#[test]
fn a_log_that_is_wrong_is_refused_by_every_command_that_reads_torque() {
    let terminal = Terminal::with_model();
    let log = terminal.read("log.csv");
    let header = log.lines().next().unwrap().to_owned();
    // One cell replaced; row 0 is the header.
    let with = |row: usize, column: usize, cell| -> String {
        let mut rows: Vec<Vec<&str>> = log.lines().map(|line| line.split(',').collect()).collect();
        rows[row][column] = cell;
        rows.iter().map(|row| row.join(",") + "\n").collect()
    };
    for (text, words) in [
        (String::new(), &["bad.csv is empty", "a log begins with a header"][..]),
        (header, &["bad.csv has a header but no rows", "record"]),
        (
            with(7, 2, "0.1,0.2"),
            &["bad.csv, row 7 (line 8)", "10 fields", "header has 9", "complete or drop"],
        ),
        (with(2000, 4, "-Infinity"), &["row 2000", "column dq2", "repair or drop", "-inf"]),
        (with(5, 8, "stop"), &["row 5", "column tau2", "\"stop\" is not a number"]),
        (with(100, 0, "0.5"), &["row 100", "t = 0.5 s does not follow", "sort the rows"]),
        (with(0, 8, "tau3"), &["bad.csv has column tau3 but no q3"]),
        (with(0, 8, "current"), &["bad.csv has column q2 but no tau2", "add tau2"]),
    ] {
        terminal.write("bad.csv", &text);
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
}

#[test]
fn logs_without_torque_unsorted_or_of_five_rows_cannot_be_fitted_or_judged() {
    let terminal = Terminal::with_model();
    let log = terminal.read("log.csv");
    let bare = log.replace("tau1", "current1").replace("tau2", "current2");
    terminal.write("bare.csv", &bare);
    let few: Vec<&str> = log.lines().take(6).collect();
    terminal.write("few.csv", &few.join("\n"));

    for line in [
        "fit bare.csv -o out.json",
        "evaluate model.json bare.csv",
        "compare bare.csv --test log.csv",
        "compare log.csv --test bare.csv",
    ] {
        terminal.refused(line, &["bare.csv has no torque", "record columns tau1"]);
    }
    assert!(terminal.run("inspect bare.csv").stdout.contains("[tau]\ncolumns = \"current\""));
    let mut back: Vec<&str> = log.lines().collect();
    back[1..].reverse();
    terminal.write("back.csv", &back.join("\n"));
    let told = ["earlier than a row before: ", "(sort the rows by time)", "rows are too few"];
    terminal.refused("fit back.csv --repair --filter 5 -o out.json", &told);
    terminal.refused("fit few.csv -o out.json", &["5 rows", "at least 50", "longer"]);
    assert_eq!(terminal.json("inspect few.csv")["rows"], 5, "but they can be looked at");
}

#[test]
fn models_that_cannot_be_used_are_refused() {
    let terminal = Terminal::with_model();
    let model = terminal.read("model.json");
    terminal.write("half.json", &model[..model.len() / 2]);
    terminal.write("newer.json", &model.replacen("\"version\": 1", "\"version\": 99", 1));
    terminal.done("simulate puma560-3 -o three.csv --seconds 2 --rate 50");
    terminal.write("named.csv", &format!("# joints: hip,knee\n{}", terminal.read("log.csv")));
    terminal.run("fit log.csv -o one.json --method sindy --trig-order 1");

    let half = ["half.json", "cut off", "fit the model anew"];
    let newer = ["version 99", "reads version 1", "fit the model anew"];
    for (line, words) in [
        ("show half.json", &half[..]),
        ("evaluate half.json log.csv", &half),
        ("predict half.json log.csv -o out.csv", &half),
        ("show newer.json", &newer),
        ("evaluate model.json three.csv", &["model has 2 joints", "the log 3"]),
        ("predict model.json three.csv -o out.csv", &["model has 2 joints", "the log 3"]),
        ("evaluate model.json named.csv", &["joint1, joint2", "hip, knee"]),
        ("predict model.json named.csv -o out.csv", &["joint1, joint2", "hip, knee"]),
        ("predict one.json log.csv -o out.csv --step 2", &["no step 2: it has 1"]),
    ] {
        terminal.refused(line, words);
    }
}

#[test]
fn a_missing_file_is_named_with_its_cause_and_the_advice_last_and_one_of_another_format() {
    let terminal = Terminal::with_log();
    terminal.write("data.pickle", "\u{80}");
    terminal.write("a.parquet", "PAR1\0\0\0\0PAR1");

    let unknown = ["no log format known here", ".npz", "convert"];
    terminal.refused("inspect data.pickle", &unknown);
    // No run may print that anything panicked.
    terminal.refused("inspect a.parquet", &["a.parquet"]);
    terminal.refused("inspect gone.csv", &["gone.csv cannot be read", "because: ", "check"]);
    let said = terminal.run("simulate gone.toml -o new.csv");

    let last = said.stderr.lines().last().unwrap();
    assert_eq!(last, "help: check that it exists and may be read");
}

#[test]
fn outputs_that_cannot_be_and_arms_that_are_none_are_refused_before_any_work() {
    let terminal = Terminal::with_model();
    std::fs::create_dir(terminal.path("folder")).unwrap();

    terminal.refused("fit log.csv -o no/such/model.json", &["no folder no/such", "create it"]);
    terminal.refused("fit log.csv -o folder", &["folder is a folder", "name a file"]);
    terminal.refused("predict model.json log.csv -o log.csv", &["log.csv is read by this"]);
    terminal.refused("patterns log.csv -o log.csv", &["log.csv is read by this"]);
    terminal.refused("predict model.json log.csv -o out.txt", &["out.txt", ".csv or .parquet"]);
    terminal.refused("simulate planar-2 -o gone/log.csv", &["no folder gone"]);
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
