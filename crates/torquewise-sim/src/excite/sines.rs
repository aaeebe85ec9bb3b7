//! A period of a Fourier series per joint, at rest at both ends.

use crate::{Bounds, State, between, log_between, normal};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::{PI, TAU};

/// qᵢ(t) = cᵢ + Σₖ aᵢₖ sin kωt + bᵢₖ cos kωt over one period, with q̇ᵢ = q̈ᵢ = 0 at its ends.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Sines {
    pub(crate) seconds: f64,
    joints: Vec<Series>,
}

#[derive(Clone, Debug, PartialEq)]
struct Series {
    centre: f64,
    /// (aₖ, bₖ) of k = 1, 2, …
    waves: Vec<[f64; 2]>,
}

/// Harmonics at least and at most: two are taken to be at rest at the ends.
const HARMONICS: [usize; 2] = [4, 12];
/// Highest frequency as a multiple of that at which speed and acceleration peak together.
const BEYOND_CORNER: f64 = 1.5;
/// Points to a period per harmonic, where peaks are looked for.
const POINTS: usize = 32;
/// Sizes of high harmonics beside low ones: k to minus a power in this range.
const ROLL_OFF: [f64; 2] = [0.0, 2.0];
/// Amplitude as a share of what the limits allow.
const AMPLITUDE: [f64; 2] = [0.7, 1.0];
/// How much a variation changes, relative to the size of the waves.
const VARIATION: [f64; 2] = [0.03, 0.6];
/// How much of its range the middle of a motion moves along with that.
const CENTRE_VARIATION: f64 = 0.3;
/// Roundings must not lift a peak above its limit.
const SLACK: f64 = 1.0 - 1e-9;

impl Sines {
    /// Draws a series per joint, as large as the limits allow or a little smaller.
    pub(crate) fn draw(seconds: f64, limits: &[Bounds], rng: &mut ChaCha8Rng) -> Self {
        let series = |limits: &Bounds| {
            let roll_off = between(rng, ROLL_OFF);
            let waves = (1..=harmonics(seconds, limits)).map(|k| {
                let size = (k as f64).powf(-roll_off);
                [size * normal(rng), size * normal(rng)]
            });
            Series::new(waves.collect(), seconds, limits, None, rng)
        };
        Self { seconds, joints: limits.iter().map(series).collect() }
    }

    pub(crate) fn vary(&self, limits: &[Bounds], rng: &mut ChaCha8Rng) -> Self {
        let share = log_between(rng, VARIATION);
        let varied = |(series, limits): (&Series, &Bounds)| {
            let size = series.size();
            let mut moved = |x: f64| x + share * size * normal(rng);
            let waves = series.waves.iter().map(|wave| wave.map(&mut moved)).collect();
            let span = limits.position[1] - limits.position[0];
            let centre = series.centre + share * CENTRE_VARIATION * span * normal(rng);
            Series::new(waves, self.seconds, limits, Some(centre), rng)
        };
        let joints = self.joints.iter().zip(limits).map(varied).collect();
        Self { seconds: self.seconds, joints }
    }

    pub(crate) fn harmonics(&self) -> usize {
        self.joints.iter().map(|series| series.waves.len()).max().unwrap_or(0)
    }

    pub(crate) fn state_at(&self, t: f64) -> State {
        let w = TAU / self.seconds;
        let turn = (w * t).sin_cos();
        State::of_joints(self.joints.iter().map(|series| {
            let [q, dq, ddq] = series.value(turn);
            [q, w * dq, w * w * ddq]
        }))
    }
}

