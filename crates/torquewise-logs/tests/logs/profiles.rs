//! Logs as robots write them: a profile turns their columns into signals in SI units.
use crate::{Files, file_of, with};
use std::f64::consts::PI;
use std::path::Path;
use tempfile::TempPath;
use torquewise_logs::{LogError, Logs, Options, Profile};
use torquewise_motion::{Motion, Raw, Signal};

/// A log of so many rows under a header; gone once it is dropped.
fn made(header: &str, rows: usize, row: impl Fn(usize) -> String) -> TempPath {
    file_of(".csv", text(header, rows, row).as_bytes())
}

fn text(header: &str, rows: usize, row: impl Fn(usize) -> String) -> String {
    let lines: String = (0..rows).map(|k| row(k) + "\n").collect();
    format!("{header}\n{lines}")
}

fn open(file: &Path, profile: &str) -> Result<Logs, LogError> {
    Logs::open_with(&[file.to_owned()], &with(profile))
}

fn read(file: &Path, profile: &str) -> Vec<Motion> {
    open(file, profile).unwrap().read_all().unwrap()
}

/// The blocks of all files as they were recorded, with their trajectories.
fn raw_blocks(logs: &Logs) -> Vec<(usize, Raw)> {
    let mut blocks = Vec::new();
    let read = logs.read_raw(None, &mut |trajectory, block| -> Result<(), LogError> {
        blocks.push((trajectory, block));
        Ok(())
    });
    read.unwrap();
    blocks
}

/// The message of an error and what to do.
fn refused(file: &Path, profile: &str) -> String {
    let error = open(file, profile).and_then(|logs| logs.read_all()).unwrap_err();
    let help = miette::Diagnostic::help(&error).map(|help| help.to_string());
    format!("{error}: {}", help.unwrap_or_default())
}

const EPSILON: f64 = 1e-12;

#[test]
fn units_scales_and_signs_are_applied_to_each_joint() {
    let header = "time, pos1, pos2 ,rpm1,rpm2,- i a,- i b";
    let log = made(header, 20, |k| format!("{k},{k},90,60,-30,2,3"));

    let motion = &read(&log, include_str!("units.toml"))[0];

    assert!((motion.t()[19] - 0.019).abs() < EPSILON);
    assert!((motion.q()[(18, 0)] - (18.0 * PI / 180.0 + 0.5)).abs() < EPSILON);
    assert!((motion.q()[(18, 1)] + PI).abs() < EPSILON);
    assert!((motion.dq()[(0, 0)] - 2.0 * PI).abs() < EPSILON);
    assert!((motion.dq()[(0, 1)] + PI).abs() < EPSILON);
    let tau = motion.require_tau().unwrap();
    assert!((tau[(0, 0)] - 11.0).abs() < EPSILON && (tau[(0, 1)] + 14.0).abs() < EPSILON);
}

#[test]
fn a_coupled_wrist_is_uncoupled_and_its_torque_transposed() {
    // q_motor = R q with R = [[45, 0], [32, 32]], so tau = Rᵀ y.
    let (q5, q6) = (|k: usize| 0.01 * k as f64, |k: usize| 0.3 - 0.02 * k as f64);
    let log = made("t,m1,m2,y1,y2", 20, |k| {
        let motors = (45.0 * q5(k), 32.0 * q5(k) + 32.0 * q6(k));
        format!("{},{:?},{:?},2,3", k, motors.0, motors.1)
    });
    let profile = r#"
        q = { columns = "m", scale = [0.022222222222222223, 0.03125], matrix = [[1, 0], [-1, 1]] }
        tau = { columns = "y", gear = [45, 32], matrix = [[1, 1], [0, 1]] }
    "#;

    let motion = &read(&log, profile)[0];

    for row in 0..20 {
        assert!((motion.q()[(row, 0)] - q5(row)).abs() < EPSILON);
        assert!((motion.q()[(row, 1)] - q6(row)).abs() < EPSILON);
        let tau = motion.require_tau().unwrap();
        assert!((tau[(row, 0)] - (45.0 * 2.0 + 32.0 * 3.0)).abs() < EPSILON);
        assert!((tau[(row, 1)] - 96.0).abs() < EPSILON);
    }
}

#[test]
fn a_joint_that_is_left_out_still_counts_in_couplings() {
    let log = made("t,m1,m2", 20, |k| format!("{k},1,{k}"));
    let profile = r#"
        joints = ["base", "tip"]
        leave_out = ["base"]
        q = { columns = "m", matrix = [[1, 0], [10, 1]] }
    "#;

    let motion = &read(&log, profile)[0];

    assert_eq!((motion.joints(), motion.q()[(7, 0)]), (&["tip".to_owned()][..], 17.0));
}

