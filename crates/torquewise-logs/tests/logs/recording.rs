//! Several files are one recording, and what does not belong together is refused.
use crate::{Files, seen};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use std::ops::Range;
use std::path::PathBuf;
use torquewise_logs::{ConditionedLogs, LogError, Logs};
use torquewise_motion::signals::Cutoff;
use torquewise_motion::{Conditioning, Motion, Recording, Repairs};

const ONE_JOINT: &str = "t,q1,dq1,ddq1,tau1\n0,1,2,3,4\n0.1,1,2,3,4\n";

#[test]
fn each_file_and_each_part_between_gaps_is_a_trajectory() {
    let files = Files::new();
    let gap = "t,q1,dq1,ddq1\n0,1,0,0\n1,1,0,0\n2,1,0,0\n3,1,0,0\n9,1,0,0\n10,1,0,0\n";
    let logs = Logs::open(&[files.add("a.csv", gap), files.add("b.csv", ONE_JOINT)]).unwrap();

    assert_eq!(logs.file_of(0), None, "nothing was read yet");
    let rows = seen(&logs, |number, block| (number, block.n_rows(), block.tau().is_some()));
    let whole: Vec<_> = logs.read_all().unwrap().iter().map(|part| part.t().to_vec()).collect();

    assert_eq!(rows, [(0, 4, false), (1, 2, false), (2, 2, true)]);
    assert_eq!(whole, [vec![0.0, 1.0, 2.0, 3.0], vec![9.0, 10.0], vec![0.0, 0.1]]);
    let files = [0, 1, 2].map(|trajectory| logs.file_of(trajectory).unwrap().to_owned());
    assert_eq!(files, [&logs.paths()[0], &logs.paths()[0], &logs.paths()[1]].map(Clone::clone));
}

#[test]
fn trajectories_too_short_to_filter_leave_the_others_their_numbers() {
    let files = Files::new();
    let swing = |rows: std::ops::Range<i32>| -> String {
        let row = |k: i32| format!("{:?},{:?}\n", 0.01 * f64::from(k), (0.02 * f64::from(k)).sin());
        rows.map(row).collect()
    };
    let a = files.add("a.csv", &format!("t,q1\n{}{}", swing(0..2_000), swing(3_000..3_010)));
    let b = files.add("b.csv", &format!("t,q1\n{}", swing(0..2_000)));
    let logs = Logs::open(&[a, b.clone()]).unwrap();
    let conditioned = ConditionedLogs::new(logs, &Conditioning::default()).unwrap();

    let mut numbers = seen(&conditioned, |trajectory, _| trajectory);

    numbers.dedup();
    assert_eq!(numbers, [0, 2]);
    let a = Repairs { too_short: 10, splits: 1, ..Repairs::default() };
    assert_eq!(conditioned.repairs(), [("a".to_owned(), a)].into());
    assert_eq!(conditioned.logs.file_of(2), Some(b.as_path()));
}

#[test]
fn repairs_are_those_of_each_log_in_any_order_and_one_reading_of_one_log_is_enough() {
    let files = Files::new();
    let spoilt = noisy_swing(4_000, 0..0).lines().fold(String::new(), |text, line| {
        let spike = line.starts_with("20.0,").then_some("20.0,0.0,500.0");
        text + spike.unwrap_or(line) + "\n" + if spike.is_some() { "20.0,0.0,1.0\n" } else { "" }
    });
    let sound = files.add("sound.csv", &noisy_swing(4_000, 0..0));
    let spoilt = files.add("spoilt.csv", &spoilt);
    let open = |paths: [&PathBuf; 2]| {
        let logs = Logs::open(&paths.map(Clone::clone)).unwrap();
        ConditionedLogs::new(logs, &Conditioning::default()).unwrap()
    };
    let (logs, other) = (open([&sound, &spoilt]), open([&spoilt, &sound]));

    logs.read(&mut |_, _| Ok(())).unwrap();
    other.read_log(0, &mut |_, _| Ok(())).unwrap();

    let repairs = &logs.repairs()["spoilt"];
    assert_eq!((repairs.repeated_stamps, repairs.spikes["tau"]), (1, 1));
    assert_eq!(logs.repairs().len(), 1);
    assert_eq!(logs.repairs(), other.repairs());
}

#[test]
fn missing_signals_and_ignored_columns_are_told() {
    let files = Files::new();
    let full = files.add("a.csv", "t,q1,dq1,ddq1,tau1,mode,force\n0,1,2,3,4,auto,7\n");
    let bare = files.add("b.csv", "t,q1,force,alarm\n0,1,2,no\n");

    let both = Logs::open(&[full.clone(), bare.clone()]).unwrap();
    let one = Logs::open(std::slice::from_ref(&full)).unwrap();

    assert_eq!((both.has_dq(), both.has_ddq(), both.has_tau()), (false, false, false));
    assert_eq!((one.has_dq(), one.has_ddq(), one.has_tau()), (true, true, true));
    assert_eq!(both.ignored_columns(), ["alarm", "force", "mode"]);
    assert_eq!(both.paths(), [full, bare.clone()]);
    assert!(one.require_tau().is_ok());
    assert!(matches!(both.require_tau(), Err(LogError::NoTorque { file }) if file == bare));
}

