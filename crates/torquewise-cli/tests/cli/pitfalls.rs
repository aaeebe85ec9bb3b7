//! Logs as they should not be, and as they are: each pitfall is told, or dealt with.
//!
//! One simulated arm, spoilt in turn as public logs of real arms are: docs/your-robot.md has the
//! list.

use crate::spoilt::{Table, assert_tells, assert_warns, noise};
use crate::terminal::Terminal;
use std::f64::consts::PI;

const TORQUE_WORDS: [&str; 5] =
    ["does not follow", "falls as it", "gravity compensation", "few levels", "measured velocity"];

#[test]
fn a_sound_log_is_not_suspected() {
    for table in [Table::arm(), Table::recorded()] {
        let said = table.inspected();

        for word in TORQUE_WORDS {
            assert!(!said.stderr.contains(word), "{word}: {}", said.stderr);
        }
        assert!(!said.stdout.contains("late: advanced"), "{}", said.stdout);
        assert!(!said.stdout.contains("conditioning"), "{said:?}");
        assert!(!said.stderr.contains("note:"), "{said:?}");
    }
}

#[test]
fn what_spoils_a_log_is_told() {
    let recorded = Table::recorded();
    let with =
        |name: &str, value: &dyn Fn(usize, f64, &[f64]) -> f64| recorded.clone().with(name, value);
    // Gravity alone, as of an arm that a hand leads.
    let hand = with("tau1", &|_, _, row| 24.0 * row[1].cos() + 4.0 * (row[1] + row[2]).cos())
        .with("tau2", |_, _, row| 4.0 * row[2].sin());
    let spikes = |row, tau, _: &[f64]| match row {
        400 | 900 | 1_500 => tau + 300.0,
        _ => tau,
    };
    let still = Table::arm().with("q2", |_, _, _| 0.0).scaled(&["dq2", "ddq2"], 0.0);
    let rpm = recorded.clone().scaled(&["dq1", "dq2"], 30.0 / PI);
    let fast = Table::arm().scaled(&["dq2"], 1.2);
    let off = &["the torque of joint2 does not follow its motion", "is its motor on"];
    let coarse = &["the torque of joint2 has few levels", "expect a poor fit"];
    let led = &["the torque of joint2 follows from the positions alone", "hand"];
    let mut sorted = recorded.column("tau1");
    sorted.sort_by(f64::total_cmp);
    let (low, high) = (sorted[sorted.len() / 10], sorted[sorted.len() * 9 / 10]);
    let cut = &["the torque of joint1 is at one of its ends in 20 % of its motion"];
    let wrapped = |_: usize, q: f64, _: &[f64]| if q > 0.0 { q - PI } else { q + PI };
    let cases: [(Table, &[&str], &[&str]); 10] = [
        (with("tau1", &|_, tau, _| tau.clamp(low, high)), cut, &[]),
        (with("q1", &wrapped), &[], &["jumps of a position by whole turns taken out"]),
        (with("t", &|row, t, _| t + 2e-3 * noise(row)), &[], &["made even: jitter"]),
        (with("tau1", &spikes), &[], &["tau of joint1: 3 outliers replaced"]),
        (rpm, &["measured velocity of joint1 and joint2 is 9.549 and 9.549 times"], &[]),
        (fast, &["measured velocity of joint2 is 1.200 times the slope"], &[]),
        (hand, led, &[]),
        (with("tau2", &|row, _, _| 0.02 * noise(row)), off, &[]),
        (
            with("tau2", &|_, tau, _| (tau / 1.5).round() * 1.5),
            coarse,
            &["tau of joint2 is quantised to 1.5"],
        ),
        (still, &["joint2 never moves"], &[]),
    ];
    for (table, warned, told) in cases {
        let said = table.inspected();

        assert_tells(&said, told);
        if !warned.is_empty() {
            assert_warns(&said, warned);
        }
    }
}

// Files.

#[test]
fn headers_and_rows_with_a_space_after_each_comma_are_read() {
    let terminal = Terminal::holding("log.csv", &Table::arm().text_by(", "));

    assert_eq!(terminal.json("inspect log.csv")["rows"], 2_000);
}

