//! Cut-offs that leave noise, or cut the motion, beside one that does neither.

use super::choose_cutoff;
use faer::Mat;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use torquewise_dynamics::{Arm, MotionKind, MotionPlan, simulate};
use torquewise_motion::{Motion, Signals};

/// Two joints for a minute, noise in the torque.
fn log() -> Motion {
    let plan = MotionPlan { kind: MotionKind::Sines, seconds: 60.0, rate: 50.0, seed: 4 };
    let clean = simulate(&Arm::builtin("planar-2").unwrap(), &plan).unwrap().motion;
    changed(&clean, |signals, random| noisy(&mut signals.tau, 0.05, random))
}

fn changed(motion: &Motion, change: impl Fn(&mut Signals, &mut ChaCha8Rng)) -> Motion {
    let mut signals = motion.clone().into_signals();
    change(&mut signals, &mut ChaCha8Rng::seed_from_u64(7));
    Motion::new(signals).unwrap()
}

fn noisy(tau: &mut Option<Mat<f64>>, part: f64, random: &mut ChaCha8Rng) {
    let tau = tau.as_mut().unwrap();
    *tau = with_noise(tau, part, random);
}

fn with_noise(x: &Mat<f64>, part: f64, random: &mut ChaCha8Rng) -> Mat<f64> {
    let size = part * x.norm_l2() / (x.nrows() as f64 * x.ncols() as f64).sqrt();
    Mat::from_fn(x.nrows(), x.ncols(), |row, joint| {
        let noise: f64 = StandardNormal.sample(random);
        x[(row, joint)] + size * noise
    })
}

/// Moving mean over `reach` rows to each side: a filter that cuts the motion.
fn smeared(x: &Mat<f64>, reach: usize) -> Mat<f64> {
    Mat::from_fn(x.nrows(), x.ncols(), |row, joint| {
        let rows = row.saturating_sub(reach)..(row + reach + 1).min(x.nrows());
        let count = rows.len() as f64;
        rows.map(|row| x[(row, joint)]).sum::<f64>() / count
    })
}

#[test]
fn a_filter_that_leaves_noise_in_the_motion_gives_way() {
    let clean = log();
    let loud = changed(&clean, |signals, random| {
        signals.dq = with_noise(&signals.dq, 0.3, random);
        signals.ddq = with_noise(&signals.ddq, 3.0, random);
    });

    let (place, choice) = choose_cutoff(&[(8.0, loud), (4.0, clean)]).unwrap();

    assert_eq!((place, choice.chosen.as_str()), (1, "4.00 Hz"));
    assert!(choice.from[0].error > 1.5 * choice.from[1].error, "{choice:?}");
}

#[test]
fn a_filter_does_not_win_by_leaving_less_to_predict() {
    let clean = log();
    // 0.6 s, where the fastest part of the motion takes about a second to and fro.
    let blunt = changed(&clean, |signals, _| {
        for x in [&mut signals.q, &mut signals.dq, &mut signals.ddq] {
            *x = smeared(x, 15);
        }
        signals.tau = signals.tau.as_ref().map(|tau| smeared(tau, 15));
    });

    let (place, choice) = choose_cutoff(&[(4.0, clean), (1.0, blunt)]).unwrap();

    assert_eq!(place, 0, "{choice:?}");
}

#[test]
fn alike_the_first_stays() {
    let clean = log();

    let (place, choice) = choose_cutoff(&[(4.0, clean.clone()), (2.0, clean)]).unwrap();

    assert_eq!(place, 0);
    assert_eq!(choice.from.len(), 2);
}

#[test]
fn a_log_of_few_periods_tells_nothing() {
    let clean = log();
    let short = clean.select(&(0..100).collect::<Vec<_>>());

    assert_eq!(choose_cutoff(&[(4.0, short.clone()), (2.0, short)]), None);
    assert_eq!(choose_cutoff(&[]), None);
}
