//! Noise and quantisation put into a signal are found again.

use super::*;
use approx::assert_relative_eq;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

pub(crate) fn gaussian(n: usize, sigma: f64, seed: u64) -> Vec<f64> {
    let unit = ChaCha8Rng::seed_from_u64(seed).sample_iter(StandardNormal);
    unit.take(n).map(|x: f64| sigma * x).collect()
}

#[test]
fn noise_on_a_motion_is_found() {
    let noise = gaussian(4000, 1e-3, 11);
    let x: Vec<f64> = (0..4000).map(|k| (0.01 * f64::from(k)).sin()).collect();
    let x: Vec<f64> = x.iter().zip(&noise).map(|(x, e)| x + e).collect();

    let found = white_noise(&x, &vec![false; 4000]);

    assert_relative_eq!(found, 1e-3, max_relative = 0.08);
}

#[test]
fn jumps_of_a_signal_without_noise_are_none() {
    let smooth = |k: u32| 10.0 * (0.01 * f64::from(k)).sin();
    let x: Vec<f64> = (0..4000).map(|k| smooth(k) + f64::from(k / 100 % 2)).collect();

    assert!(white_noise(&x, &vec![false; 4000]) < 1e-7);
    // Of an encoder that stands on one step the few that it takes are all that is seen.
    let steps: Vec<f64> = (0..4000).map(|k| f64::from(k / 100)).collect();
    assert!(white_noise(&steps, &vec![false; 4000]) > 0.01);
}

#[test]
fn noise_is_taken_from_standstill_where_there_is_some() {
    let noise = gaussian(4000, 1.0, 11);
    let x: Vec<f64> = (0..4000).map(|k| if k < 2000 { 0.1 } else { 1.0 } * noise[k]).collect();
    let dq: Vec<f64> = (0..4000).map(|k| if k < 2000 { 0.001 } else { 0.5 }).collect();

    let still = standstill(&dq);
    let found = white_noise(&x, &still);

    assert_eq!(still.iter().filter(|still| **still).count(), 2000);
    assert_relative_eq!(found, 0.1, max_relative = 0.08);
}

#[test]
fn the_steps_of_an_encoder_and_of_a_current_are_found() {
    let step = 2.0 * std::f64::consts::PI / 16384.0;
    let encoder: Vec<f64> =
        (0..3000).map(|k| ((0.01 * f64::from(k)).sin() / step).round() * step).collect();
    let current: Vec<f64> = (0..500).map(|k| f64::from((k * 5) % 7) * 0.01 - 0.03).collect();
    let never_alone: Vec<f64> =
        (0..200).map(|k| 0.1 * f64::from([0, 2, 5, 9, 12][k % 5])).collect();

    let [encoder, current, never_alone] =
        [encoder, current, never_alone].map(|x| quantisation(&x).unwrap());

    assert_relative_eq!(encoder.step, step, max_relative = 1e-6);
    assert!((encoder.levels - 2.0 / step).abs() < 2.0);
    assert_relative_eq!(current.step, 0.01, max_relative = 1e-9);
    assert_relative_eq!(current.levels, 7.0);
    assert_relative_eq!(current.share_of_deviation, 0.5, max_relative = 0.01);
    assert_relative_eq!(never_alone.step, 0.1, max_relative = 1e-9);
}

#[test]
fn a_continuous_signal_has_no_step() {
    assert_eq!(quantisation(&gaussian(2000, 1.0, 11)), None);
    assert_eq!(quantisation(&[0.3; 50]), None);
    assert_eq!(quantisation(&[]), None);
}
