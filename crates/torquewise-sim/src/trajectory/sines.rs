//! A sum of sines per joint, with exact derivatives.

use crate::{State, between};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::{PI, TAU};

/// Sines per joint, each in its own band of frequencies.
const BANDS: usize = 5;
/// Lowest and highest frequency \[Hz\].
const FREQUENCY: [f64; 2] = [0.05, 0.8];
/// Speed \[rad/s\] and acceleration \[rad/s²\] that no joint exceeds.
const BOUND: [f64; 2] = [2.0, 6.0];
/// Slow sines get larger amplitudes, by ω to this power, so that the joints cross their range.
const ROLL_OFF: f64 = 1.3;

/// Middle \[rad\] and sines of each joint.
#[derive(Clone, Debug)]
pub(crate) struct Sines(Vec<(f64, Vec<Sine>)>);

#[derive(Clone, Copy, Debug)]
struct Sine {
    amplitude: f64,
    w: f64,
    phase: f64,
}

impl Sines {
    /// Draws sines for each joint, as large as range, speed and acceleration allow.
    pub(crate) fn draw(ranges: &[[f64; 2]], rng: &mut ChaCha8Rng) -> Self {
        let band_width = (FREQUENCY[1] / FREQUENCY[0]).ln() / BANDS as f64;
        let draw_joint = |&[lower, upper]: &[f64; 2]| {
            let mut sines = Vec::with_capacity(BANDS);
            for band in 0..BANDS {
                let octave = (band as f64 + between(rng, [0.0, 1.0])) * band_width;
                let w = TAU * FREQUENCY[0] * octave.exp();
                let phase = between(rng, [-PI, PI]);
                let amplitude = between(rng, [0.5, 1.0]) / w.powf(ROLL_OFF);
                sines.push(Sine { amplitude, w, phase });
            }
            let most = |order| sines.iter().map(|s| s.amplitude * s.w.powi(order)).sum::<f64>();
            let bounds = [(upper - lower) / 2.0 / most(0), BOUND[0] / most(1), BOUND[1] / most(2)];
            let scale = bounds.into_iter().fold(f64::INFINITY, f64::min);
            for sine in &mut sines {
                sine.amplitude *= scale;
            }
            (f64::midpoint(lower, upper), sines)
        };
        Self(ranges.iter().map(draw_joint).collect())
    }

    pub(crate) fn state_at(&self, t: f64) -> State {
        State::of_joints(self.0.iter().map(|(middle, sines)| {
            let [mut q, mut dq, mut ddq] = [*middle, 0.0, 0.0];
            for &Sine { amplitude, w, phase } in sines {
                let (sin, cos) = (w * t + phase).sin_cos();
                q += amplitude * sin;
                dq += amplitude * w * cos;
                ddq -= amplitude * w * w * sin;
            }
            [q, dq, ddq]
        }))
    }
}