#[test]
fn accelerations_that_do_not_follow_are_left_out_and_derived() {
    let files = Files::new();
    let rows = |ddq: f64| -> String {
        let row = |k: i32| {
            let t = 0.01 * f64::from(k);
            format!("{t},{},{},{},{}\n", t.sin(), t.cos(), -ddq * t.sin(), 0.5 * t)
        };
        "t,q1,dq1,ddq1,tau1\n".to_owned() + &(0..2_000).map(row).collect::<String>()
    };
    let odd = Logs::open(&[files.add("odd.csv", &rows(-1.0))]).unwrap();
    let sound = Logs::open(&[files.add("sound.csv", &rows(1.0))]).unwrap();

    let read = |logs: &Logs| logs.read_all().unwrap().remove(0);
    let (derived, recorded) = (read(&odd), read(&sound));

    assert_eq!((odd.has_dq(), odd.has_ddq(), odd.has_tau()), (true, false, true));
    assert!(sound.has_ddq() && sound.unit_doubts().is_empty());
    assert!(odd.unit_doubts()[0].contains("do not follow"), "{:?}", odd.unit_doubts());
    assert_eq!(derived.tau(), recorded.tau());
    let apart = derived.ddq() - recorded.ddq();
    assert!(apart.submatrix(5, 0, 1_990, 1).norm_max() < 1e-3);
}

#[test]
fn one_named_file_names_the_joints_of_all() {
    let files = Files::new();
    let plain = files.add("a.csv", ONE_JOINT);
    let named = files.add("b.csv", &format!("# joints: hip\n{ONE_JOINT}"));
    let other = files.add("c.csv", &format!("# joints: knee\n{ONE_JOINT}"));

    let unnamed = Logs::open(std::slice::from_ref(&plain)).unwrap();
    let agreed = Logs::open(&[plain.clone(), named.clone()]).unwrap();
    let refused = Logs::open(&[plain, named, other]).unwrap_err();

    assert_eq!(unnamed.joints(), ["joint1"]);
    assert_eq!(agreed.joints(), ["hip"]);
    assert_eq!(agreed.read_all().unwrap()[0].joints(), ["hip"]);
    assert!(refused.to_string().contains("c.csv names its joints knee, "), "{refused}");
}

#[test]
fn files_that_cannot_be_opened_or_do_not_belong_together_are_refused() {
    let files = Files::new();
    let missing = files.0.path().join("missing.csv");
    let bag = files.add("bag.mcap", "");
    let named = files.add("named.csv", "# joints: hip\nt,q1,q2\n0,1,2\n");
    let twice = files.add("twice.csv", "# joints: hip, hip\nt,q1,q2\n0,1,2\n");
    let one = files.add("a.csv", ONE_JOINT);
    let two = files.add("b.csv", "t,q1,q2\n0,1,2\n");
    let folder = files.0.path().join("folder.csv");
    std::fs::create_dir(&folder).unwrap();

    assert!(matches!(Logs::open(&[]), Err(LogError::NoFiles)));
    assert!(matches!(Logs::open(&[missing]), Err(LogError::Read { .. })));
    assert!(matches!(Logs::open(&[bag]), Err(LogError::Empty { .. })));
    assert!(matches!(Logs::open(&[folder]), Err(LogError::EmptyFolder { .. })));
    assert!(matches!(Logs::open(&[twice]), Err(LogError::JointName { .. })));
    let refused = Logs::open(&[named]);
    assert!(matches!(refused, Err(LogError::JointNameCount { found: 1, expected: 2, .. })));
    let refused = Logs::open(&[one, two]);
    assert!(matches!(refused, Err(LogError::JointCount { found: 2, expected: 1, .. })));
}

