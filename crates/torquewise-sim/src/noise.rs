//! White Gaussian noise at a given signal-to-noise ratio.

use crate::{Result, check_between, normal};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use serde::Serialize;
use std::fmt;
use torquewise_motion::Motion;

/// Signal-to-noise ratio of q, q̇ and q̈ \[dB\]; +∞ leaves a signal clean.
///
/// It reads as the paper writes it: `60/40/30 dB`, `none`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(transparent)]
pub struct Noise([f64; 3]);

impl Noise {
    /// The paper's cases: 1 without noise, 2 with 70/50/30 dB and 3 with 60/40/30 dB on q/q̇/q̈.
    pub const CASES: [Self; 3] =
        [Self([f64::INFINITY; 3]), Self([70.0, 50.0, 30.0]), Self([60.0, 40.0, 30.0])];

    /// One of these cases.
    ///
    /// # Errors
    /// [`SimError::Setting`](crate::SimError::Setting) for another number.
    pub fn case(case: u8) -> Result<Self> {
        check_between("noise case", f64::from(case), [1.0, 3.0], "1, 2 or 3")?;
        Ok(Self::CASES[usize::from(case) - 1])
    }

    /// Ratios of q, q̇ and q̈ \[dB\].
    ///
    /// # Errors
    /// [`SimError::Setting`](crate::SimError::Setting) for NaN or −∞.
    pub fn from_db(q: f64, dq: f64, ddq: f64) -> Result<Self> {
        for (signal, db) in [("q", q), ("dq", dq), ("ddq", ddq)] {
            let what = format!("signal-to-noise ratio of {signal} [dB]");
            check_between(what, db, [f64::MIN, f64::INFINITY], "a number, or inf for no noise")?;
        }
        Ok(Self([q, dq, ddq]))
    }
}

impl fmt::Display for Noise {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if *self == Self::CASES[0] {
            return f.write_str("none");
        }
        let level = |db: f64| if db.is_finite() { db.to_string() } else { "–".into() };
        write!(f, "{} dB", self.0.map(level).join("/"))
    }
}

/// Adds white Gaussian noise to q, q̇ and q̈; t and τ stay as they are.
///
/// Per joint σ² = mean(x²) / 10^(dB/10) over the whole log, so a joint that never moves gets no
/// noise. Each signal of each joint draws from its own stream: its noise depends on `seed` alone,
/// not on the other joints.
///
/// Source: method.md, section 0. Checked against: `tests/noise.rs`.
///
/// # Errors
/// [`SimError::Motion`](crate::SimError::Motion) if the ratio is so low that the noise overflows.
pub fn add_noise(motion: &Motion, noise: &Noise, seed: u64) -> Result<Motion> {
    let mut signals = motion.clone().into_signals();
    // Stream 0 draws trajectories: one seed for both must not couple them.
    let all = [&mut signals.q, &mut signals.dq, &mut signals.ddq];
    for ((x, db), stream) in all.into_iter().zip(noise.0).zip(1_u64..) {
        for (joint, stream) in (0..x.ncols()).zip(stream << 32..) {
            let column = x.col_as_slice_mut(joint);
            let power = column.iter().map(|x| x * x).sum::<f64>() / column.len().max(1) as f64;
            let sigma = (power / 10_f64.powf(db / 10.0)).sqrt();
            if sigma == 0.0 {
                continue;
            }
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            rng.set_stream(stream);
            for x in column {
                *x += sigma * normal(&mut rng);
            }
        }
    }
    Ok(Motion::new(signals)?)
}
