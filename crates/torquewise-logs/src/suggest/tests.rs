//! Suggestions for logs made as robots write them.

use super::{Suggestion, suggest};
use crate::profile::Columns;
use crate::{Logs, Options, Profile};
use std::path::{Path, PathBuf};
use tempfile::TempDir;

fn write(file: &Path, header: &str, rows: u32, row: impl Fn(f64) -> Vec<f64>) {
    let line = |k| {
        let values: Vec<_> = row(f64::from(k)).iter().map(|value| format!("{value:?}")).collect();
        values.join(",") + "\n"
    };
    let lines: String = (0..rows).map(line).collect();
    std::fs::write(file, format!("{header}\n{lines}")).unwrap();
}

/// The same in a folder of its own.
fn log(name: &str, header: &str, rows: u32, row: impl Fn(f64) -> Vec<f64>) -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join(name);
    write(&file, header, rows, row);
    (folder, file)
}

/// A suggestion that must read the log it was made for.
fn readable(file: &Path) -> (Suggestion, Profile) {
    let suggestion = suggest(&[file.into()]).unwrap();
    assert!(suggestion.is_complete, "{suggestion:?}");
    let profile = Profile::from_toml(&suggestion.toml).unwrap();
    let options = Options { profile: Some(profile.clone()), ..Options::default() };
    Logs::open_with(&[file.to_owned()], &options).unwrap().read_all().unwrap();
    (suggestion, profile)
}

fn wave(t: f64) -> (f64, f64) {
    ((3.0 * t).sin(), 3.0 * (3.0 * t).cos())
}

#[test]
fn measured_columns_are_preferred_and_units_found() {
    let header =
        "time_ms, pos_des1,pos_des2,pos_meas1,pos_meas2,vel_meas1,vel_meas2,tau_meas1,tau_meas2";
    let (_folder, file) = log("run.csv", header, 800, |k| {
        let (q, dq) = wave(0.005 * k);
        let degrees = 60.0 * q;
        vec![5.0 * k, 0.0, 0.0, degrees, -degrees, 60.0 * dq, -60.0 * dq, 1.0, 2.0]
    });

    let (suggestion, profile) = readable(&file);

    assert_eq!(profile.t.unwrap().unit.as_deref(), Some("ms"));
    let q = profile.q.unwrap();
    assert_eq!(q.columns, Some(Columns::Prefix("pos_meas".into())));
    assert_eq!(q.unit.as_deref(), Some("deg"));
    assert_eq!(profile.dq.unwrap().unit.as_deref(), Some("deg/s"));
    assert_eq!(profile.tau.unwrap().columns, Some(Columns::Prefix("tau_meas".into())));
    let reasons = suggestion.reasons.join("\n");
    assert!(reasons.contains("200 rows per second"), "{reasons}");
    assert!(reasons.contains("Not taken, since others fit better: pos_des1"), "{reasons}");
}

#[test]
fn brackets_around_a_number_or_a_unit_hide_no_joint() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("run.csv");
    let indexed = ["position[1]", "position[2]", "effort[1]", "effort[2]"];
    let with_units = ["joint 1 angle [deg]", "joint 2 angle [deg]", "tau1 (N.m)", "tau2 (N.m)"];
    let signs = ["q1 [°]", "q2 [°]", "tau1 (measured)", "tau2 (measured)"];
    for (columns, degrees) in [(indexed, false), (with_units, true), (signs, true)] {
        let columns = columns.map(str::to_owned);
        let beside = columns.each_ref().map(|name| name.replace("measured", "desired"));
        let beside = if beside == columns { String::new() } else { beside[2..].join(",") + "," };
        write(&file, &format!("time,{beside}{}", columns.join(",")), 800, |k| {
            let (q, _) = wave(0.005 * k);
            let q = if degrees { 60.0 * q } else { q };
            let wanted = if beside.is_empty() { vec![] } else { vec![0.0, 0.0] };
            [vec![0.005 * k], wanted, vec![q, -q, 1.0, 2.0]].concat()
        });

        let (_, profile) = readable(&file);

        let listed = |k: usize| Some(Columns::Names(columns[k..k + 2].to_vec()));
        let (q, tau) = (profile.q.unwrap(), profile.tau.unwrap());
        assert_eq!((q.columns, tau.columns), (listed(0), listed(2)));
        assert_eq!(q.unit.as_deref() == Some("deg"), degrees);
    }
}

