//! Clocks with known faults: each is found and mended, and a sound clock is left alone.

use super::{ClockLane, ClockRepair, Raw, Signal};
use crate::blocks::tests::even;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use torquewise_motion::Repairs;

const STEP: f64 = 0.01;

/// Rows stamped at `t`, sampled at `sampled`.
fn block(t: Vec<f64>, sampled: &[f64]) -> Raw {
    let q: Vec<f64> =
        sampled[..t.len()].iter().map(|t| (3.0 * t).sin() + 0.4 * (7.1 * t).cos()).collect();
    let tau = q.iter().map(|q| 2.0 * q).collect();
    let signals = [Some(vec![q]), None, None, Some(vec![tau])];
    Raw { joints: vec!["joint1".into()], t, signals }
}

/// Even times, each off by up to 0.4 steps.
fn jittery(rows: u32) -> Vec<f64> {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    even(rows).into_iter().map(|t| t + STEP * random.random_range(-0.4..0.4)).collect()
}

/// The block with its clock mended, handed over in parts, and what that repaired.
fn mended(block: &Raw, cuts: &[usize]) -> (Raw, Repairs) {
    let mut lane = ClockLane::new(ClockRepair::of(std::slice::from_ref(block)));
    let mut all = Raw::default();
    let ends = cuts.iter().copied().chain([block.t.len()]);
    let mut begin = 0;
    for end in ends {
        let rows: Vec<usize> = (begin..end).collect();
        lane.push(block.select(&rows)).into_iter().for_each(|part| all.append(part));
        begin = end;
    }
    lane.finish().into_iter().for_each(|part| all.append(part));
    (all, lane.repairs.clone())
}

#[test]
fn a_sound_clock_is_left_alone_and_that_of_an_arm_at_rest() {
    let t = jittery(3_000);
    let sound = block(t.clone(), &t);
    let still: Vec<f64> = even(3_000).into_iter().map(|t| t.clamp(10.0, 20.0)).collect();
    let at_rest = block(even(3_000), &still);

    assert_eq!(ClockRepair::of(std::slice::from_ref(&sound)), ClockRepair::default());
    let (whole, repairs) = mended(&sound, &[700, 1_900]);
    assert!(whole.t == t && repairs.is_none());
    assert_eq!(mended(&at_rest, &[]).0.t, at_rest.t);
}

#[test]
fn stamps_of_late_receipt_are_put_on_the_clock_of_the_device() {
    let late = block(jittery(3_000), &even(3_000));

    let (mended, repairs) = mended(&late, &[]);

    let off = |t: &[f64]| {
        let squares: f64 = t.iter().zip(even(3_000)).map(|(t, even)| (t - even).powi(2)).sum();
        (squares / 3_000.0).sqrt()
    };
    assert!(off(&mended.t) < 0.2 * off(&late.t), "{} {}", off(&mended.t), off(&late.t));
    assert_eq!((repairs.held_rows, repairs.late_stamps), (0, 3_000));
}

#[test]
fn rows_that_a_fast_logger_repeats_are_left_out_and_velocities_of_them_are_slopes() {
    // The device samples every second, or every tenth, time that the logger writes.
    for run in [2, 10] {
        let held: Vec<f64> = (0..3_000).map(|row: u32| STEP * f64::from(row - row % run)).collect();
        let mut log = block(even(3_000), &held);
        let q = log.of(Signal::Q)[0].clone();
        let step = |row: usize| (q[row] - q[row.saturating_sub(1)]) / STEP;
        log.signals[1] = Some(vec![(0..3_000).map(step).collect()]);

        let (mended, repairs) = mended(&log, &[]);

        let slopes = mended.of(Signal::Q)[0].windows(2).map(|q| (q[1] - q[0]) / STEP);
        let velocities = mended.of(Signal::Dq)[0][1..].iter().map(|dq| f64::from(run) * dq);
        assert!(slopes.zip(velocities).all(|(slope, dq)| (slope - dq).abs() < 1e-9));
        let kept = 3_000 / u64::from(run);
        assert_eq!((mended.t.len() as u64, repairs.held_rows), (kept, 3_000 - kept));
        assert!((mended.t[1] - mended.t[0] - f64::from(run) * STEP).abs() < 1e-12);
    }
}

#[test]
fn encoders_and_torques_of_few_levels_at_rest_are_no_held_rows() {
    let mut random = ChaCha8Rng::seed_from_u64(2);
    // Nine tenths of the time at rest, where noise flips the last bit of both now and then.
    let rest = |row: usize| (row % 1_000) as f64 / 1_000.0 > 0.1;
    let mut log = block(even(3_000), &even(3_000));
    let mut before = [0.0, 0.0];
    for row in 0..3_000 {
        let flips = [0, 1].map(|_| f64::from(u8::from(random.random_range(0.0..1.0) > 0.8)));
        for (k, quantum) in [(0, 1e-3), (3, 0.05)] {
            let x = &mut log.signals[k].as_mut().unwrap()[0][row];
            let at = usize::from(k > 0);
            before[at] = if rest(row) { before[at] } else { *x };
            *x = ((before[at] / quantum).round() + flips[at]) * quantum;
        }
    }

    assert_eq!(ClockRepair::of(&[log]).held, 0);
}

#[test]
fn dwells_of_an_arm_without_noise_are_no_held_rows() {
    // Forty strokes, with a dwell of 5 to 44 rows before each.
    let (mut sampled, mut now) = (Vec::new(), 0.0);
    for stroke in 0..40 {
        sampled.extend([now; 5].into_iter().chain(std::iter::repeat_n(now, stroke)));
        sampled.extend((0..60).map(|row| now + STEP * f64::from(row)));
        now += 60.0 * STEP;
    }
    let rows = u32::try_from(sampled.len()).unwrap();

    assert_eq!(ClockRepair::of(&[block(even(rows), &sampled)]).held, 0);
}

#[test]
fn where_blocks_are_cut_does_not_matter() {
    let late = block(jittery(5_000), &even(5_000));

    let [often, once] =
        [&[1_024, 2_048, 3_072, 4_096][..], &[4_096]].map(|cuts| mended(&late, cuts));
    assert_eq!((often.0.t, often.1), (once.0.t, once.1));
}
