//! Several logs together, wrong torques, and files that are refused before they do harm.

use crate::friction::DRY;
use crate::spoilt::{Table, assert_warns};
use crate::terminal::Terminal;

#[test]
fn a_torque_that_was_cut_off_is_named() {
    let log = Table::simulated("puma560-3 --seconds 60 --rate 100");
    let terminal = Terminal::new();
    for joint in 1..=3 {
        let name = format!("tau{joint}");
        let values = log.column(&name);
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let square = values.iter().map(|tau| (tau - mean).powi(2)).sum::<f64>();
        let limit = 0.2 * (square / values.len() as f64).sqrt();
        let cut = log.clone().with(&name, |_, tau, _| tau.clamp(mean - limit, mean + limit));
        terminal.write("changed.csv", &cut.text());

        let said = terminal.run("fit changed.csv -o m.json");

        assert_eq!(said.code, 3, "{said:?}");
        let verdict = format!("unusable: the torque of joint{joint} is cut off");
        assert!(said.stdout.contains(&verdict), "{said:?}");
    }
}

#[test]
fn a_torque_that_was_cut_off_is_no_other_unit() {
    let terminal = Terminal::holding("dry.toml", DRY);
    let plan = "planar-2 --motion sines --seconds 60 --rate 100 --seed 2 --friction dry.toml";
    terminal.done(&format!("simulate {plan} -o log.csv"));
    let cut = Table::of(&terminal, "log.csv").with("tau1", |_, tau, _| tau.clamp(-4.0, 4.0));
    terminal.write("cut.csv", &cut.text());

    let said = terminal.run("fit cut.csv -o m.json");

    assert!(said.stdout.contains("the torque of joint1 is cut off"), "{said:?}");
    assert!(!said.stderr.contains("in one unit"), "{said:?}");
}

#[test]
fn units_that_a_profile_leaves_open_are_told_with_their_cure() {
    let table = Table::recorded();
    let terminal = Terminal::holding("ms.csv", &table.clone().scaled(&["t"], 1e3).text());
    let cure = "t = { column = \"t\", unit = \"ms\" }";
    terminal.refused("fit ms.csv -o m.json", &["has steps of 10.0 s", cure]);
    terminal.write("fast.csv", &table.clone().scaled(&["t"], 90.0).text());
    assert_warns(&terminal.run("inspect fast.csv --strict"), &["has steps of 0.9 s", cure]);
    terminal.write("ms.toml", cure);
    assert!(!terminal.run("inspect ms.csv --profile ms.toml").stderr.contains(cure));

    // Among degrees no arm is found.
    let arm = Table::simulated("planar-2 --seconds 20 --rate 100 --motion sines --seed 1");
    let bare = arm.without(&["dq1", "dq2", "ddq1", "ddq2"]);
    terminal.write("degrees.csv", &bare.scaled(&["q1", "q2"], 1_f64.to_degrees()).text());
    terminal.refused("fit degrees.csv -o m.json", &["q of joint1 reaches", "are degrees, `unit`"]);

    let renamed = [("q1", "pos1"), ("q2", "pos2"), ("tau1", "current1"), ("tau2", "current2")];
    terminal.write("log.csv", &table.renamed(&renamed).text());
    let literal = terminal.run("inspect log.csv").stdout;
    let filled = literal.replace("# unit", "unit").replace("# torque_c", "torque_c");
    for (toml, told) in [
        (&literal, "[tau] names currents and no unit, so they are taken as N·m"),
        (&filled, "every torque_constant of [tau] is 1.0, as a suggested profile has it"),
    ] {
        terminal.write("p.toml", toml);
        assert_warns(&terminal.run("inspect log.csv --profile p.toml --strict"), &[told]);
    }
}

