//! Logs as they should not be, and as they are: each pitfall is told, or dealt with.
//!
//! One simulated arm, spoilt in turn as public logs of real arms are: docs/your-robot.md has the
//! list.

use crate::terminal::{Said, Terminal};

/// Columns of numbers.
#[derive(Clone)]
struct Table {
    header: Vec<String>,
    rows: Vec<Vec<f64>>,
}

impl Table {
    /// Two joints on sums of sines: 20 s at 100 Hz.
    fn arm() -> Self {
        Self::simulated("planar-2 --motion sines --seconds 20 --rate 100 --seed 4")
    }

    fn simulated(how: &str) -> Self {
        let terminal = Terminal::new();
        terminal.done(&format!("simulate {how} -o arm.csv"));
        Self::from_text(&terminal.read("arm.csv"))
    }

    fn from_text(text: &str) -> Self {
        let mut lines = text.lines();
        let header = lines.next().unwrap().split(',').map(str::to_owned).collect();
        let row = |line: &str| line.split(',').map(|cell| cell.parse().unwrap()).collect();
        Self { header, rows: lines.map(row).collect() }
    }

    /// As real arms are logged: without accelerations, with friction and a little noise.
    fn recorded() -> Self {
        let mut table = Self::arm().without(&["ddq1", "ddq2"]);
        for joint in ["1", "2"] {
            let speed = table.place(&format!("dq{joint}"));
            table = table.with(&format!("tau{joint}"), |row, tau, values| {
                let dq = values[speed];
                tau + 0.6 * dq + 0.4 * (dq / 0.02).tanh() + 0.05 * noise(row)
            });
            table = table.with(&format!("q{joint}"), |row, q, _| q + 1e-4 * noise(row + 7));
        }
        table
    }

    fn place(&self, name: &str) -> usize {
        self.header.iter().position(|known| known == name).unwrap()
    }

    /// Another value in a column, of row, value and all values of the row.
    fn with(mut self, name: &str, value: impl Fn(usize, f64, &[f64]) -> f64) -> Self {
        let place = self.place(name);
        for (number, row) in self.rows.iter_mut().enumerate() {
            row[place] = value(number, row[place], row);
        }
        self
    }

    fn scaled(self, names: &[&str], factor: f64) -> Self {
        names.iter().fold(self, |table, name| table.with(name, |_, value, _| factor * value))
    }

    fn without(mut self, names: &[&str]) -> Self {
        for name in names {
            let place = self.place(name);
            self.header.remove(place);
            for row in &mut self.rows {
                row.remove(place);
            }
        }
        self
    }

    fn renamed(mut self, names: &[(&str, &str)]) -> Self {
        for (old, new) in names {
            let place = self.place(old);
            (*new).clone_into(&mut self.header[place]);
        }
        self
    }

    /// The same values once more, under another name.
    fn twice(mut self, name: &str, again: &str) -> Self {
        let place = self.place(name);
        self.header.push(again.to_owned());
        self.rows.iter_mut().for_each(|row| row.push(row[place]));
        self
    }

    fn text(&self) -> String {
        self.text_by(",")
    }

    fn text_by(&self, separator: &str) -> String {
        let row = |row: &Vec<f64>| {
            row.iter().map(|x| format!("{x:?}")).collect::<Vec<_>>().join(separator) + "\n"
        };
        let rows: String = self.rows.iter().map(row).collect();
        self.header.join(separator) + "\n" + &rows
    }

    fn inspected(&self) -> Said {
        let terminal = Terminal::new();
        terminal.write("log.csv", &self.text());
        terminal.run("inspect log.csv")
    }
}

/// Between -1 and 1, the same at each run.
fn noise(row: usize) -> f64 {
    let x = (row as f64 * 12.9898).sin() * 43_758.545_3;
    2.0 * (x - x.floor()) - 1.0
}

