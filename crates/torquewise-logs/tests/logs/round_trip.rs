//! What is written is read back to the same bits, in either format.

use crate::file_of;
use faer::Mat;
use proptest::prelude::*;
use std::path::Path;
use torquewise_logs::{Column, LogError, Logs, TableWriter, Values, write_motion};
use torquewise_motion::{Motion, Signals};

const FORMATS: [&str; 2] = ["log.csv", "log.parquet"];

/// A motion of `rows` rows 1 ms apart with the given values, in order.
fn motion(joints: &[&str], rows: usize, values: &[f64], with_tau: bool) -> Motion {
    let n = joints.len();
    let signal = |offset: usize| {
        Mat::from_fn(rows, n, |row, joint| values[(offset + row * n + joint) % values.len()])
    };
    let joints = joints.iter().map(|name| (*name).to_owned()).collect();
    let t = (0..rows).map(|row| 1e-3 * row as f64).collect();
    let ([q, dq, ddq], tau) = ([0, 1, 2].map(signal), with_tau.then(|| signal(3)));
    Motion::new(Signals { joints, t, q, dq, ddq, tau }).unwrap()
}

fn bits(motion: &Motion) -> Vec<u64> {
    let signals = [Some(motion.q()), Some(motion.dq()), Some(motion.ddq()), motion.tau()];
    let columns = signals.into_iter().flatten().flat_map(|signal| {
        signal.col_iter().flat_map(|column| column.iter().copied().collect::<Vec<_>>())
    });
    motion.t().iter().copied().chain(columns).map(f64::to_bits).collect()
}

fn read_back(file: &Path) -> Vec<Motion> {
    Logs::open(&[file.to_owned()]).unwrap().read_all().unwrap()
}

#[test]
fn a_long_motion_comes_back_whole() {
    let folder = tempfile::tempdir().unwrap();
    let values: Vec<f64> = (0..997).map(|k| (f64::from(k) * 0.731).sin() * 1e3).collect();
    let written = motion(&["shoulder pan", "łokieć"], 40_000, &values, true);
    let files = FORMATS.map(|name| folder.path().join(name));

    for file in &files {
        write_motion(file, &written).unwrap();
    }

    for file in &files {
        let read = read_back(file);
        assert_eq!((read.len(), read[0].joints()), (1, written.joints()));
        assert_eq!(bits(&read[0]), bits(&written));
    }
}

#[test]
fn a_motion_without_torque_cannot_fill_a_log_with_torque() {
    let without = motion(&["a"], 10, &[1.0], false);
    let file = file_of(".csv", b"");

    let mut writer = TableWriter::log(&file, without.joints(), true).unwrap();
    let refused = writer.append_motion(&without).unwrap_err().to_string();
    write_motion(&file, &without).unwrap();

    assert!(refused.ends_with("4 columns of values for a table of 5"), "{refused}");
    assert!(read_back(&file)[0].tau().is_none());
    let csv = std::fs::read_to_string(file).unwrap();
    assert_eq!(csv.lines().nth(1), Some("t,q1,dq1,ddq1"));
}

#[test]
fn a_csv_table_holds_shortest_numbers_and_quoted_text() {
    let file = file_of(".csv", b"");
    let columns = [
        Column::new("row", Values::Counts(&[])),
        Column::new("pattern", Values::Texts(&[])),
        Column::new("tau1", Values::Numbers(&[])),
    ];

    let mut table = TableWriter::create(&file, &columns).unwrap();
    let texts = ["uniform, \"slow\"", "standstill"];
    let values = [Values::Counts(&[1, u64::MAX]), Values::Texts(&texts)];
    table.append(&[values[0], values[1], Values::Numbers(&[0.1, -1e-300])]).unwrap();
    table.append(&[Values::Counts(&[]), Values::Texts(&[]), Values::Numbers(&[])]).unwrap();
    table.finish().unwrap();

    let expected = "row,pattern,tau1\n1,\"uniform, \"\"slow\"\"\",0.1\n\
                    18446744073709551615,standstill,-1e-300\n";
    assert_eq!(std::fs::read_to_string(file).unwrap(), expected);
}

#[test]
fn values_that_do_not_fit_the_columns_are_refused_and_a_folder_that_does_not_exist_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let (numbers, counts, none) =
        (Values::Numbers(&[1.0]), Values::Counts(&[1]), Values::Numbers(&[]));
    for name in FORMATS {
        let columns = ["a", "b"].map(|name| Column::new(name, Values::Numbers(&[])));
        let mut table = TableWriter::create(&folder.path().join(name), &columns).unwrap();
        for (values, problem) in [
            (&[numbers][..], "1 columns of values for a table of 2"),
            (&[numbers, counts], "column b is to hold numbers, but counts is given"),
            (&[numbers, none], "column b has 0 values, the first 1"),
        ] {
            let refused = table.append(values).unwrap_err().to_string();
            assert!(refused.ends_with(&format!("{name}: {problem}")), "{refused}");
        }
    }
    for name in FORMATS {
        let file = folder.path().join("missing").join(name);
        let refused = TableWriter::create(&file, &[]).err().unwrap();

        assert!(matches!(&refused, LogError::Write { .. }), "{refused}");
        assert!(refused.to_string().contains("missing"));
    }
}

#[cfg(unix)]
#[test]
fn an_output_is_as_readable_as_any_new_file() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().unwrap();
    let (plain, log) = (folder.path().join("plain"), folder.path().join("log.csv"));

    std::fs::write(&plain, "").unwrap();
    write_motion(&log, &motion(&["a"], 3, &[1.0], true)).unwrap();

    let mode = |file| std::fs::metadata(file).unwrap().permissions().mode();
    assert_eq!(mode(log), mode(plain));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn any_finite_motion_comes_back_to_the_same_bits(
        bit_patterns in proptest::collection::vec(any::<u64>(), 1..60),
        rows in 1_usize..40,
        with_tau in any::<bool>(),
    ) {
        let finite = |bits: u64| Some(f64::from_bits(bits)).filter(|x| x.is_finite());
        let mut values: Vec<f64> = bit_patterns.into_iter().filter_map(finite).collect();
        values.push(-0.0);
        let written = motion(&["hip", "knee"], rows, &values, with_tau);
        let folder = tempfile::tempdir().unwrap();
        for name in FORMATS {
            let file = folder.path().join(name);

            write_motion(&file, &written).unwrap();

            prop_assert_eq!(bits(&read_back(&file)[0]), bits(&written));
        }
    }
}