#[test]
fn a_file_without_a_clock_takes_the_rate_which_a_profile_may_say_alone() {
    let log = made("Joint_1", 40, |k| k.to_string());

    let motion = &read(&log, "rate = 1000.0\nrows = [[11, 40]]\nq = { columns = \"Joint_\" }")[0];
    let without = refused(&log, "q = { columns = \"Joint_\" }");

    assert_eq!((motion.n_rows(), motion.t()[0], motion.q()[(0, 0)]), (30, 0.01, 10.0));
    assert!(without.contains("has no clock, found Joint_1") && without.contains("rate = …"));
    let log = file_of(".csv", b"q1,q2,tau1,tau2\n0,1,2,3\n1,2,3,4\n");

    let logs = open(&log, "rate = 250.0").unwrap();

    assert!(logs.has_tau() && !logs.has_dq());
    let stamps: Vec<f64> = raw_blocks(&logs).into_iter().flat_map(|(_, block)| block.t).collect();
    assert_eq!(stamps, [0.0, 0.004]);
}

#[test]
fn ranges_are_trajectories() {
    let log = made("t,q1", 100, |k| format!("{:?},{k}", 5.0 + 0.1 * k as f64));
    let firsts = |profile: &str| -> Vec<(usize, f64)> {
        read(&log, profile).iter().map(|part| (part.n_rows(), part.q()[(0, 0)])).collect()
    };

    let q = "q = { columns = \"q\" }";
    assert_eq!(firsts(&format!("rows = [[11, 30], [31, 50]]\n{q}")), [(20, 10.0), (20, 30.0)]);
    let seconds = format!("seconds = [[1.95, 4.01], [6.0, 99.0]]\n{q}");
    assert_eq!(firsts(&seconds), [(21, 20.0), (40, 60.0)]);
    let none = refused(&log, &format!("rows = [[500, 600]]\n{q}"));
    assert!(none.contains("none of its 100 rows is left"), "{none}");
}

#[test]
fn files_beside_a_log_give_columns_and_have_the_same_rows_and_clock() {
    let files = Files::new();
    let log = files.add("pos.csv", &text("t,a", 30, |k| format!("0.{k:02},{k}")));
    files.add("cur.csv", &text("t,a", 30, |k| format!("0.{k:02},{}", 2 * k)));
    files.add("short.csv", &text("a", 28, |k| k.to_string()));
    files.add("late.csv", &text("t,a", 30, |k| format!("0.{:02},0", if k == 9 { 10 } else { k })));
    let profile = |name: &str| {
        format!(
            "beside = {{ c = \"{name}\" }}\nt = {{ column = \"t\" }}\nq = {{ columns = [\"a\"] }}\n\
             tau = {{ columns = [\"c.a\"], scale = 0.5 }}"
        )
    };

    let motion = &read(&log, &profile("cur.csv"))[0];
    let short = refused(&log, &profile("short.csv"));
    let late = refused(&log, &profile("late.csv"));
    let unused = refused(&log, "beside = { c = \"cur.csv\" }\nq = { columns = [\"a\"] }");
    let missing = refused(&log, &profile("none.csv"));

    assert_eq!((motion.q()[(9, 0)], motion.require_tau().unwrap()[(9, 0)]), (9.0, 9.0));
    assert!(short.contains("short.csv has 28 rows") && short.contains("pos.csv has 30"), "{short}");
    assert!(late.contains("late.csv, row 10 (line 11): column t is 0.1 s"), "{late}");
    assert!(unused.contains("no column of it is used"), "{unused}");
    assert!(missing.contains("none.csv cannot be read"), "{missing}");
}

#[test]
fn repeated_stamps_and_holes_are_dropped_with_a_profile_and_counted() {
    let log = made("t,q1", 60, |k| match k {
        10 => "0.09,10".into(),
        11 => "0.02,11".into(),
        20 => "0.20,nan".into(),
        30..37 => format!("0.{k},inf"),
        _ => format!("{:?},{k}", k as f64 / 100.0),
    });

    let logs = open(&log, "q = { columns = \"q\" }").unwrap();
    let parts = logs.read_all().unwrap();
    let strict = Logs::open(&[log.to_path_buf()]).unwrap().read_all();
    let repair = Options { repair: true, ..Options::default() };
    let repaired = Logs::open_with(&[log.to_path_buf()], &repair).unwrap();

    // Seven lost rows in a row are a gap.
    assert_eq!(parts.iter().map(Motion::n_rows).collect::<Vec<_>>(), [27, 23]);
    let report = logs.report();
    let repairs = &report.repairs;
    assert_eq!((report.rows, repairs.repeated_stamps, repairs.not_finite), (50, 1, 8));
    assert_eq!(repairs.earlier_stamps, 1);
    assert_eq!(logs.first(|own| own.first_back), Some((&*log, 12)));
    assert!(matches!(strict, Err(LogError::NotFinite { .. } | LogError::TimeOrder { .. })));
    assert_eq!(repaired.read_all().unwrap().len(), 2);
    assert_eq!(repaired.report(), report);
}

