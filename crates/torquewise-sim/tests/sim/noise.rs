//! Noise: as strong as asked, independent of order, and none where nothing moves.
use faer::{Mat, MatRef};
use std::sync::LazyLock;
use torquewise_motion::{Motion, Signals};
use torquewise_sim::{Arm, MotionPlan, Noise, SimError, add_noise, simulate};

static CLEAN: LazyLock<Motion> = LazyLock::new(|| {
    let arm = Arm::builtin("puma560-3").unwrap();
    simulate(&arm, &MotionPlan::default()).unwrap().motion
});

#[test]
fn measured_signal_to_noise_ratio_is_the_one_asked_for() {
    let noise = Noise::from_db(60.0, 40.0, 25.0).unwrap();

    let noisy = add_noise(&CLEAN, &noise, 3).unwrap();

    let signals: [fn(&Motion) -> MatRef<'_, f64>; 3] = [Motion::q, Motion::dq, Motion::ddq];
    for (signal, db) in signals.into_iter().zip([60.0, 40.0, 25.0]) {
        for joint in 0..3 {
            // 40 000 rows: σ² is known to 0.7 %, 0.03 dB; four times that never happens by chance.
            let (clean, noisy) = (signal(&CLEAN).col(joint), signal(&noisy).col(joint));
            let ratio = clean.squared_norm_l2() / (noisy - clean).squared_norm_l2();
            let found = 10.0 * ratio.log10();
            assert!((found - db).abs() < 0.12, "joint {joint}: {found} dB, asked {db} dB");
        }
    }
    assert_eq!((noisy.t(), noisy.tau()), (CLEAN.t(), CLEAN.tau()));
}

#[test]
fn noise_is_white_gaussian_and_centred() {
    let noisy = add_noise(&CLEAN, &Noise::case(3).unwrap(), 4).unwrap();

    let noise = noisy.dq().col(1) - CLEAN.dq().col(1);
    let m = noise.nrows() as f64;
    let sigma = (noise.squared_norm_l2() / m).sqrt();
    let mean = noise.iter().sum::<f64>() / m / sigma;
    let lag = (1..noise.nrows()).map(|k| noise[k] * noise[k - 1]).sum::<f64>() / m / sigma.powi(2);
    let kurtosis = noise.iter().map(|x| (x / sigma).powi(4)).sum::<f64>() / m;
    // Standard errors 0.005, 0.005 and 0.0245 for 40 000 rows.
    assert!(mean.abs() < 0.02 && lag.abs() < 0.02, "mean {mean}, neighbours {lag}");
    assert!((kurtosis - 3.0).abs() < 0.1, "kurtosis {kurtosis}");
}

#[test]
fn noises_of_two_signals_and_two_joints_are_independent() {
    let noisy = add_noise(&CLEAN, &Noise::from_db(40.0, 40.0, 40.0).unwrap(), 4).unwrap();

    let of = |signal: fn(&Motion) -> MatRef<'_, f64>, joint: usize| {
        signal(&noisy).col(joint) - signal(&CLEAN).col(joint)
    };
    let noises = [of(Motion::q, 0), of(Motion::q, 1), of(Motion::dq, 0), of(Motion::ddq, 0)];
    for (k, a) in noises.iter().enumerate() {
        for b in &noises[..k] {
            let correlation = (a.transpose() * b) / a.norm_l2() / b.norm_l2();
            assert!(correlation.abs() < 0.02, "{correlation}");
        }
    }
}

#[test]
fn the_cases_of_the_paper_are_its_ratios_and_the_first_leaves_every_bit_as_it_was() {
    let noisy = add_noise(&CLEAN, &Noise::case(1).unwrap(), 5).unwrap();

    assert_eq!((noisy.q(), noisy.dq(), noisy.ddq()), (CLEAN.q(), CLEAN.dq(), CLEAN.ddq()));
    assert_eq!(Noise::case(2).unwrap(), Noise::from_db(70.0, 50.0, 30.0).unwrap());
    assert_eq!(Noise::case(3).unwrap(), Noise::from_db(60.0, 40.0, 30.0).unwrap());
    let no_noise_on_q = Noise::from_db(f64::INFINITY, 62.5, 50.0).unwrap();
    let read = [Noise::CASES[0], Noise::CASES[2], no_noise_on_q].map(|noise| noise.to_string());
    assert_eq!(read, ["none", "60/40/30 dB", "–/62.5/50 dB"]);
}

#[test]
fn noise_of_a_joint_does_not_depend_on_the_other_joints() {
    let noise = Noise::case(3).unwrap();
    let first_two = |x: MatRef<'_, f64>| x.subcols(0, 2).to_owned();
    let mut signals = CLEAN.clone().into_signals();
    signals.joints.truncate(2);
    for x in [&mut signals.q, &mut signals.dq, &mut signals.ddq] {
        *x = first_two(x.as_ref());
    }
    let fewer = Motion::new(Signals { tau: None, ..signals }).unwrap();

    let [all, fewer] = [&CLEAN, &fewer].map(|motion| add_noise(motion, &noise, 6).unwrap());

    assert_eq!(first_two(all.q()), fewer.q());
    assert_eq!(first_two(all.ddq()), fewer.ddq());
    assert!(fewer.tau().is_none());
    assert_ne!(add_noise(&CLEAN, &noise, 7).unwrap().q(), all.q());
}

#[test]
fn a_joint_that_never_moves_gets_no_noise() {
    let mut signals = CLEAN.clone().into_signals();
    (signals.dq, signals.ddq) = (Mat::zeros(40_000, 3), Mat::zeros(40_000, 3));
    let still = Motion::new(signals).unwrap();

    let noisy = add_noise(&still, &Noise::case(3).unwrap(), 8).unwrap();

    assert_eq!((noisy.dq(), noisy.ddq()), (still.dq(), still.ddq()));
    assert_ne!(noisy.q(), still.q());
}

#[test]
fn levels_that_mean_nothing_are_refused() {
    let flood = Noise::from_db(-1e6, 0.0, 0.0).unwrap();

    assert!(matches!(Noise::case(4), Err(SimError::Setting { found: 4.0, .. })));
    let nan = Noise::from_db(60.0, f64::NAN, 30.0);
    assert!(matches!(nan, Err(SimError::Setting { what, .. }) if what.contains(" dq ")));
    assert!(Noise::from_db(f64::NEG_INFINITY, 40.0, 30.0).is_err());
    assert!(matches!(add_noise(&CLEAN, &flood, 1), Err(SimError::Motion(_))));
}
