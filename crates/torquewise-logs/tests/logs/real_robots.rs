//! Logs of real robots are read with their profiles to the numbers that other programs find.
//!
//! First and last rows were worked out with numpy 2, scipy 1 and rosbags 0.11 in Python.
#![expect(clippy::unwrap_used, reason = "a test stops where its ground gives way")]

use faer::MatRef;
use std::path::{Path, PathBuf};
use torquewise_logs::{Logs, Options, Profile, ReadReport};
use torquewise_motion::Motion;

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

/// One of the rows of a log as another program prints it.
struct Witness {
    row: usize,
    t: &'static str,
    q: &'static str,
    dq: Option<&'static str>,
    tau: &'static str,
}

/// Reads a log with its profile; `rows` is the number of rows expected.
fn read(log: &str, name: &str, rows: usize) -> Option<(Motion, Logs)> {
    let file = shared()?.join(log);
    let options = Options { profile: Some(profile(name)), ..Options::default() };
    let logs = Logs::open_with(&[file], &options).unwrap();
    let parts = logs.read_all().unwrap();
    assert_eq!((parts.len(), parts[0].n_rows()), (1, rows), "{log}");
    let report = ReadReport { rows: rows as u64, ..ReadReport::default() };
    assert_eq!(logs.report(), report, "{log}");
    Some((parts[0].clone(), logs))
}