#[test]
fn the_suggested_profile_takes_what_was_measured() {
    let table = Table::recorded()
        .renamed(&[("t", "time"), ("tau1", "tau_meas1"), ("tau2", "tau_meas2")])
        .twice("tau_meas1", "tau_con1")
        .twice("tau_meas2", "tau_con2")
        .twice("tau_meas1", "tau_ff_all1")
        .twice("tau_meas2", "tau_ff_all2")
        .renamed(&[("q1", "pos_des1"), ("q2", "pos_des2")])
        .twice("pos_des1", "pos_meas1")
        .twice("pos_des2", "pos_meas2");

    let said = table.inspected();

    assert_tells(&said, &["columns = \"pos_meas\"", "columns = \"tau_meas\""]);
    assert_warns(&said, &["first rows of the columns were looked at"]);
    let terminal = Terminal::holding("log.csv", &table.text());
    let profile = terminal.run("inspect log.csv").stdout;
    assert_eq!(profile, said.stdout, "all prose is on standard error");
    terminal.write("p.toml", &profile);
    assert_eq!(terminal.run("inspect log.csv --profile p.toml").code, 0);
}

// Clocks.

#[test]
fn repeated_stamps_and_a_restarted_clock_are_left_out_and_told() {
    let mut table = Table::recorded();
    let again = table.rows[500].clone();
    table.rows.insert(501, again);
    let restarted = table.rows[..300].to_vec();
    table.rows.extend(restarted);
    let terminal = Terminal::holding("log.csv", &table.text());

    terminal.refused("inspect log.csv", &["row 2002", "does not follow"]);
    let said = terminal.run("inspect log.csv --repair --strict");

    assert_warns(
        &said,
        &[
            "note: left out: 1 row with the time stamp of the row before",
            "left out: 300 rows earlier than a row before, the first is row 2002 of log.csv",
            "put what follows in a file of its own",
        ],
    );
}

#[test]
fn what_was_repaired_in_a_log_is_a_note_and_stays_with_the_model() {
    // A spike, a repeated stamp, a pause that is bridged and one that is not.
    let mut table = Table::recorded().with("tau1", |row, tau, _| match row {
        400 => tau + 300.0,
        _ => tau,
    });
    let again = table.rows[500].clone();
    table.rows.splice(1_700..1_730, []);
    table.rows.splice(900..903, []);
    table.rows.insert(501, again);
    let terminal = Terminal::holding("log.csv", &table.text());
    terminal.write("sound.csv", &Table::recorded().text());
    let note = "left out: 1 row with the time stamp of the row before; repaired: 3 spikes \
                replaced (q 2, tau 1), 1 gap bridged (the longest 40.0 ms), 1 longer gap at \
                which a log was split";

    let fit = "fit sound.csv log.csv -o m.json --filter 6 --delay 0 --library energy";
    let said = terminal.run(&format!("{fit} --report r.html"));
    let inspected = terminal.run("inspect log.csv");
    let shown = terminal.json("show m.json");

    assert!(said.stderr.contains(&format!("note: {note}\n")), "{said:?}");
    assert!(!said.stderr.contains("warning: left out"), "{said:?}");
    assert!(inspected.stderr.contains(note), "{inspected:?}");
    assert!(inspected.stdout.contains(&format!("log: {note}")), "{inspected:?}");
    assert!(terminal.run("show m.json").stdout.contains(note));
    assert!(terminal.read("r.html").contains(note));
    assert_eq!(shown["conditioning"]["logs"].as_object().unwrap().len(), 1, "{shown}");
    assert_eq!(shown["conditioning"]["logs"]["log"], shown["conditioning"]["total"]);
    assert_eq!(terminal.json(fit)["conditioning"], shown["conditioning"]);
    let evaluated = terminal.json("evaluate m.json log.csv");
    assert_eq!(evaluated["conditioning"], shown["conditioning"]);
}

// Units, gears, signs.

#[test]
fn motor_currents_need_gears_and_constants_and_a_wrong_sign_is_told() {
    // Motors that turn 50 times as fast as their joints, the second one backward; N·m/A.
    let (gears, constants) = ([50.0, -40.0], [0.1, 0.08]);
    let mut table = Table::recorded();
    for (joint, (gear, constant)) in gears.into_iter().zip(constants).enumerate() {
        let [q, dq, tau] = ["q", "dq", "tau"].map(|signal| format!("{signal}{}", joint + 1));
        table = table.scaled(&[&q, &dq], gear).scaled(&[&tau], 1.0 / (gear * constant));
    }
    let terminal = Terminal::holding("log.csv", &table.text());
    let profile = |constants: &str| {
        format!(
            "[t]\ncolumn = \"t\"\n[q]\ncolumns = \"q\"\nscale = [0.02, -0.025]\n\
             [dq]\ncolumns = \"dq\"\nscale = [0.02, -0.025]\n\
             [tau]\ncolumns = \"tau\"\nunit = \"A\"\ngear = [50, -40]\n{constants}\n"
        )
    };
    terminal.write("none.toml", &profile(""));
    terminal.write("right.toml", &profile("torque_constant = [0.1, 0.08]"));
    terminal.write("wrong.toml", &profile("torque_constant = [0.1, -0.08]"));
    terminal.write("joint.csv", &Table::recorded().text());

    terminal.refused("inspect log.csv --profile none.toml", &["torque_constant"]);
    let wrong = terminal.run("fit log.csv -o m.json --profile wrong.toml");
    assert_warns(&wrong, &["turned round, the torque of joint2 would fit", "check the sign"]);
    assert!(!wrong.stderr.contains("turned round, the torque of joint1"), "{wrong:?}");
    let (right, plain) =
        (terminal.json("inspect log.csv --profile right.toml"), terminal.json("inspect joint.csv"));
    for joint in 0..2 {
        let deviation =
            |found: &serde_json::Value| found["joints"][joint]["tau_std"].as_f64().unwrap();
        assert!((deviation(&right) / deviation(&plain) - 1.0).abs() < 1e-9);
    }
    assert!(!right["warnings"].to_string().contains("check the sign"));
}