/// Whether it was said with a warning, and on which stream.
fn assert_warns(said: &Said, words: &[&str]) {
    assert_eq!(said.code, 3, "{said:?}");
    for word in words {
        assert!(said.stderr.contains(word), "{word:?}: {}", said.stderr);
    }
}

fn assert_tells(said: &Said, words: &[&str]) {
    assert!(matches!(said.code, 0 | 3), "{said:?}");
    for word in words {
        assert!(said.stdout.contains(word), "{word:?}: {}", said.stdout);
    }
}

const TORQUE_WORDS: [&str; 5] =
    ["does not follow", "falls as it", "gravity compensation", "few levels", "measured velocity"];

#[test]
fn a_sound_log_is_not_suspected() {
    for table in [Table::arm(), Table::recorded()] {
        let said = table.inspected();

        for word in TORQUE_WORDS {
            assert!(!said.stderr.contains(word), "{word}: {}", said.stderr);
        }
        assert!(!said.stdout.contains("tau advanced"), "{}", said.stdout);
    }
}

// Files.

#[test]
fn a_format_that_is_not_read_is_named_with_those_that_are() {
    let terminal = Terminal::new();
    terminal.write("data.pickle", "\u{80}");

    terminal.refused("inspect data.pickle", &["no log format known here", ".npz", "convert"]);
}

#[test]
fn headers_and_rows_with_a_space_after_each_comma_are_read() {
    let terminal = Terminal::new();
    terminal.write("log.csv", &Table::arm().text_by(", "));

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
}

#[test]
fn several_logs_of_other_rates_are_read_together() {
    let terminal = Terminal::new();
    terminal.write("a.csv", &Table::recorded().text());
    let slow = "planar-2 --motion sines --seconds 20 --rate 50 --seed 9";
    terminal.write("b.csv", &Table::simulated(slow).without(&["ddq1", "ddq2"]).text());

    let found = terminal.json("inspect a.csv b.csv");

    assert_eq!(found["trajectories"], 2);
}

// Clocks.

#[test]
fn jitter_is_made_even() {
    let said = Table::recorded().with("t", |row, t, _| t + 2e-3 * noise(row)).inspected();

    assert_tells(&said, &["made even: jitter"]);
}

#[test]
fn a_log_without_a_clock_asks_for_its_rate() {
    let terminal = Terminal::new();
    terminal.write("log.csv", &Table::recorded().without(&["t"]).text());
    let profile = |rate: &str| {
        format!("{rate}\n[q]\ncolumns = \"q\"\n[dq]\ncolumns = \"dq\"\n[tau]\ncolumns = \"tau\"\n")
    };
    terminal.write("none.toml", &profile(""));
    terminal.write("right.toml", &profile("rate = 100.0"));
    terminal.write("wrong.toml", &profile("rate = 200.0"));

    terminal.refused("fit log.csv --profile none.toml -o m.json", &["no clock", "rate = …"]);
    let right = terminal.run("inspect log.csv --profile right.toml");
    let wrong = terminal.run("inspect log.csv --profile wrong.toml");

    assert!(!right.stderr.contains("measured velocity"), "{right:?}");
    assert_warns(&wrong, &["measured velocity of joint1 is 0.50", "and the clock of the log"]);
}

#[test]
fn repeated_stamps_and_a_restarted_clock_are_left_out_and_told() {
    let terminal = Terminal::new();
    let mut table = Table::recorded();
    let again = table.rows[500].clone();
    table.rows.insert(501, again);
    let restarted = table.rows[..300].to_vec();
    table.rows.extend(restarted);
    terminal.write("log.csv", &table.text());

    terminal.refused("inspect log.csv", &["row 2002", "does not follow"]);
    let said = terminal.run("inspect log.csv --repair");

    assert_warns(
        &said,
        &[
            "note: left out: 1 rows with the time stamp of the row before",
            "left out: 300 rows earlier than a row before them, the first is row 2002",
            "put what follows in a file of its own",
        ],
    );
}

