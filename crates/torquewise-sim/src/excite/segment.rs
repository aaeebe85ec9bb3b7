//! Segments of a motion: held, moved or swept, with exact velocity and acceleration.

use crate::excite::sines::Sines;
use crate::{Bounds, State};

/// Roundings must not lift a peak above its limit.
const SLACK: f64 = 1.0 + 1e-9;

#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Segment {
    Hold {
        at: Vec<f64>,
        seconds: f64,
    },
    /// From rest to rest on a line by the polynomial of order 5.
    Glide {
        from: Vec<f64>,
        travel: Vec<f64>,
        seconds: f64,
    },
    /// From rest to rest on a line: speed up, keep the speed, slow down.
    Stroke {
        from: Vec<f64>,
        travel: Vec<f64>,
        ramp: f64,
        cruise: f64,
    },
    /// One period of a sum of sines.
    Sines(Sines),
}

/// Time \[s\] of the fastest [`Segment::Glide`] within the limits.
pub(crate) fn glide_seconds(from: &[f64], to: &[f64], limits: &[Bounds]) -> f64 {
    let of_joint = |((from, to), limits): ((&f64, &f64), &Bounds)| {
        let way = (to - from).abs() * SLACK;
        // Peaks of 10x³ − 15x⁴ + 6x⁵: speed 15/8, acceleration 10/√3.
        let by_speed = 1.875 * way / limits.velocity;
        by_speed.max((10.0 / 3.0_f64.sqrt() * way / limits.acceleration).sqrt())
    };
    from.iter().zip(to).zip(limits).map(of_joint).fold(0.0, f64::max)
}

pub(crate) fn glide(from: &[f64], to: &[f64], limits: &[Bounds]) -> Segment {
    let travel = to.iter().zip(from).map(|(to, from)| to - from).collect();
    Segment::Glide { from: from.to_vec(), travel, seconds: glide_seconds(from, to, limits) }
}

/// Shortest time \[s\] in which speeds \[rad/s\] can be reached smoothly.
pub(crate) fn ramp_seconds(speeds: &[f64], limits: &[Bounds]) -> f64 {
    // The speed goes as 3x² − 2x³, the acceleration as 6x(1 − x), at most 3/2 of its mean.
    let of_joint =
        |(speed, limits): (&f64, &Bounds)| 1.5 * speed.abs() * SLACK / limits.acceleration;
    speeds.iter().zip(limits).map(of_joint).fold(0.0, f64::max)
}

impl Segment {
    pub(crate) fn seconds(&self) -> f64 {
        match self {
            Self::Hold { seconds, .. } | Self::Glide { seconds, .. } => *seconds,
            Self::Stroke { ramp, cruise, .. } => 2.0 * ramp + cruise,
            Self::Sines(sines) => sines.seconds,
        }
    }

    /// Times \[s\] within it between which a polynomial of order 5 tells all, but for sines.
    pub(crate) fn breaks(&self) -> Vec<f64> {
        match self {
            Self::Stroke { ramp, cruise, .. } => vec![*ramp, ramp + cruise],
            _ => Vec::new(),
        }
    }

    /// Pieces that a few points tell the course of: of sines as many as harmonics.
    pub(crate) fn pieces(&self) -> usize {
        if let Self::Sines(sines) = self { sines.harmonics() } else { 1 }
    }

    pub(crate) fn state_at(&self, t: f64) -> State {
        match self {
            Self::Hold { at, .. } => State::on_line(at, at, [0.0; 3]),
            Self::Glide { from, travel, seconds } => {
                State::on_line(from, travel, quintic(t, *seconds))
            }
            Self::Stroke { from, travel, ramp, cruise } => {
                State::on_line(from, travel, trapezoid(t, *ramp, *cruise))
            }
            Self::Sines(sines) => sines.state_at(t),
        }
    }
}

/// 10x³ − 15x⁴ + 6x⁵ with x = t/T, and its two derivatives by t.
fn quintic(t: f64, seconds: f64) -> [f64; 3] {
    let x = t / seconds;
    if x <= 0.0 || x.is_nan() {
        return [0.0; 3];
    }
    if x >= 1.0 {
        return [1.0, 0.0, 0.0];
    }
    let rest = 1.0 - x;
    [
        x * x * x * (10.0 - x * (15.0 - 6.0 * x)),
        30.0 * (x * rest).powi(2) / seconds,
        60.0 * x * rest * (1.0 - 2.0 * x) / (seconds * seconds),
    ]
}

/// Speed up by 3x² − 2x³, keep the speed, slow down as sped up; and the two derivatives.
///
/// An instant at which the speed becomes constant has no acceleration, and so counts as constant.
fn trapezoid(t: f64, ramp: f64, cruise: f64) -> [f64; 3] {
    let peak = 1.0 / (ramp + cruise);
    let rise = |t: f64| {
        let x = t / ramp;
        [
            peak * ramp * x * x * x * (1.0 - x / 2.0),
            peak * x * x * (3.0 - 2.0 * x),
            peak * 6.0 * x * (1.0 - x) / ramp,
        ]
    };
    let left = 2.0 * ramp + cruise - t;
    if t <= 0.0 {
        [0.0; 3]
    } else if t < ramp {
        rise(t)
    } else if left >= ramp {
        [peak * (t - ramp / 2.0), peak, 0.0]
    } else if left > 0.0 {
        let [s, ds, dds] = rise(left);
        [1.0 - s, ds, -dds]
    } else {
        [1.0, 0.0, 0.0]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    const LIMITS: [Bounds; 2] = [
        Bounds { position: [-3.0, 3.0], velocity: 1.0, acceleration: 4.0 },
        Bounds { position: [-3.0, 3.0], velocity: 2.0, acceleration: 1.0 },
    ];

    /// Peaks of speed and acceleration of a joint over a fine grid.
    fn peaks(segment: &Segment, joint: usize) -> [f64; 2] {
        let states = (0..=10_000).map(|k| segment.state_at(segment.seconds() * f64::from(k) / 1e4));
        states.fold([0.0, 0.0], |[speed, acceleration], state| {
            [speed.max(state.dq[joint].abs()), acceleration.max(state.ddq[joint].abs())]
        })
    }

    #[test]
    fn the_fastest_glide_just_reaches_a_limit_and_one_of_no_length_takes_no_time() {
        let by_speed = glide(&[-1.0, 0.0], &[2.0, 0.1], &LIMITS);
        let by_acceleration = glide(&[0.0, 0.0], &[0.1, -0.5], &LIMITS);

        assert_relative_eq!(peaks(&by_speed, 0)[0], 1.0, max_relative = 1e-6);
        assert_relative_eq!(peaks(&by_acceleration, 1)[1], 1.0, max_relative = 1e-6);
        for segment in [by_speed, by_acceleration] {
            for (joint, limits) in LIMITS.iter().enumerate() {
                let [speed, acceleration] = peaks(&segment, joint);
                assert!(speed <= limits.velocity && acceleration <= limits.acceleration);
            }
        }
        let segment = glide(&[0.3, 0.4], &[0.3, 0.4], &LIMITS);

        assert!(segment.seconds() <= 0.0);
        assert_eq!(segment.state_at(0.0), State::at_rest(&[0.3, 0.4]));
    }
}