#[test]
fn torques_in_a_second_file_are_suggested_beside_the_log() {
    let terminal = Terminal::new();
    // Columns that only the name of their file explains.
    for (file, signal, others) in [("positions", "q", "tau"), ("torques", "tau", "q")] {
        let own = [1, 2].map(|joint| [signal, others, "dq"].map(|name| format!("{name}{joint}")));
        let table = own.iter().zip(["j1", "j2"]).fold(Table::recorded(), |table, (own, name)| {
            table.renamed(&[(&own[0], name)]).without(&[&own[1], &own[2]])
        });
        terminal.write(&format!("{file}.csv"), &table.text());
    }

    terminal.write("p.toml", &terminal.run("inspect positions.csv torques.csv").stdout);

    assert!(terminal.read("p.toml").contains("[beside]\ntorques = \"torques.csv\""));
    let found = terminal.json("inspect positions.csv --profile p.toml");
    assert_eq!(found["missing"], serde_json::json!(["dq", "ddq"]));

    terminal.write("junk.csv", "a,b,c\n1,2,3\n4,5,6\n");
    let said = terminal.run("inspect positions.csv torques.csv junk.csv").stderr;
    assert!(said.contains("junk.csv has nothing that the log lacks"), "{said}");
    assert!(said.contains("inspect positions.csv alone with --profile profile.toml"), "{said}");
    terminal.refused("inspect positions.csv none.csv", &["none.csv"]);
    let huge = Table::arm().scaled(&["tau1", "tau2"], 1e6).text();
    terminal.write("huge.csv", &huge);
    assert_warns(&terminal.run("inspect huge.csv --strict"), &["are these mN·m?"]);
}

#[test]
fn an_arm_of_too_many_joints_is_refused_from_the_header() {
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
fn a_torque_that_overflows_is_an_error() {
    let terminal = Terminal::with_model();
    for cell in [1e200, -1e300] {
        let mut far = Table::of(&terminal, "log.csv");
        far.rows[8][3] = cell;
        terminal.write("far.csv", &far.text());
        let said = terminal.run("predict model.json far.csv -o p.csv");
        assert!(said.stdout.contains("1 row with a value far beyond its neighbours"), "{said:?}");

        far.rows[8..908].iter_mut().for_each(|row| row[3] = cell);
        terminal.write("far.csv", &far.text());
        terminal.refused("predict model.json far.csv -o p.csv", &["torque", "overflows"]);
    }
}

/// A term of all powers that are taken is written at once; beyond, none is expanded.
#[test]
fn powers_that_would_fill_the_memory_are_refused_at_once() {
    let model = |power: u8, multiple: i8| {
        let text = include_str!("powers.json").replace("POWER", &power.to_string());
        text.replace("MULTIPLE", &multiple.to_string())
    };
    let terminal = Terminal::holding("most.json", &model(8, 1));
    terminal.done("show most.json --cost");
    let said = terminal.run("export most.json --to c -o most.c --force --strict");
    assert!(said.code == 3 && said.stderr.contains("M(q) has the eigenvalue"), "{said:?}");
    assert!(terminal.read("most.c").contains("most_torque"));
    for (power, multiple) in [(0, 1), (9, 1), (60, 1), (255, 1), (1, -128)] {
        terminal.write("powers.json", &model(power, multiple));
        terminal.refused("export powers.json --to c -o a.c --force", &["1 to 32"]);
        terminal.refused("show powers.json --cost", &["1 to 32"]);
    }
}

#[test]
fn a_joint_of_a_long_name_is_refused_and_nothing_is_left() {
    let terminal = Terminal::with_log();
    let log = terminal.read("log.csv");
    for length in [201, 65_536] {
        terminal.write("long.csv", &format!("# joints: {},elbow\n{log}", "x".repeat(length)));

        terminal.refused("fit long.csv -o m.json", &["joint name", "at most 200 bytes"]);
    }
    terminal.write("short.csv", &format!("# joints: {},elbow\n{log}", "x".repeat(200)));
    terminal.done("fit short.csv -o m.json");
}
