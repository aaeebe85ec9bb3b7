//! Recordings planned: files, limits and words.

use crate::terminal::{Terminal, assert_says, each, numbers};

/// Two joints of a URDF: one from −1 to 2 rad at 1.5 rad/s, one without end at 2 rad/s.
const URDF: &str = include_str!("two.urdf");

const QUICK: &str = "--standstill 15 --uniform 40 --variable 30 --tries 3 --rate 50";

#[test]
fn recordings_are_written_as_logs_and_as_trajectories_with_a_figure() {
    let terminal = Terminal::holding("two.urdf", URDF);

    let text = terminal.done(&format!("excite two.urdf -o plan {QUICK}"));

    let words = ["shoulder", "elbow", "Collisions are not checked", "condition", "random"];
    assert_says(&text, &words);
    for name in ["standstill", "uniform", "variable"] {
        let log = terminal.read(&format!("plan/{name}.csv"));
        assert!(log.starts_with("# joints: shoulder,elbow\nt,q1,q2,dq1,dq2,ddq1,ddq2\n0.0,"));
        let trajectory = terminal.read(&format!("plan/{name}.yaml"));
        assert!(trajectory.contains("joint_names: [\"shoulder\", \"elbow\"]\npoints:\n"));
    }
    let svg = terminal.read("plan/excite.svg");
    assert!(svg.starts_with("<svg") && svg.contains("shoulder") && svg.contains("dq [rad/s]"));
    let files = std::fs::read_dir(terminal.path("plan")).unwrap().count();
    assert_eq!(files, 7, "nothing is left over");
}

#[test]
fn limits_of_the_file_are_kept_and_reported() {
    let terminal = Terminal::holding("two.urdf", URDF);

    let line = format!("excite two.urdf -o plan {QUICK} --range elbow=-0.5:1 --slow-sweeps");
    let found = terminal.json(&format!("{line} --max-acceleration 3,4"));

    let joints = found["joints"].as_array().unwrap();
    assert_eq!(numbers(&joints[0]["limit"]["position"]), [-1.0, 2.0]);
    assert_eq!(numbers(&joints[1]["planned"]["position"]), [-0.5, 1.0]);
    let planned = [(-0.85, 1.85, 0.75, 3.0), (-0.5, 1.0, 1.0, 4.0)];
    for (joint, (lower, upper, velocity, acceleration)) in joints.iter().zip(planned) {
        let peak = &joint["peak"];
        let position = numbers(&peak["position"]);
        assert!(position[0] >= lower - 1e-12 && position[1] <= upper + 1e-12, "{joint}");
        assert!(peak["velocity"].as_f64().unwrap() <= velocity + 1e-12, "{joint}");
        assert!(peak["acceleration"].as_f64().unwrap() <= acceleration + 1e-12, "{joint}");
    }
    let seconds = each(&found["recordings"], "seconds");
    assert!(seconds.iter().zip([15.0, 40.0, 30.0]).all(|(own, most)| *own <= most), "{seconds:?}");
    let all = &found["criteria"][2];
    let information = |plan: &str| all[plan]["information"].as_f64().unwrap();
    assert!(information("planned") > information("random"), "{all}");
}

#[test]
fn what_cannot_be_planned_is_refused_and_leaves_no_folder() {
    let terminal = Terminal::holding("two.urdf", URDF);
    terminal.write("file", "");

    let cases = [
        ("excite two.urdf -o plan --range wrist=0:1", &["wrist", "shoulder, elbow"][..]),
        ("excite two.urdf -o plan --range 3:4", &["shoulder", "lower < upper"]),
        ("excite two.urdf -o plan --home 0,9", &["home of joint `elbow`", "9.0 rad"]),
        ("excite two.urdf -o plan --max-velocity 0", &["velocity of joint `shoulder`"]),
        ("excite two.urdf -o plan --variable 1.5", &["`variable`", "more seconds"]),
        ("excite two.urdf -o plan --tries 0", &["number of tries"]),
        ("excite two.urdf -o plan --ros-rate 0 --tries 1", &["ROS rate"]),
        ("excite two.urdf -o file --tries 1", &["file is a file", "name a folder"]),
        ("excite unknown-9 -o plan", &["no arm is called"]),
    ];

    for (line, words) in cases {
        terminal.refused(line, words);
    }
    terminal.misused("excite two.urdf -o plan --range 1", &["expected -1.5:1.5"]);
}
