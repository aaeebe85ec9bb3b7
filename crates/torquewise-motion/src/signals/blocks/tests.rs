//! Block by block is as the whole.

use super::*;
use crate::Signal;
use crate::signals::condition;
use crate::signals::plan::{Conditioning, Cutoff};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// A long noisy log of two joints with some spikes.
fn log(n: usize, jitter: f64) -> Raw {
    let mut rng = ChaCha8Rng::seed_from_u64(31);
    let t: Vec<f64> =
        (0..n).map(|k| 5.0 + 0.01 * (k as f64 + jitter * rng.random_range(-1.0..1.0))).collect();
    let rates = [1.0, 1.7];
    let mut noise = |sigma: f64| sigma * rng.random_range(-1.0..1.0);
    let q = rates.map(|w| t.iter().map(|t| 2.0 + (w * t).sin() + noise(1e-3)).collect());
    let tau = rates.map(|w| {
        let spike = |row| if row % 9973 == 50 { 60.0 } else { 0.0 };
        let torque = |(row, t): (usize, &f64)| 30.0 + 9.0 * (w * t).sin() + noise(0.1) + spike(row);
        t.iter().enumerate().map(torque).collect()
    });
    let joints = vec!["a".to_owned(), "b".to_owned()];
    Raw { joints, t, signals: [Some(q.into()), None, None, Some(tau.into())] }
}

fn rows(raw: &Raw, begin: usize, end: usize) -> Raw {
    raw.select(&(begin..end.min(raw.t.len())).collect::<Vec<_>>())
}

#[test]
fn blocks_give_what_the_whole_gives() {
    for (jitter, cutoff) in [(0.0, 2.0), (0.3, 5.0)] {
        let raw = log(90_000, jitter);
        let cutoff = Cutoff::Hz(cutoff);
        let settings = Conditioning { cutoff, delay: 0.013, ..Default::default() };
        let whole = condition(&raw, &settings).unwrap().motion;

        let mut conditioner = Conditioner::new(SignalPlan::new(&raw, &settings).unwrap());
        let mut parts = Vec::new();
        for begin in (0..90_000).step_by(7001) {
            parts.extend(conditioner.push(rows(&raw, begin, begin + 7001)).unwrap());
        }
        parts.extend(conditioner.finish().unwrap());

        assert!(parts.len() >= 3);
        assert_eq!((conditioner.repairs.spikes["tau"], conditioner.repairs.gaps), (2 * 10, 0));
        let joined = Motion::joined(&raw.joints, &parts).unwrap();
        assert_eq!(joined.n_rows(), whole.n_rows());
        let [found, expected] = [&joined, &whole]
            .map(|motion| [motion.q(), motion.dq(), motion.ddq(), motion.tau().unwrap()]);
        for row in 0..whole.n_rows() {
            assert!((joined.t()[row] - whole.t()[row]).abs() < 1e-9);
            for (found, expected) in found.iter().zip(&expected) {
                for (found, expected) in found.row(row).iter().zip(expected.row(row).iter()) {
                    let error = (found - expected).abs();
                    assert!(error < 1e-9 * expected.abs().max(1.0), "row {row}: {error:e}");
                }
            }
        }
    }
}

#[test]
fn gaps_are_counted_wherever_blocks_are_cut() {
    let raw = log(3_000, 0.3);
    let [before, middle, after] =
        [(0, 1_000), (1_002, 2_000), (2_005, 3_000)].map(|(begin, end)| rows(&raw, begin, end));
    let settings = Conditioning { cutoff: Cutoff::Hz(5.0), ..Default::default() };
    let mut conditioner = Conditioner::new(SignalPlan::new(&before, &settings).unwrap());

    for block in [&before, &middle, &after] {
        conditioner.push(block.clone()).unwrap();
    }

    assert_eq!(conditioner.repairs.gaps, 2);
    let longest = conditioner.repairs.longest_gap;
    assert!((longest - (after.t[0] - middle.t[997])).abs() < 1e-12, "{longest}");
}

#[test]
fn blocks_that_do_not_follow_are_refused() {
    let raw = log(1000, 0.0);
    let settings = Conditioning { cutoff: Cutoff::Hz(5.0), ..Default::default() };
    let mut conditioner = Conditioner::new(SignalPlan::new(&raw, &settings).unwrap());
    conditioner.push(rows(&raw, 0, 500)).unwrap();

    let repeated = conditioner.push(rows(&raw, 499, 600));
    let mut no_tau = rows(&raw, 500, 600);
    no_tau.signals[Signal::Tau as usize] = None;
    let no_tau = conditioner.push(no_tau);
    let joints = vec!["x".into(), "y".into()];
    let stranger = conditioner.push(Raw { joints, ..rows(&raw, 500, 600) });

    assert_eq!(repeated.unwrap_err(), MotionError::TimeOrder { row: 500 });
    assert_eq!(no_tau.unwrap_err(), MotionError::Block);
    assert_eq!(stranger.unwrap_err(), MotionError::Block);
}