// Torques.

#[test]
fn a_fit_in_a_wider_band_than_its_search_is_not_called_a_poor_refit() {
    let mut table = Table::simulated("scara-4 --seconds 30 --rate 200 --seed 3");
    for joint in 1..=4 {
        let speed = table.place(&format!("dq{joint}"));
        let (name, largest) = (format!("tau{joint}"), |most: f64, tau: &f64| most.max(tau.abs()));
        let size = table.column(&name).iter().fold(0.0, largest);
        table = table.with(&name, |row, tau, values| {
            let dq = values[speed];
            tau + size * (0.1 * (dq / 0.02).tanh() + 0.07 * dq + 0.1 * noise(row + joint))
        });
        table = table.with(&format!("q{joint}"), |row, q, _| q + 6e-5 * noise(row + 7 * joint));
        table = table.without(&[&format!("dq{joint}"), &format!("ddq{joint}")]);
    }
    let terminal = Terminal::holding("log.csv", &table.text());

    let said = terminal.run("fit log.csv -o model.json");

    assert!(said.code == 0 && !said.stderr.contains("the torque that the search left"), "{said:?}");
}

#[test]
fn a_load_that_is_taken_up_within_a_log_is_told() {
    let table = Table::simulated("planar-2 --motion sines --seconds 80 --rate 50 --seed 4");
    let table = table.without(&["ddq1", "ddq2"]);
    let half = table.rows.len() / 2;
    let of_load = |row: usize, q: f64| if row < half { 0.0 } else { 2.0 * q.cos() };
    let table = table
        .with("t", |row, t, _| if row < half { t } else { t + 5.0 })
        .with("tau1", |row, tau, q| tau + of_load(row, q[1]) + of_load(row, q[1] + q[2]))
        .with("tau2", |row, tau, q| tau + of_load(row, q[1] + q[2]));
    let terminal = Terminal::holding("log.csv", &table.text());

    let said = terminal.run("fit log.csv -o model.json");

    assert_warns(&said, &["stretch 1 and stretch 2 disagree about the gravity of joint1"]);
}

#[test]
fn torques_that_are_none_and_positions_that_jump_are_told() {
    let pulled = |row: &[f64]| 24.0 * row[1].cos() + 4.0 * (row[1] + row[2]).cos();
    let led = Table::recorded()
        .with("tau1", |at, _, row| pulled(row) + 0.02 * noise(at))
        .with("tau2", |at, _, row| 4.0 * (row[1] + row[2]).cos() + 0.02 * noise(at + 7));
    let exchanged = Table::recorded().with("tau1", |_, _, row| row[3]);
    let held = Table::recorded().column("tau2")[700];
    let stuck = Table::recorded().with("tau2", |at, tau, _| {
        if (700..900).contains(&at) { held } else { tau + 1e-3 * noise(at) }
    });
    let off = Table::recorded().with("tau2", |_, _, _| 0.7);
    let slipped = Table::recorded().with("q2", |at, q, _| if at < 1_000 { q } else { q + 0.5 });
    let cases = [
        (led, "the torque of joint1 follows from the positions alone"),
        (exchanged, "the torque of joint1 is the velocity"),
        (stuck, "the torque of joint2 does not change for 1.99 s while it moves on"),
        (off, "the torque of joint2 never changes: is it measured?"),
        (slipped, "split at 1 jump of a position"),
    ];
    for (table, warned) in cases {
        let terminal = Terminal::holding("log.csv", &table.text());

        let said = terminal.run("fit log.csv -o model.json --strict");

        assert_warns(&said, &[warned]);
    }
}

