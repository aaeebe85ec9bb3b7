//! Logs of real robots are read with their profiles to the numbers that other programs find.
//!
//! First and last rows, in `real_robots.csv`, were worked out with numpy 2, scipy 1 and rosbags 0.11 in Python.

use crate::shared::shared;
use faer::MatRef;
use std::path::Path;
use torquewise_logs::{Logs, Options, Profile, ReadReport};
use torquewise_motion::Recording;

fn profile(name: &str) -> Profile {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../profiles");
    Profile::read(&folder.join(name)).unwrap()
}

/// Equal up to a few roundings of factors and sums.
fn close(found: MatRef<'_, f64>, row: usize, expected: &str, signal: &str) {
    let expected: Vec<f64> = expected.split(' ').map(|x| x.parse().unwrap()).collect();
    assert_eq!(found.ncols(), expected.len());
    let largest = expected.iter().fold(0.0, |largest: f64, x| largest.max(x.abs()));
    for (joint, expected) in expected.into_iter().enumerate() {
        let found = found[(row, joint)];
        let tolerance = 16.0 * f64::EPSILON * largest;
        assert!((found - expected).abs() <= tolerance, "{signal}{joint}: {found} {expected}");
    }
}

#[test]
fn first_and_last_rows_are_those_that_other_programs_find() {
    let Some(folder) = shared("data") else { return };
    for line in include_str!("real_robots.csv").lines().skip(1) {
        let fields: Vec<&str> = line.split(',').collect();
        let [log, name, joints, rows, row, t, q, dq, tau] = fields[..] else { panic!("{line}") };
        let [rows, row]: [usize; 2] = [rows, row].map(|number| number.parse().unwrap());
        let options = Options { profile: Some(profile(name)), ..Options::default() };

        let logs = Logs::open_with(&[folder.join(log)], &options).unwrap();
        let parts = logs.read_all().unwrap();

        assert_eq!((parts.len(), parts[0].n_rows()), (1, rows), "{log}");
        let report = ReadReport { rows: rows as u64, ..ReadReport::default() };
        assert_eq!(logs.report(), report, "{log}");
        assert!(logs.joints().iter().eq(joints.split(' ')), "{log}: {:?}", logs.joints());
        assert_eq!((logs.has_dq(), logs.has_ddq()), (!dq.is_empty(), false), "{log}");
        let motion = &parts[0];
        let t: f64 = t.parse().unwrap();
        assert!((motion.t()[row] - t).abs() <= 1e-12 * t.abs(), "{log}: {}", motion.t()[row]);
        close(motion.q(), row, q, "q");
        close(motion.require_tau().unwrap(), row, tau, "tau");
        if !dq.is_empty() {
            close(motion.dq(), row, dq, "dq");
        }
    }
}

#[test]
fn bags_of_robots_need_no_profile() {
    let Some(folder) = shared("data") else { return };
    let bag = folder.join("ur10_panda_unisa/panda_exciting_trajectory.db3");

    let logs = Logs::open(&[bag]).unwrap();

    assert_eq!((logs.joints().len(), logs.joints()[6].as_str()), (7, "fer_joint7"));
    assert!(logs.has_dq() && logs.has_tau() && !logs.has_ddq());
    assert_eq!(logs.read_all().unwrap()[0].n_rows(), 727);
}
