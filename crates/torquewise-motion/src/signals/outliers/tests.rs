//! Spikes are found and taken out, motion and friction are left alone.

use super::*;
use crate::signals::noise::tests::gaussian;
use std::f64::consts::PI;

fn times(n: usize) -> Vec<f64> {
    (0..n).map(|k| k as f64 * 0.01).collect()
}

/// Torque of a joint in multi-sine motion: inertia, gravity, and friction that jumps.
fn torque(t: f64) -> f64 {
    let dq = (2.0 * PI * 0.4 * t).sin() + 0.7 * (2.0 * PI * 1.1 * t).cos();
    let sine = 8.0 * (2.0 * PI * 0.4 * t).cos() + 5.0 * (2.0 * PI * 3.1 * t).sin();
    sine + 6.0 * dq.signum()
}

#[test]
fn friction_that_steps_peaks_of_fast_sines_ramps_and_pulses_are_left_alone() {
    let sine = |hz: f64| times(2000).iter().map(|t| (2.0 * PI * hz * t).sin()).collect();
    let steps = times(3000).iter().map(|t| torque(*t)).collect();
    let quantised_ramp = (0..4000).map(|k| (f64::from(k) * 0.013).round() * 0.01).collect();
    let encoder_at_rest = (0..400).map(|k| if k % 40 == 0 { 1e-4 } else { 0.0 }).collect();
    let mut pulse_of_four_rows = vec![0.0; 200];
    pulse_of_four_rows[100..104].fill(1.0);
    let mut cases: Vec<(Vec<f64>, Option<f64>)> =
        vec![(steps, None), (quantised_ramp, None), (encoder_at_rest, None)];
    cases.push((pulse_of_four_rows, Some(1e-3)));
    cases.extend([0.3, 2.0, 9.0, 17.0, 31.0].map(|hz| (sine(hz), None)));
    for (case, (clean, scale)) in cases.into_iter().enumerate() {
        let mut x = clean.clone();
        let scale = scale.unwrap_or_else(|| spike_scale(&clean));

        let rows = replace_outliers(&times(x.len()), &mut x, scale);

        assert_eq!(rows, [0; 0], "case {case}");
        assert_eq!(x, clean, "case {case}");
    }
}

#[test]
fn spikes_of_one_to_three_rows_are_removed() {
    let t = times(3000);
    let noise = gaussian(3000, 0.05, 5);
    let clean: Vec<f64> = t.iter().zip(noise).map(|(t, noise)| torque(*t) + noise).collect();
    let mut x = clean.clone();
    // In the middle of smooth parts, found by hand.
    let places = [(405, 1), (906, 2), (1440, 3), (2207, 1)];
    for (row, length) in places {
        x[row..row + length].iter_mut().for_each(|x| *x += 17.0);
    }

    let scale = spike_scale(&x);
    let rows = replace_outliers(&t, &mut x, scale);

    let expected: Vec<usize> = places.iter().flat_map(|&(row, length)| row..row + length).collect();
    assert_eq!(rows, expected);
    for row in rows {
        assert!((x[row] - clean[row]).abs() < 1.0, "row {row}");
    }
}

#[test]
fn white_noise_is_no_spike() {
    let mut x = gaussian(20_000, 1.0, 9);

    let scale = spike_scale(&x);
    let rows = replace_outliers(&times(20_000), &mut x, scale);

    // Six deviations and more: 4e-5 rows of 20 000 if the deviation were known exactly.
    assert!(rows.len() <= 2, "{rows:?}");
}