#[test]
fn a_stamp_that_is_astray_and_a_last_line_that_is_cut_off_are_left_out_alone() {
    let log = made("t,q1", 60, |k| match k {
        0 => "5000,0".into(),
        30 => "3.3,30".into(),
        _ => format!("{:?},{k}", k as f64 / 100.0),
    });

    let logs = open(&log, "q = { columns = \"q\" }").unwrap();
    let rows: usize = logs.read_all().unwrap().iter().map(Motion::n_rows).sum();

    let repairs = logs.report().repairs;
    assert_eq!((rows, repairs.absurd, repairs.earlier_stamps), (58, 2, 0));
    let first = logs.first(|own| own.first_absurd.clone()).unwrap().1;
    assert_eq!(first, (1, "t".to_owned(), 5000.0));
    std::fs::write(&*log, "t,q1\n0,1\n0.1,2\n0.2,3\n0.3,4\n0.4,5\n0.5").unwrap();
    let logs = open(&log, "q = { columns = \"q\" }").unwrap();
    assert_eq!(logs.read_all().unwrap()[0].n_rows(), 5);
}

#[test]
fn a_raw_reading_keeps_missing_signals_missing_and_cuts_at_gaps() {
    let log = made("t,q1,tau1", 2_100, |k| {
        let jitter = 1e-3 * ((k * k) % 7) as f64;
        format!("{:?},{k},{}", 0.01 * k as f64 + jitter + f64::from(k >= 2_000), -(k as f64))
    });
    let logs = Logs::open(&[log.to_path_buf()]).unwrap();

    let blocks = raw_blocks(&logs);

    let cuts: Vec<_> = blocks.iter().map(|(part, block)| (*part, block.t.len())).collect();
    assert_eq!(cuts, [(0, 1024), (0, 976), (1, 100)]);
    let last = &blocks[2].1;
    assert_eq!(last.signals.each_ref().map(Option::is_some), [true, false, false, true]);
    assert_eq!((last.of(Signal::Q)[0][99], last.of(Signal::Tau)[0][99]), (2_099.0, -2_099.0));
    assert_eq!(logs.report().rows, 2_100);
}

#[test]
fn columns_that_are_not_there_are_named_with_what_there_is() {
    let log = file_of(".csv", b"t, pos1, pos2, pos1\n0,1,2,3\n");

    let missing = refused(&log, "q = { columns = [\"pos2\", \"pos3\"] }");
    let twice = refused(&log, "q = { columns = \"pos\" }");
    let nothing = refused(&log, "rate = 5.0");
    let count =
        refused(&log, "joints = [\"a\"]\nq = { columns = [\"pos2\"] }\nleave_out = [\"a\"]");

    let expected = "no column pos3, which q.columns of the profile needs, found t, pos1, pos2";
    assert!(missing.contains(expected), "{missing}");
    assert!(twice.contains("two columns pos1"), "{twice}");
    assert!(nothing.contains("q.columns"), "{nothing}");
    assert!(count.contains("leaves out all joints"), "{count}");
}

#[test]
fn clocks_that_count_from_a_date_count_from_the_first_row() {
    let nanoseconds = |k: usize| 1_700_000_000_000_000_000_u64 + 4_000_000 * k as u64;
    let log = made("stamp,q1", 20, |k| format!("{},{k}", nanoseconds(k)));

    let t = "t = { column = \"stamp\", unit = \"ns\" }\nq = { columns = \"q\" }";
    let motion = &read(&log, t)[0];

    // A double holds such a stamp to 256 ns.
    assert!((0..20).all(|k| (motion.t()[k] - 0.004 * k as f64).abs() < 3e-7));
}

#[test]
fn profiles_that_are_built_in_are_found_by_name_and_files_that_are_wrong_are_named() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../profiles");

    for entry in std::fs::read_dir(folder).unwrap() {
        let file = entry.unwrap().path();
        let name = file.file_stem().unwrap();
        if name != "README" {
            assert_eq!(Profile::read(name.as_ref()).unwrap(), Profile::read(&file).unwrap());
        }
    }
    let refused = Profile::read("ur11".as_ref()).unwrap_err().to_string();
    assert!(refused.starts_with("ur11: no such file"), "{refused}");
    assert!(refused.contains("delan_character, ") && refused.ends_with("ur10"), "{refused}");
    let files = Files::new();
    let file = files.add("arm.toml", "robot = \"x\"\n\n[q]\ncolumn = \"pos\"\n");

    let refused = Profile::read(&file).unwrap_err().to_string();

    assert!(refused.contains("arm.toml, line 4: unknown field `column`"), "{refused}");
    assert!(matches!(Profile::read(&file.join("no")), Err(LogError::Read { .. })));
}