// Motion.

#[test]
fn a_counterbalance_is_found_and_one_that_is_known_of_is_a_term() {
    let table = Table::recorded();
    let q = table.place("q1");
    let said = |found: &serde_json::Value, key: &str| {
        let choices = found["choices"].as_array().unwrap();
        let balance = choices.iter().find(|own| own["what"] == "counterbalance of joint1");
        balance.unwrap()[key].clone()
    };
    // A gas spring: no mass pulls with twice and thrice the angle.
    let spring = |_: usize, tau: f64, row: &[f64]| {
        tau - 15.0 * (2.0 * row[q]).sin() - 9.0 * (3.0 * row[q]).cos()
    };
    let terminal = Terminal::holding("log.csv", &table.clone().with("tau1", spring).text());
    assert_eq!(said(&terminal.json("fit log.csv -o model.json"), "chosen"), "spring");

    let spring = |_: usize, tau: f64, row: &[f64]| tau - 0.6 * (2.0 * row[q]).sin();
    terminal.write("log.csv", &table.with("tau1", spring).text());
    let fit = "fit log.csv -o model.json --library chain";
    let found = terminal.json(&format!("{fit} --counterbalance joint1"));

    assert_eq!(said(&found, "rule"), "as given");
    let told = terminal.done(&format!("{fit} --counterbalance joint1 --explain"));
    let line = told.lines().find(|line| line.starts_with("counterbalance of joint1")).unwrap();
    assert!(line.contains("spring") && line.ends_with("as given"), "{told}");
    // τ = ∂V/∂q, so that V = 0.3 cos 2q.
    let shown = terminal.done("show model.json");
    let line = shown.lines().find(|line| line.contains("* cos(2*q1)")).unwrap();
    let weight: f64 = line.split_whitespace().nth(1).unwrap().parse().unwrap();
    assert!((weight - 0.3).abs() < 0.05, "{line}");
    terminal.refused(&format!("{fit} --counterbalance elbow"), &["elbow", "joint1, joint2"]);
}

#[test]
fn a_model_that_is_judged_by_its_own_rows_is_told_so() {
    let terminal = Terminal::with_model();
    terminal.done("simulate planar-2 -o other.csv --seconds 20 --rate 50 --seed 8");
    let own = ["evaluate model.json log.csv", "compare log.csv --test log.csv --trig-order 1"];
    let others =
        ["evaluate model.json other.csv", "compare log.csv --test other.csv --trig-order 1"];
    for (line, is_told) in
        own.map(|line| (line, true)).into_iter().chain(others.map(|l| (l, false)))
    {
        let said = terminal.run(line);

        let found = said.stderr.contains("says nothing of others");
        assert_eq!(found, is_told, "{line}: {}", said.stderr);
    }
    // So is one of several logs.
    terminal.done("fit log.csv other.csv -o both.json");
    for own in ["log.csv", "other.csv"] {
        let said = terminal.run(&format!("evaluate both.json {own}"));
        assert!(said.stderr.contains("says nothing of others"), "{own}: {said:?}");
    }
    // The same motion under other torques is another log.
    terminal.write("turned.csv", &Table::of(&terminal, "log.csv").scaled(&["tau1"], -1.0).text());
    let said = terminal.run("evaluate model.json turned.csv --strict");
    assert_warns(&said, &["warning: unusable: "]);
    assert_eq!(terminal.run("evaluate model.json log.csv --strict").code, 0);
    assert!(!said.stderr.contains("says nothing of others"), "{said:?}");
    assert!(said.stdout.contains("verdict: unusable: test torque of joint1"), "{said:?}");
    terminal.refused("evaluate log.csv model.json", &["log.csv is a log, not a model"]);
}

#[test]
fn a_filter_that_cuts_the_motion_of_a_test_is_told() {
    let terminal = Terminal::new();
    for seed in [1, 2] {
        let plan = format!("planar-2 --motion sines --seconds 40 --rate 100 --seed {seed}");
        let table = Table::simulated(&plan).without(&["dq1", "dq2", "ddq1", "ddq2"]);
        terminal.write(&format!("log{seed}.csv"), &table.text());
    }
    for (cutoff, is_told) in [(0.8, true), (3.0, false)] {
        terminal.done(&format!("fit log1.csv -o model.json --filter {cutoff}"));

        let said = terminal.run("evaluate model.json log2.csv");

        let found = said.stderr.contains("joint2 less is missed of the raw torque");
        assert_eq!(found, is_told, "{said:?}");
    }
}
