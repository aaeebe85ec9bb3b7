//! A model in the loop: files, words, numbers, and what is refused.

use crate::spoilt::assert_warns;
use crate::terminal::{Terminal, assert_says, numbers};

const FRICTION: &str = "[joint1]\ncoulomb = 2.0\nstiction = 3.0\nspeed = 0.1\nviscous = 1.0\n\
    [joint2]\ncoulomb = 0.5\nviscous = 0.2\n";

const SHORT: &str = "--seconds 4 --period 2";

#[test]
fn a_learned_model_tracks_better_than_feedback_alone() {
    let terminal = Terminal::with_model();

    // So slow that gravity is most of the torque, though the integral of PID follows much of it.
    let slow = "--seconds 12 --period 6 --speed 0.6 --acceleration 0.6";
    let found = terminal.json(&format!("control model.json --arm planar-2 {slow}"));

    let [pid, first, second] =
        ["pid", "controller1", "controller2"].map(|c| numbers(&found[c]["rms_error_rad"]));
    for joint in 0..2 {
        assert!(first[joint] < pid[joint], "{found}");
        assert!(second[joint] < 0.1 * pid[joint], "{found}");
    }
    assert_eq!(found["gains"]["proportional"].as_array().unwrap().len(), 2);
    assert_eq!(found["warnings"], serde_json::json!([]));
}

#[test]
fn every_controller_is_told_and_drawn() {
    let terminal = Terminal::with_model();
    terminal.write("friction.toml", FRICTION);
    let all = "pid,controller1,controller2,computed-torque,hand-guiding";

    let line = format!("control model.json --arm planar-2 {SHORT} --friction friction.toml");
    let text = terminal.done(&format!(
        "{line} --controllers {all} --perfect --delay 0.001 -o log.csv --plot plot.svg \
         --report page.html --rotor 0.1,0.05"
    ));

    assert_says(&text, &["pid", "computed_torque", "hand_guiding", "controller2_perfect"]);
    assert_says(&text, &["joint2 [mrad]", "joint1 hand [N·m]", "report: page.html"]);
    let log = terminal.read("log.csv");
    let header: Vec<&str> = log.lines().next().unwrap().split(',').collect();
    // t, two desired positions, and position, error and torque of 2 joints by 7 controllers.
    assert_eq!((header.len(), log.lines().count()), (3 + 7 * 6, 4002));
    assert_eq!(header[..4], ["t", "q1_ref", "q2_ref", "pid_q1"]);
    for file in ["plot.svg", "page.html"] {
        let shown = terminal.read(file);
        assert!(shown.contains("controller2_perfect") && !shown.contains("NaN"), "{file}");
    }
}

#[test]
fn drives_that_are_too_weak_are_a_warning() {
    let terminal = Terminal::with_model();

    let line = format!("control model.json --arm planar-2 {SHORT} --torque-limit 12 --strict");

    assert_warns(&terminal.run(&line), &["pid: joint1 is at the limit of its torque"]);
}

#[test]
fn what_cannot_be_controlled_is_refused() {
    let terminal = Terminal::with_model();
    terminal.write("wrong.toml", "[wrist]\ncoulomb = 1.0");
    terminal.write("negative.toml", "[joint1]\ncoulomb = -1.0");
    let refused = |words: &str, told: &[&str]| {
        terminal.refused(&format!("control model.json {words}"), told);
    };

    refused("--arm puma560-3", &["joint1, joint2, the arm has joint1, joint2, joint3"]);
    refused("--arm planar-2 --friction wrong.toml", &["wrong.toml", "`wrist`", "joint1, joint2"]);
    refused("--arm planar-2 --friction negative.toml", &["coulomb", "0 N·m or more"]);
    refused("--arm planar-2 --friction none.toml", &["none.toml cannot be read"]);
    refused(
        "--arm planar-2 --torque-limit 1,2,3",
        &["3 numbers, expected 2", "one for each joint"],
    );
    refused("--arm planar-2 --bandwidth 0", &["bandwidth", "0.001 to 10000"]);
    refused("--arm planar-2 --rate nan", &["control rate"]);
    refused("--arm planar-2 --delay 0.05 --bandwidth 200", &["runs away", "lower its bandwidth"]);
    refused("--arm planar-2 -o model.json", &["read by this command"]);
    refused("--arm planar-2 --plot plot.png", &["expected .svg"]);
    let line = "control model.json --arm planar-2 --trajectory sines --period 1";
    terminal.misused(line, &["--period", "are of periodic motion"]);
}