#[test]
fn a_folder_stands_for_the_files_of_its_bag_in_the_order_of_their_numbers() {
    let files = Files::new();
    let folder = files.0.path().join("run");
    std::fs::create_dir(&folder).unwrap();
    for name in ["run_10.mcap", "run_2.mcap", "metadata.yaml", "run_0.mcap"] {
        std::fs::write(folder.join(name), "").unwrap();
    }

    // Empty files are refused, the first of the bag first.
    match Logs::open(&[folder]) {
        Err(LogError::Empty { file }) => assert!(file.ends_with("run_0.mcap"), "{file:?}"),
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_file_whose_header_changed_is_not_read_on() {
    let files = Files::new();
    let logs = Logs::open(&[files.add("a.csv", ONE_JOINT)]).unwrap();

    files.add("a.csv", "t,q1,q2\n0,1,2\n");

    assert!(matches!(logs.read_all(), Err(LogError::Changed { .. })));
}

#[test]
fn reading_stops_with_the_first_error_of_the_visitor() {
    let files = Files::new();
    let file = files.add("a.csv", ONE_JOINT);
    let logs = Logs::open(&[file.clone(), file]).unwrap();

    let mut visits = 0;
    let stopped = logs.read(&mut |_, _| {
        visits += 1;
        Err("enough".into())
    });

    assert_eq!((visits, stopped.unwrap_err().to_string().as_str()), (1, "enough"));
}

/// A joint that swings, with white noise of 1e-3 in its position and another torque in some rows; no
/// velocities.
fn noisy_swing(rows: usize, other: Range<usize>) -> String {
    let unit = ChaCha8Rng::seed_from_u64(1).sample_iter(StandardNormal);
    let row = |(k, noise): (usize, f64)| {
        let t = 0.01 * k as f64;
        let tau = t.cos() + if other.contains(&k) { 0.1 } else { 0.0 };
        format!("{t:?},{:?},{tau:?}\n", (2.0 * t).sin() + 1e-3 * noise)
    };
    format!("t,q1,tau1\n{}", (0..rows).zip(unit).map(row).collect::<String>())
}

fn rows_and_noise(logs: &ConditionedLogs, log: usize, seed: u64) -> [Vec<[f64; 4]>; 2] {
    let mut found = [Vec::new(), Vec::new()];
    let row = |m: &Motion, k: usize| [m.t()[k], m.q()[(k, 0)], m.dq()[(k, 0)], m.ddq()[(k, 0)]];
    let can = logs.read_log_with_noise(log, seed, &mut |_, motion, noise| {
        for k in 0..motion.n_rows() {
            found[0].push(row(motion, k));
            found[1].push(row(noise, k));
        }
        Ok(())
    });
    assert!(can.unwrap());
    found
}

#[test]
fn noise_of_raw_samples_goes_where_their_rows_go() {
    let files = Files::new();
    // Longer than what a plan is made from, and shorter.
    let long = files.add("a.csv", &noisy_swing(70_000, 0..0));
    let short = files.add("b.csv", &noisy_swing(5_000, 0..0));
    let other = files.add("c.csv", &noisy_swing(5_000, 2_500..2_510));
    let open = |paths: &[PathBuf]| {
        let settings = Conditioning { cutoff: Cutoff::Hz(3.0), ..Conditioning::default() };
        ConditionedLogs::new(Logs::open(paths).unwrap(), &settings).unwrap()
    };
    let logs = open(&[long, short.clone()]);

    for log in 0..2 {
        let [rows, noise] = rows_and_noise(&logs, log, 7);
        let mut plain = Vec::new();
        let read = logs.read_log(log, &mut |_, motion| {
            plain.extend((0..motion.n_rows()).map(|k| [motion.t()[k], motion.ddq()[(k, 0)]]));
            Ok(())
        });
        read.unwrap();
        assert_eq!(rows.iter().map(|row| [row[0], row[3]]).collect::<Vec<_>>(), plain);
        let times = |rows: &[[f64; 4]]| rows.iter().map(|row| row[0].to_bits()).collect::<Vec<_>>();
        assert_eq!(times(&rows), times(&noise));
        // The derivatives of the rows err as those of the noise: both went through one filter.
        let rms = |of: &dyn Fn(usize) -> f64| {
            ((0..rows.len()).map(|k| of(k).powi(2)).sum::<f64>() / rows.len() as f64).sqrt()
        };
        let error = |k: usize| rows[k][3] + 4.0 * (2.0 * rows[k][0]).sin();
        let [wrong, drawn] = [rms(&error), rms(&|k| noise[k][3])];
        assert!((0.8..1.25).contains(&(wrong / drawn)), "log {log}: {wrong} and {drawn}");
    }
    // The same noise wherever the log stands, another with another seed.
    let [_, noise] = rows_and_noise(&logs, 1, 7);
    assert_eq!(rows_and_noise(&open(std::slice::from_ref(&short)), 0, 7)[1].len(), noise.len());
    assert_ne!(rows_and_noise(&logs, 1, 8)[1], noise);
    assert_eq!(rows_and_noise(&logs, 1, 7)[1], noise);
    // From the middle on, where a log differs, its noise does; the filter carries that some way back.
    let logs = open(&[short, other]);
    let [own, others] = [0, 1].map(|log| rows_and_noise(&logs, log, 7)[1].clone());
    let bits = |row: &[f64; 4]| row.map(f64::to_bits);
    let alike = own.iter().zip(&others).take_while(|(a, b)| bits(a) == bits(b)).count();
    assert!((0.35..0.5).contains(&(alike as f64 / own.len() as f64)), "{alike}");
}
