//! Logs of real robots are read with their profiles to the numbers that other programs find.
//!
//! First and last rows, in `real_robots.csv`, were worked out with numpy 2, scipy 1 and rosbags 0.11 in Python.
#![expect(clippy::unwrap_used, reason = "a test stops where its ground gives way")]

use faer::MatRef;
use std::path::{Path, PathBuf};
use torquewise_logs::{Logs, Options, Profile, ReadReport};

/// The folder of real logs, or why the test is skipped.
fn shared() -> Option<PathBuf> {
    let default = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared");
    let folder = std::env::var_os("TORQUEWISE_SHARED").map_or(default.into(), PathBuf::from);
    let logs = folder.join("data");
    if logs.is_dir() {
        return Some(logs);
    }
    let required = std::env::var("TORQUEWISE_SHARED_REQUIRED").is_ok_and(|value| value == "1");
    assert!(!required, "{} does not exist", logs.display());
    println!("skipped: {} does not exist", logs.display());
    None
}

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
    let Some(folder) = shared() else { return };
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
fn profiles_say_the_same_after_they_were_written() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../profiles");
    let mut n_profiles = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let file = entry.unwrap().path();
        if file.extension().is_some_and(|extension| extension == "toml") {
            let read = Profile::read(&file).unwrap();
            assert_eq!(Profile::from_toml(&read.to_toml()).unwrap(), read, "{}", file.display());
            n_profiles += 1;
        }
    }
    assert_eq!(n_profiles, 8);
}

#[test]
fn bags_of_robots_need_no_profile() {
    let Some(folder) = shared() else { return };
    let bag = folder.join("ur10_panda_unisa/panda_exciting_trajectory.db3");

    let logs = Logs::open(&[bag]).unwrap();

    assert_eq!((logs.joints().len(), logs.joints()[6].as_str()), (7, "fer_joint7"));
    assert!(logs.has_dq() && logs.has_tau() && !logs.has_ddq());
    assert_eq!(logs.read_all().unwrap()[0].n_rows(), 727);
}

#[test]
fn a_raw_reading_has_the_rows_of_the_motion_and_derives_nothing() {
    let Some(folder) = shared() else { return };
    let file = folder.join("staubli_tx40_figaroh/pos_read_data.csv");
    let options = Options { profile: Some(profile("staubli_tx40.toml")), ..Options::default() };
    let logs = Logs::open_with(&[file], &options).unwrap();

    let (mut q, mut t, mut rows) = (Vec::new(), Vec::new(), Vec::new());
    logs.read_raw(&mut |trajectory, block| -> Result<(), torquewise_logs::LogError> {
        assert_eq!((trajectory, block.dq.is_none(), block.ddq.is_none()), (0, true, true));
        t.extend_from_slice(&block.t);
        q.extend((0..block.t.len()).map(|row| block.q[(row, 5)]));
        rows.push(block.t.len());
        Ok(())
    })
    .unwrap();

    let motion = &logs.read_all().unwrap()[0];
    assert_eq!(rows, [vec![1024; 36], vec![136]].concat());
    assert_eq!(motion.t(), t);
    assert!(motion.q().col(5).iter().eq(q.iter()));
}