/// A spike, a repeated stamp, a pause that is bridged and one that is not.
fn needs_repair() -> Table {
    let mut table = Table::recorded().with("tau1", |row, tau, _| match row {
        400 => tau + 300.0,
        _ => tau,
    });
    let again = table.rows[500].clone();
    table.rows.splice(1_700..1_730, []);
    table.rows.splice(900..903, []);
    table.rows.insert(501, again);
    table
}

#[test]
fn what_was_repaired_in_a_log_is_a_note_and_stays_with_the_model() {
    let terminal = Terminal::new();
    terminal.write("log.csv", &needs_repair().text());
    terminal.write("sound.csv", &Table::recorded().text());
    let note = "left out: 1 rows with the time stamp of the row before; repaired: 3 spikes \
                replaced (q 2, tau 1), 1 gaps bridged (the longest 40.0 ms), 1 longer gaps at \
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

#[test]
fn a_sound_log_needs_no_repair() {
    let terminal = Terminal::new();
    terminal.write("log.csv", &Table::recorded().text());

    let said = terminal.run("inspect log.csv");

    assert!(!said.stdout.contains("conditioning"), "{said:?}");
    assert!(!said.stderr.contains("note:"), "{said:?}");
}

// Units, gears, signs.

#[test]
fn degrees_are_suspected_and_read_with_a_profile() {
    let terminal = Terminal::new();
    let names = ["q1", "q2", "dq1", "dq2"];
    let table = Table::arm().scaled(&names, 180.0 / std::f64::consts::PI);
    terminal.write("log.csv", &table.text());
    terminal.write(
        "degrees.toml",
        "[t]\ncolumn = \"t\"\n[q]\ncolumns = \"q\"\nunit = \"deg\"\n\
         [dq]\ncolumns = \"dq\"\nunit = \"deg/s\"\n[tau]\ncolumns = \"tau\"\n",
    );

    assert_warns(&terminal.run("inspect log.csv"), &["q1 reaches", "is it in degrees?"]);
    let said = terminal.run("inspect log.csv --profile degrees.toml");
    assert!(!said.stderr.contains("degrees"), "{said:?}");
}

#[test]
fn velocity_in_another_unit_than_position_is_told() {
    let said = Table::recorded().scaled(&["dq1", "dq2"], 30.0 / std::f64::consts::PI).inspected();

    assert_warns(&said, &["measured velocity of joint2 is 9.5"]);
}

#[test]
fn motor_currents_need_gears_and_constants_and_a_wrong_sign_is_told() {
    let terminal = Terminal::new();
    // Motors that turn 50 times as fast as their joints, the second one backward; N·m/A.
    let (gears, constants) = ([50.0, -40.0], [0.1, 0.08]);
    let mut table = Table::recorded();
    for (joint, (gear, constant)) in gears.into_iter().zip(constants).enumerate() {
        let [q, dq, tau] = ["q", "dq", "tau"].map(|signal| format!("{signal}{}", joint + 1));
        table = table.scaled(&[&q, &dq], gear).scaled(&[&tau], 1.0 / (gear * constant));
    }
    terminal.write("log.csv", &table.text());
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
    assert_warns(
        &wrong,
        &["the torque of joint2 contradicts those of the other joints", "check the sign"],
    );
    assert!(!wrong.stderr.contains("the torque of joint1 contradicts"), "{wrong:?}");
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
fn torque_that_lags_is_advanced() {
    let table = Table::recorded();
    let late = |name: &str| -> Vec<f64> {
        let place = table.place(name);
        (0..table.rows.len()).map(|row| table.rows[row.saturating_sub(2)][place]).collect()
    };
    let (first, second) = (late("tau1"), late("tau2"));
    let said = table
        .clone()
        .with("tau1", |row, _, _| first[row])
        .with("tau2", |row, _, _| second[row])
        .inspected();

    let (_, advanced) = said.stdout.split_once("tau advanced by ").unwrap();
    let ms: f64 = advanced.split_once(" ms").unwrap().0.parse().unwrap();
    // Two rows at 100 Hz; half a row beside it is no harm.
    assert!((ms - 20.0).abs() < 5.0, "{ms}");
}

#[test]
fn torque_that_a_hand_supplies_is_told() {
    let table = Table::recorded();
    let q = [table.place("q1"), table.place("q2")];
    let said = table
        .with("tau1", |_, _, row| 24.0 * row[q[0]].cos() + 4.0 * (row[q[0]] + row[q[1]]).cos())
        .with("tau2", |_, _, row| 4.0 * row[q[1]].sin())
        .inspected();

    assert_warns(&said, &["the torque of joint2 follows from the positions alone", "hand"]);
}

#[test]
fn a_motor_that_is_off_is_told() {
    let said = Table::recorded().with("tau2", |row, _, _| 0.02 * noise(row)).inspected();
    assert_warns(&said, &["the torque of joint2 does not follow its motion", "is its motor on"]);

    let terminal = Terminal::new();
    terminal.write("off.csv", &Table::arm().with("tau2", |_, _, _| 0.0).text());
    let said = terminal.run("fit off.csv -o model.json");
    assert_warns(&said, &["the torque of joint2 never changes: is it measured?"]);
}

#[test]
fn spikes_are_replaced_and_counted() {
    let spoilt = Table::recorded().with("tau1", |row, tau, _| match row {
        400 | 900 | 1_500 => tau + 300.0,
        _ => tau,
    });

    assert_tells(&spoilt.inspected(), &["tau of joint1: 3 outliers replaced"]);
}

#[test]
fn a_coarse_current_is_told() {
    let said = Table::recorded().with("tau2", |_, tau, _| (tau / 1.5).round() * 1.5).inspected();

    assert_warns(&said, &["the torque of joint2 has few levels", "expect a poor fit"]);
    assert_tells(&said, &["tau of joint2 is quantised to 1.5"]);
}

// Motion.

#[test]
fn velocity_that_a_robot_filtered_is_told_and_not_used() {
    let mut table = Table::recorded();
    for name in ["dq1", "dq2"] {
        let place = table.place(name);
        // First order, a time constant of 50 ms.
        let mut slow = table.rows[0][place];
        for row in &mut table.rows {
            slow += 0.2 * (row[place] - slow);
            row[place] = slow;
        }
    }

    let (late, sound) = (table.inspected(), Table::recorded().inspected());

    let lag = |said: &Said| -> f64 {
        let (_, lag) = said.stdout.split_once("measured dq lags d(q)/dt by ").unwrap();
        lag.split_once(" ms").unwrap().0.parse().unwrap()
    };
    // 50 ms less half a row at low frequencies.
    assert!((30.0..60.0).contains(&lag(&late)), "{}", lag(&late));
    assert!(lag(&sound).abs() < 2.0, "{}", lag(&sound));
}

#[test]
fn an_encoder_that_is_not_there_is_told() {
    let said = Table::arm().with("q2", |_, _, _| 0.0).scaled(&["dq2", "ddq2"], 0.0).inspected();

    assert_warns(&said, &["joint2 never moves"]);
}

#[test]
fn a_log_that_ends_at_rest_is_cut_by_its_profile() {
    let terminal = Terminal::new();
    let mut table = Table::recorded();
    let last = table.rows[1_999].clone();
    table.rows.extend((0..500).map(|row| {
        let mut rest = last.clone();
        rest[0] = 20.0 + 0.01 * f64::from(row);
        rest
    }));
    terminal.write("log.csv", &table.text());
    terminal.write(
        "cut.toml",
        "seconds = [[0.0, 19.995]]\n[t]\ncolumn = \"t\"\n[q]\ncolumns = \"q\"\n\
         [tau]\ncolumns = \"tau\"\n",
    );

    let raw = "inspect log.csv --profile cut.toml --filter none";
    assert_eq!(terminal.json(raw)["rows"], 2_000);
}

#[test]
fn a_counterbalance_is_found() {
    let terminal = Terminal::new();
    let table = Table::recorded();
    let q = table.place("q1");
    // A gas spring: no mass pulls with twice and thrice the angle.
    let spring = |_: usize, tau: f64, row: &[f64]| {
        tau - 15.0 * (2.0 * row[q]).sin() - 9.0 * (3.0 * row[q]).cos()
    };
    terminal.write("log.csv", &table.with("tau1", spring).text());

    let found = terminal.json("fit log.csv -o model.json");

    let choices = found["choices"].as_array().unwrap();
    let chosen = |what: &str| {
        choices.iter().find(|choice| choice["what"] == what).map(|choice| choice["chosen"].clone())
    };
    assert_eq!(chosen("counterbalance of joint1"), Some("spring".into()), "{choices:?}");
}

#[test]
fn a_counterbalance_that_is_known_of_is_a_term() {
    let terminal = Terminal::new();
    let table = Table::recorded();
    let q = table.place("q1");
    let spring = |_: usize, tau: f64, row: &[f64]| tau - 0.6 * (2.0 * row[q]).sin();
    terminal.write("log.csv", &table.with("tau1", spring).text());

    let fit = "fit log.csv -o model.json --library chain";
    let found = terminal.json(&format!("{fit} --counterbalance joint1"));

    let choices = found["choices"].as_array().unwrap();
    let balance = choices.iter().find(|choice| choice["what"] == "counterbalance of joint1");
    assert_eq!(balance.map(|choice| choice["rule"].clone()), Some("as given".into()));
    // τ = ∂V/∂q, so that V = 0.3 cos 2q.
    let shown = terminal.done("show model.json");
    let line = shown.lines().find(|line| line.contains("* cos(2*q1)")).unwrap();
    let weight: f64 = line.split_whitespace().nth(1).unwrap().parse().unwrap();
    assert!((weight - 0.3).abs() < 0.05, "{line}");
    terminal.refused(&format!("{fit} --counterbalance elbow"), &["elbow", "joint1, joint2"]);
}

// Logs together.

/// The reference arm of two links, its second one so heavy.
fn loaded(mass: &str) -> String {
    let link = |name: &str, a: f64, mass: &str, inertia: f64| {
        format!(
            "[[joints]]\nname = \"{name}\"\na = {a:?}\nalpha = 0.0\nd = 0.0\nmass = {mass}\n\
             com = [{:?}, 0.0, 0.0]\ninertia = [0.001, {inertia:?}, {inertia:?}, 0.0, 0.0, 0.0]\n",
            -0.5 * a
        )
    };
    format!(
        "name = \"loaded\"\nbase_rpy = [1.5707963267948966, 0.0, 0.0]\n{}{}",
        link("upper", 0.5, "4.0", 0.08),
        link("fore", 0.4, mass, 0.03)
    )
}

#[test]
fn logs_of_other_payloads_are_told_apart() {
    let terminal = Terminal::new();
    terminal.write("bare.toml", &loaded("2.0"));
    terminal.write("laden.toml", &loaded("2.6"));
    for (arm, log, seed) in [("bare", "a", 1), ("laden", "b", 2), ("bare", "c", 3)] {
        terminal.done(&format!(
            "simulate {arm}.toml -o {log}.csv --seconds 40 --rate 50 --seed {seed} \
             --noise-db 60,50,40"
        ));
    }

    let mixed = terminal.run("fit a.csv b.csv -o mixed.json");
    let alike = terminal.run("fit a.csv c.csv -o alike.json");

    let words = ["a.csv and b.csv disagree about the gravity of", "fore (", "Fit them apart"];
    assert_warns(&mixed, &words);
    assert!(!alike.stderr.contains("disagree"), "{alike:?}");
}

/// A copy of a log whose torque of one joint is changed row by row.
fn with_torque(terminal: &Terminal, log: &str, joint: usize, change: impl Fn(f64) -> f64) {
    let text = terminal.read(log);
    let name = format!("tau{joint}");
    let place = text.lines().next().unwrap().split(',').position(|own| own == name).unwrap();
    let changed = |(number, line): (usize, &str)| {
        let mut cells: Vec<String> = line.split(',').map(Into::into).collect();
        if number > 0 {
            cells[place] = format!("{:?}", change(cells[place].parse().unwrap()));
        }
        cells.join(",") + "\n"
    };
    terminal.write("changed.csv", &text.lines().enumerate().map(changed).collect::<String>());
}

#[test]
fn d24_a_torque_of_the_wrong_sign_is_named_on_any_joint() {
    let all = [
        ("planar-2", vec![1, 2], ""),
        ("puma560-3", vec![1, 2, 3], ""),
        ("puma560-3", vec![1], "--library product"),
        ("generic-4", vec![1, 2], ""),
        ("generic-6", vec![6], ""),
    ];
    for (arm, joints, how) in all {
        let terminal = Terminal::new();
        terminal.done(&format!("simulate {arm} -o log.csv --seconds 60 --rate 100"));
        for joint in joints {
            with_torque(&terminal, "log.csv", joint, |tau| -tau);
            let said = terminal.run(&format!("fit changed.csv -o m.json {how}"));
            assert_eq!(said.code, 3, "{said:?}");
            let verdict = format!("unusable: the torque of joint{joint} has the wrong sign");
            assert!(said.stdout.contains(&verdict), "{said:?}");
            assert_eq!(said.stdout.matches("has the wrong sign").count(), 1, "{said:?}");
            assert!(said.stderr.contains("check the sign of its torque"), "{said:?}");
        }
    }
}

#[test]
fn d23_a_torque_that_was_cut_off_is_named() {
    let terminal = Terminal::new();
    terminal.done("simulate puma560-3 -o log.csv --seconds 60 --rate 100");
    for joint in 1..=3 {
        let text = terminal.read("log.csv");
        let place =
            text.lines().next().unwrap().split(',').position(|n| n == format!("tau{joint}"));
        let tau =
            |line: &str| -> f64 { line.split(',').nth(place.unwrap()).unwrap().parse().unwrap() };
        let values: Vec<f64> = text.lines().skip(1).map(tau).collect();
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let square = values.iter().map(|tau| (tau - mean).powi(2)).sum::<f64>();
        let limit = 0.2 * (square / values.len() as f64).sqrt();
        with_torque(&terminal, "log.csv", joint, |tau| tau.clamp(mean - limit, mean + limit));

        let said = terminal.run("fit changed.csv -o m.json");

        assert_eq!(said.code, 3, "{said:?}");
        let verdict = format!("unusable: the torque of joint{joint} is cut off");
        assert!(said.stdout.contains(&verdict), "{said:?}");
    }
}

#[test]
fn d25_an_arm_of_too_many_joints_is_refused_from_the_header() {
    let terminal = Terminal::new();
    let signals = ["q", "dq", "ddq", "tau"];
    for joints in [9, 12, 50] {
        let columns = signals.iter().flat_map(|own| (1..=joints).map(move |k| format!("{own}{k}")));
        let header: Vec<String> = std::iter::once("t".into()).chain(columns).collect();
        let row = |k: usize| {
            let values = (0..4 * joints).map(|own| ((own * k) as f64 * 0.01).sin().to_string());
            format!("{},{}\n", k as f64 * 0.01, values.collect::<Vec<_>>().join(","))
        };
        let rows: String = (0..20).map(row).collect();
        terminal.write("many.csv", &format!("{}\n{rows}", header.join(",")));

        // Twenty rows are too few, which is told only once they were read.
        terminal.refused("fit many.csv -o m.json", &[&joints.to_string(), "at most", "profile"]);
        terminal.refused("moments many.csv -o m.moments", &[&joints.to_string(), "at most"]);
    }
}

#[test]
fn d27_a_torque_beyond_all_numbers_is_an_error() {
    let terminal = Terminal::with_model();
    for cell in ["1e200", "-1e300"] {
        let mut rows: Vec<String> = terminal.read("log.csv").lines().map(Into::into).collect();
        let mut cells: Vec<&str> = rows[9].split(',').collect();
        cells[3] = cell;
        rows[9] = cells.join(",");
        terminal.write("far.csv", &rows.join("\n"));

        terminal.refused("predict model.json far.csv -o p.csv", &["torque", "beyond all numbers"]);
    }
}

/// A term of all powers that are taken is written at once; beyond, none is expanded.
#[test]
fn a12_powers_that_would_fill_the_memory_are_refused_at_once() {
    let terminal = Terminal::new();
    let model = |power: u8| {
        let factor = |joint: usize| {
            let multiples: Vec<u8> = (0..4).map(|own| u8::from(own == joint)).collect();
            format!(r#"{{"multiples": {multiples:?}, "function": "cos", "power": {power}}}"#)
        };
        let factors = (0..4).map(factor).collect::<Vec<_>>().join(",");
        let zeros = "[0, 0, 0, 0]";
        let function = format!(r#"{{"factors": [{factors}], "dq": {zeros}, "ddq": {zeros}}}"#);
        let term = format!(r#"{{"place": "potential", "function": {function}}}"#);
        let ones = "[1.0, 1.0, 1.0, 1.0]";
        let training = format!(
            r#"{{"rows": 3000, "residual_rms": {ones}, "torque_std": {ones},
            "q_range": [[-1, 1], [-1, 1], [-1, 1], [-1, 1]], "dq_peak": {ones}, "ddq_peak": {ones}}}"#
        );
        format!(
            r#"{{"format": "torquewise-model", "version": 1, "joints": ["a", "b", "c", "d"],
            "form": {{"energy": [{{"term": {term}, "coefficient": 1.0, "std_error": 0.0}}]}},
            "stages": [], "training": {training}, "choices": [], "friction": []}}"#
        )
    };
    terminal.write("most.json", &model(8));
    terminal.done("show most.json --cost");
    let said = terminal.run("export most.json --to c -o most.c --force");
    assert!(said.code == 3 && said.stderr.contains("M(q) has the eigenvalue"), "{said:?}");
    assert!(terminal.read("most.c").contains("most_torque"));
    for power in [9, 60] {
        terminal.write("powers.json", &model(power));
        terminal.refused("export powers.json --to c -o a.c --force", &["1 to 32"]);
        terminal.refused("show powers.json --cost", &["1 to 32"]);
    }
}

#[test]
fn b15_a_joint_of_a_long_name_is_refused_and_nothing_is_left() {
    let terminal = Terminal::with_log();
    let log = terminal.read("log.csv");
    for length in [201, 65_536] {
        terminal.write("long.csv", &format!("# joints: {},elbow\n{log}", "x".repeat(length)));

        terminal.refused("fit long.csv -o m.json", &["joint name", "at most 200 bytes"]);
    }
    terminal.write("short.csv", &format!("# joints: {},elbow\n{log}", "x".repeat(200)));
    terminal.done("fit short.csv -o m.json");
}

#[test]
fn e31_models_that_no_program_of_ours_wrote_are_refused() {
    let terminal = Terminal::with_model();
    let model = terminal.read("model.json");
    let power = "\"power\": 1";
    let multiple = "\"function\": \"cos\"";
    assert!(model.contains(power) && model.contains(multiple));
    for bad in [
        model.replacen(power, "\"power\": 255", 1),
        model.replacen(power, "\"power\": 0", 1),
        model.replacen("\"multiples\": [\n", "\"multiples\": [\n -128,", 1),
    ] {
        assert_ne!(bad, model);
        terminal.write("bad.json", &bad);
        terminal.refused("show bad.json", &["bad.json"]);
        terminal.refused("export bad.json --to c -o a.c", &["bad.json"]);
    }
}
