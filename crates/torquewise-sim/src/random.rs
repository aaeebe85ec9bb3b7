//! Random numbers of a few distributions from a seeded generator.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

pub(crate) fn between(rng: &mut ChaCha8Rng, [least, greatest]: [f64; 2]) -> f64 {
    least + (greatest - least) * rng.random::<f64>()
}

/// A number between two others, its logarithm evenly drawn.
pub(crate) fn log_between(rng: &mut ChaCha8Rng, ends: [f64; 2]) -> f64 {
    between(rng, ends.map(f64::ln)).exp()
}

pub(crate) fn normal(rng: &mut ChaCha8Rng) -> f64 {
    StandardNormal.sample(rng)
}

pub(crate) fn direction(rng: &mut ChaCha8Rng) -> f64 {
    if rng.random::<bool>() { 1.0 } else { -1.0 }
}