impl Series {
    /// Takes from the waves what moves at the ends, and scales them to the limits.
    ///
    /// `centre`: where the middle of the motion is wished, else it is drawn.
    fn new(
        mut waves: Vec<[f64; 2]>,
        seconds: f64,
        limits: &Bounds,
        centre: Option<f64>,
        rng: &mut ChaCha8Rng,
    ) -> Self {
        // Projected on Σ k aₖ = 0, no speed at the ends, and Σ k² bₖ = 0, no acceleration.
        for (phase, power) in [(0, 1), (1, 2)] {
            let weight = |place: usize| ((place + 1) as f64).powi(power);
            let (mut moving, mut norm) = (0.0, 0.0);
            for (place, wave) in waves.iter().enumerate() {
                moving += weight(place) * wave[phase];
                norm += weight(place).powi(2);
            }
            for (place, wave) in waves.iter_mut().enumerate() {
                wave[phase] -= moving / norm * weight(place);
            }
        }
        let mut series = Self { centre: 0.0, waves };
        let (w, [lower, upper]) = (TAU / seconds, limits.position);
        let points = POINTS * series.waves.len().max(1);
        let mut ends = [[f64::INFINITY, f64::NEG_INFINITY]; 3];
        for point in 0..points {
            let values = series.value((TAU * point as f64 / points as f64).sin_cos());
            for (ends, value) in ends.iter_mut().zip(values) {
                *ends = [ends[0].min(value), ends[1].max(value)];
            }
        }
        // A trigonometric polynomial of order K nowhere exceeds its peak over N > 2K even points
        // by more than 1/cos(πK/N) (Ehlich and Zeller 1964).
        let beyond = 1.0 / (PI / POINTS as f64).cos();
        let [[least, greatest], dq, ddq] = ends;
        let (middle, half) = (f64::midpoint(least, greatest), (greatest - least) / 2.0 * beyond);
        let (least, greatest) = (middle - half, middle + half);
        let size = |[low, high]: [f64; 2]| beyond * low.abs().max(high.abs());
        let bounds = [
            (upper - lower) / (greatest - least),
            limits.velocity / (w * size(dq)),
            limits.acceleration / (w * w * size(ddq)),
        ];
        let most = bounds.into_iter().fold(f64::INFINITY, f64::min);
        let scale = if most.is_finite() { SLACK * most * between(rng, AMPLITUDE) } else { 0.0 };
        series.waves.iter_mut().flatten().for_each(|x| *x *= scale);
        let room = [lower - scale * least, upper - scale * greatest];
        let wished = centre.unwrap_or_else(|| between(rng, room));
        series.centre = wished.clamp(room[0].min(room[1]), room[1].max(room[0]));
        series
    }

    fn size(&self) -> f64 {
        let squares: f64 = self.waves.iter().flatten().map(|x| x * x).sum();
        (squares / (2 * self.waves.len().max(1)) as f64).sqrt()
    }

    /// Value at the angle of which sine and cosine are given, and its two derivatives by the angle.
    fn value(&self, (sin, cos): (f64, f64)) -> [f64; 3] {
        let [mut q, mut dq, mut ddq] = [self.centre, 0.0, 0.0];
        let (mut s, mut c) = (sin, cos);
        for (place, [a, b]) in self.waves.iter().enumerate() {
            let k = (place + 1) as f64;
            let wave = a * s + b * c;
            q += wave;
            dq += k * (a * c - b * s);
            ddq -= k * k * wave;
            (s, c) = (s * cos + c * sin, c * cos - s * sin);
        }
        [q, dq, ddq]
    }
}

/// Harmonics of a period: beyond the corner frequency the acceleration leaves no speed.
fn harmonics(seconds: f64, limits: &Bounds) -> usize {
    let corner = limits.acceleration / limits.velocity / TAU;
    let wanted = (BEYOND_CORNER * corner * seconds).ceil();
    let [least, most] = HARMONICS;
    // Whole numbers of so small a range need no cast.
    (least..most).find(|&count| count as f64 >= wanted).unwrap_or(most)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::excite::part::tests::LIMITS;
    use rand::SeedableRng;
    use torquewise_motion::ends;

    #[test]
    fn some_limit_is_used_to_the_share_that_was_drawn() {
        let two = &LIMITS[..2];

        let sines = Sines::draw(8.0, two, &mut ChaCha8Rng::seed_from_u64(3));

        for (i, limits) in two.iter().enumerate() {
            let states: Vec<State> =
                (0..2000).map(|k| sines.state_at(8.0 * f64::from(k) / 2000.0)).collect();
            let peak = |of: fn(&State) -> &[f64]| {
                states.iter().map(|state| of(state)[i].abs()).fold(0.0, f64::max)
            };
            let [low, high] = ends(states.iter().map(|state| state.q[i]));
            let used = [
                (high - low) / (limits.position[1] - limits.position[0]),
                peak(|state| &state.dq) / limits.velocity,
                peak(|state| &state.ddq) / limits.acceleration,
            ];
            // Bounds of peaks are half a percent beyond the peaks.
            assert!(used.into_iter().fold(0.0, f64::max) > 0.99 * AMPLITUDE[0], "{used:?}");
        }
    }
}