#[test]
fn velocity_in_another_unit_than_position_is_told_by_slopes() {
    let units = [(1.0, "rad/s"), (180.0 / std::f64::consts::PI, "deg/s"), (9.549_3, "rpm")];
    for (factor, unit) in units {
        let (_folder, file) = log("run.csv", "t,q0,q1,dq0,dq1", 500, |k| {
            let (q, dq) = wave(0.01 * k);
            vec![0.01 * k, q, 2.0 * q, factor * dq, 2.0 * factor * dq]
        });

        let (_, profile) = readable(&file);

        assert_eq!(profile.dq.unwrap().unit.as_deref(), Some(unit));
        // Counted from 0: a list, for a prefix counts from 1.
        let names = Columns::Names(vec!["q0".into(), "q1".into()]);
        assert_eq!(profile.q.unwrap().columns, Some(names));
    }
}

#[test]
fn joints_named_within_columns_are_found_and_columns_that_mean_nothing_give_a_draft() {
    for header in ["t,- hip_joint_position,- knee_joint_position", "t,q_hip_joint,q_knee_joint"] {
        let (_folder, file) = log("arm.csv", header, 100, |k| vec![0.01 * k, wave(k).0, 1.0]);

        let (_, profile) = readable(&file);

        assert_eq!(profile.joints, ["hip_joint", "knee_joint"], "{header}");
        assert!(profile.dq.is_none() && profile.tau.is_none());
    }
    let (_folder, file) = log("x.csv", "alpha,\"be\"\"ta\"", 10, |k| vec![k, k]);

    let suggestion = suggest(&[(&file).into()]).unwrap();

    assert!(!suggestion.is_complete && suggestion.toml.contains("# columns = [\"…\"]"));
}

#[test]
fn dots_make_a_derivative_of_a_position_and_torque_may_be_the_end_of_a_word() {
    let header = "t,q_ddot1,q_dot1,q_filtered1,qd_dot1,motorcurrent1,jointtorque1";
    let (_folder, file) = log("run.csv", header, 500, |k| {
        let (q, dq) = wave(0.01 * k);
        vec![0.01 * k, -9.0 * q, dq, q, dq, 1.0, k]
    });

    let toml = readable(&file).0.toml;

    let named = ["q_filtered", "q_dot", "q_ddot", "jointtorque"].map(|name| format!("\"{name}\""));
    let found: Vec<_> = toml.lines().filter_map(|line| line.strip_prefix("columns = ")).collect();
    assert_eq!(found, named, "{toml}");
    assert!(toml.contains("joints = [\"joint1\"]"), "{toml}");
    let (_folder, file) = log("run.csv", "t,d_d_q_1,d_q_1,q_1,tau_1", 500, |k| {
        let (q, dq) = wave(0.01 * k);
        vec![0.01 * k, -9.0 * q, dq, q, k]
    });
    let toml = readable(&file).0.toml;
    let places = ["[q]", "\"q_", "[dq]", "\"d_q_", "[ddq]", "\"d_d_q_"].map(|part| toml.find(part));
    assert!(places.is_sorted() && places[0].is_some(), "{toml}");
}

#[test]
fn what_no_file_tells_is_left_to_be_filled_in() {
    let header = "pos1,pos2,current1,current2";
    let (_folder, file) = log("run.csv", header, 100, |k| vec![k, 50.0, 2.0, 2.0]);

    let suggestion = suggest(&[(&file).into()]).unwrap();

    assert!(!suggestion.is_complete);
    for line in [
        "# rate = 1000.0",
        "columns = \"current\"",
        "# unit = \"A\"",
        "# torque_constant = [1.0, 1.0] # N·m/A, sign included",
    ] {
        assert!(suggestion.toml.lines().any(|found| found == line), "{}", suggestion.toml);
    }
    assert!(suggestion.reasons.iter().any(|reason| reason.contains("radians of the motors")));
}

#[test]
fn files_beside_a_log_are_measured_and_numbered_and_may_hold_its_clock() {
    let folder = tempfile::tempdir().unwrap();
    let of = |name: &str| folder.path().join(name);
    for sub in ["a", "b"] {
        std::fs::create_dir(of(sub)).unwrap();
    }
    write(&of("log.csv"), "torque1", 400, |_| vec![1.0]);
    write(&of("clock.csv"), "t", 400, |k| vec![0.005 * k]);
    write(&of("a/more.csv"), "position1", 400, |k| vec![60.0 * wave(0.005 * k).0]);
    write(&of("b/more.csv"), "velocity1", 400, |k| vec![wave(0.005 * k).1]);

    let files = ["log.csv", "clock.csv", "a/more.csv", "b/more.csv"].map(|name| of(name).into());
    let profile = Profile::from_toml(&suggest(&files).unwrap().toml).unwrap();

    assert_eq!(profile.beside.keys().collect::<Vec<_>>(), ["clock", "more", "more_2"]);
    assert_eq!(profile.t.unwrap().column, "clock.t");
    assert_eq!(profile.q.unwrap().unit.as_deref(), Some("deg"));
    // Measured against the slopes of positions in another file.
    assert_eq!(profile.dq.unwrap().unit.as_deref(), Some("rad/s"));
}