fn assert_row(motion: &Motion, expected: &Witness) {
    let Witness { row, t, q, dq, tau } = *expected;
    let t: f64 = t.parse().unwrap();
    assert!((motion.t()[row] - t).abs() <= 1e-12 * t.abs(), "{}", motion.t()[row]);
    close(motion.q(), row, q, "q");
    close(motion.require_tau().unwrap(), row, tau, "tau");
    if let Some(dq) = dq {
        close(motion.dq(), row, dq, "dq");
    }
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
fn the_double_pendulum_is_read_as_it_stands() {
    let Some((motion, logs)) = read(
        "dfki_double_pendulum/A0_20220812/20220812-061157-PM_measured.csv",
        "dfki_double_pendulum.toml",
        21969,
    ) else {
        return;
    };

    assert_eq!(logs.joints(), ["shoulder", "elbow"]);
    assert_eq!((logs.has_dq(), logs.has_ddq()), (true, false));
    assert_row(
        &motion,
        &Witness {
            row: 0,
            t: "0.0",
            q: "0.0001907377737087046 0.0001907377737087046",
            dq: Some("0.1043956043956058 0.0384615384615401"),
            tau: "0.006896821084527716 0.007706485981486821",
        },
    );
    assert_row(
        &motion,
        &Witness {
            row: 21968,
            t: "74.9886085987091",
            q: "-0.005912870984969842 -0.006294346532387252",
            dq: Some("0.1703296703296715 -0.02747252747252915"),
            tau: "0.10315586217554756 0.10925237807644049",
        },
    );
}

#[test]
fn the_simple_pendulum_is_read_as_it_stands_ddp() {
    let Some((motion, logs)) =
        read("dfki_simple_pendulum/ddp.csv", "dfki_simple_pendulum.toml", 3000)
    else {
        return;
    };

    assert_eq!(logs.joints(), ["pivot"]);
    assert_eq!((logs.has_dq(), logs.has_ddq()), (true, false));
    assert_row(
        &motion,
        &Witness {
            row: 0,
            t: "0.0",
            q: "-0.0014572365911362795",
            dq: Some("0.120879120879124"),
            tau: "-0.00439560439560438",
        },
    );
    assert_row(
        &motion,
        &Witness {
            row: 2999,
            t: "5.999162435531616",
            q: "3.1228580148012526",
            dq: Some("-0.010989010989014503"),
            tau: "-0.8219780219780226",
        },
    );
}

#[test]
fn the_simple_pendulum_is_read_as_it_stands_direct_collocation() {
    let Some((motion, logs)) =
        read("dfki_simple_pendulum/direct_collocation.csv", "dfki_simple_pendulum.toml", 1170)
    else {
        return;
    };

    assert_eq!(logs.joints(), ["pivot"]);
    assert_eq!((logs.has_dq(), logs.has_ddq()), (true, false));
    assert_row(
        &motion,
        &Witness {
            row: 0,
            t: "0.0",
            q: "-0.0014572365911362795",
            dq: Some("-0.010989010989014503"),
            tau: "-0.00439560439560438",
        },
    );
    assert_row(
        &motion,
        &Witness {
            row: 1169,
            t: "3.507509469985962",
            q: "3.1403448538948595",
            dq: Some("0.2527472527472554"),
            tau: "-1.1472527472527467",
        },
    );
}

#[test]
fn tiago_is_read_from_three_files_with_the_signs_of_its_motors() {
    let Some((motion, logs)) = read("tiago_arm_figaroh/tiago_position.csv", "tiago_arm.toml", 8022)
    else {
        return;
    };

    assert_eq!(
        logs.joints(),
        [
            "arm_1_joint",
            "arm_2_joint",
            "arm_3_joint",
            "arm_4_joint",
            "arm_5_joint",
            "arm_6_joint",
            "arm_7_joint"
        ]
    );
    assert_eq!((logs.has_dq(), logs.has_ddq()), (true, false));
    assert_row(
        &motion,
        &Witness {
            row: 0,
            t: "0.0",
            q: "0.06999127460154318 0.042825847614689605 -0.029731817992299313 \
            0.005290374926751459 -3.981080735586742e-05 0.05007320606840884 \
            -3.981080735586742e-05",
            dq: Some(
                "5.667211488324872e-07 -6.160841877411023e-05 -2.715852180364284e-09 \
            -9.333929388322751e-07 -5.0293228134673995e-05 4.9564074118612915e-05 \
            -7.98199715538969e-05",
            ),
            tau: "0.43520000000000003 22.4944 -0.4872 -10.370399999999998 -0.0 -0.0 -0.0",
        },
    );
    assert_row(
        &motion,
        &Witness {
            row: 8021,
            t: "80.21092915534973",
            q: "1.2127147402169078 -0.5090464007707741 -1.6182666935081074 0.7056999532298394 \
            -2.000678975145638 0.35073611079639877 -0.302629339469311",
            dq: Some(
                "4.0514601944100324e-05 -1.6016906813821613e-12 -7.521628896442236e-05 \
            -2.1793487654417043e-13 2.220446049250313e-16 8.0422392457728e-06 \
            -7.15440743484668e-06",
            ),
            tau: "1.1560000000000001 18.523200000000003 -6.9861 4.5849 -0.0 -0.0 -0.0",
        },
    );
}

#[test]
fn tx40_is_read_through_its_coupled_wrist() {
    let Some((motion, logs)) =
        read("staubli_tx40_figaroh/pos_read_data.csv", "staubli_tx40.toml", 37000)
    else {
        return;
    };

    assert_eq!(logs.joints(), ["joint_1", "joint_2", "joint_3", "joint_4", "joint_5", "joint_6"]);
    assert_eq!((logs.has_dq(), logs.has_ddq()), (false, false));
    assert_row(
        &motion,
        &Witness {
            row: 0,
            t: "0.1",
            q: "0.00895625 -0.00739007679489645 0.007040771239340993 -0.008608749999999998 \
            -0.005707777777777779 -0.0022106597222222215",
            dq: None,
            tau: "46.9888 -54.4896 4.63995 -4.776864 -7.972799999999999 -3.408",
        },
    );
    assert_row(
        &motion,
        &Witness {
            row: 36999,
            t: "7.4998",
            q: "0.0002287 0.0007974232051033425 -0.0003592287606590805 0.00042543750000000003 \
            -0.0001874866666666667 0.0019042366666666667",
            dq: None,
            tau: "2.196224 -18.50336 0.48073499999999997 0.9257759999999999 -1.531557 0.757728",
        },
    );
}

#[test]
fn kuka_is_read_from_a_structure_in_a_mat_file() {
    let Some((motion, logs)) = read("kuka_kr300_weigand/A/data.mat", "kuka_kr300.toml", 2501)
    else {
        return;
    };

    assert_eq!(logs.joints(), ["axis_1", "axis_2", "axis_3", "axis_4", "axis_5", "axis_6"]);
    assert_eq!((logs.has_dq(), logs.has_ddq()), (true, false));
    assert_row(
        &motion,
        &Witness {
            row: 0,
            t: "0.0",
            q: "0.0010415950860379274 -1.5707217244411869 1.568996443727167 \
            2.7757716474276265e-05 0.00023046723645690076 4.18879009896865e-06",
            dq: Some(
                "7.778295673149106e-05 5.66617073245586e-07 -0.00041288725609982713 \
            2.703226627493059e-07 -0.0 0.0",
            ),
            tau: "538.9043641090393 -755.7303739275252 -4192.787315368652 -52.6713035851717 \
            -489.3814615522112 0.7405993786247781",
        },
    );
    assert_row(
        &motion,
        &Witness {
            row: 2500,
            t: "9.999999747378752",
            q: "-1.224854139491724e-05 -1.5707977614555448 1.5708255289968314 \
            -0.010060437364645505 0.031578812795354703 0.0008293804395957927",
            dq: Some(
                "0.0008991746181755932 2.56275975816445e-05 -0.001280121778594906 \
            -8.261238421832173e-48 3.033726721522037e-05 -1.5767172382088666e-49",
            ),
            tau: "468.14623815672735 -2014.4298869541715 -3313.446163495382 -156.7048842906952 \
            -447.47119145166306 -143.88088998852382",
        },
    );
}

#[test]
fn ur10_is_read_from_its_bag() {
    let Some((motion, logs)) =
        read("ur10_panda_unisa/ur10_exciting_trajectory.db3", "ur10.toml", 3441)
    else {
        return;
    };

    assert_eq!(
        logs.joints(),
        [
            "shoulder_pan_joint",
            "shoulder_lift_joint",
            "elbow_joint",
            "wrist_1_joint",
            "wrist_2_joint",
            "wrist_3_joint"
        ]
    );
    assert_eq!((logs.has_dq(), logs.has_ddq()), (true, false));
    assert_row(
        &motion,
        &Witness {
            row: 0,
            t: "1e-09",
            q: "0.6197782590517766 -1.8644074027477224 1.6688934532752913 -0.3185747950090945 \
            -2.468923739357186 1.962261149140957",
            dq: Some(
                "-0.016152065390291487 0.008382491419804995 -0.002544861908403722 \
            0.009410012932316553 -0.011947939914106184 -0.023015612427706337",
            ),
            tau: "8.322347795416437 -20.646947446880112 -39.55563608858807 -1.0571620681899736 \
            -1.1538389190790939 -0.7875644249428467",
        },
    );
    assert_row(
        &motion,
        &Witness {
            row: 3440,
            t: "27.52",
            q: "0.6211779145024402 -1.8651580721573338 1.6696249229414326 -0.3193102037948445 \
            -2.467355889155921 1.9648685616094526",
            dq: Some(
                "-0.018622341246552227 0.00955172827841739 -0.00976027756203021 \
            0.010783365218133667 -0.018425212982137416 -0.03530929979130404",
            ),
            tau: "-5.261924661241299 -7.916476264901311 -42.26723016505464 1.0736121496365947 \
            -1.4194950290502437 -3.1556049948955085",
        },
    );
}

#[test]
fn panda_is_read_from_its_bag() {
    let Some((motion, logs)) =
        read("ur10_panda_unisa/panda_exciting_trajectory.db3", "panda.toml", 727)
    else {
        return;
    };

    assert_eq!(
        logs.joints(),
        [
            "fer_joint1",
            "fer_joint2",
            "fer_joint3",
            "fer_joint4",
            "fer_joint5",
            "fer_joint6",
            "fer_joint7"
        ]
    );
    assert_eq!((logs.has_dq(), logs.has_ddq()), (true, false));
    assert_row(
        &motion,
        &Witness {
            row: 0,
            t: "0.0",
            q: "-2.253337627308282 -0.47053254440438064 0.7767469009354853 -1.7193451322128182 \
            -0.35167160234201894 1.5524626355414513 0.48545494110107656",
            dq: Some(
                "0.017081113644547275 -0.014614973241307672 0.037524881261957244 \
            -0.352524856940154 0.15973998312781176 -0.05473396938147172 \
            -0.01056752347079114",
            ),
            tau: "-5.21143913269043 2.8779072761535645 -7.107419013977051 5.976147651672363 \
            -0.02646435797214508 0.6853144764900208 0.060568127781152725",
        },
    );
    assert_row(
        &motion,
        &Witness {
            row: 726,
            t: "24.200059891",
            q: "-2.2551412926343577 -0.47149460059855847 0.7776372316607364 \
            -1.7132021467181653 -0.35708838992172354 1.5537790288034135 0.4837114540884157",
            dq: Some(
                "-0.005677525886659479 -0.004899195347531446 7.834255757389228e-05 \
            0.0021817169712731706 -0.0014176077127239853 1.8098970281157776e-06 \
            -0.00016666602069794118",
            ),
            tau: "-0.7918834686279297 -1.2441020011901855 -8.26586627960205 17.14008903503418 \
            -0.15463818609714508 1.5651363134384155 -0.21958324313163757",
        },
    );
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
