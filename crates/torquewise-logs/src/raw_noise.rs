//! From noise measured in raw signals to draws like it, conditioned as the signals are (E7).

use faer::Mat;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use torquewise_motion::signals::{ConditionReport, Conditioner, Derive, Plan, Raw};
use torquewise_motion::{Motion, MotionError};

/// Standard deviations of the white noise of raw q, q̇ and q̈, n each; empty where a signal is not
/// there or does not matter.
#[derive(Clone, Debug)]
pub(crate) struct RawNoise {
    seed: u64,
    deviations: [Vec<f64>; 3],
}

/// The noise of one trajectory on its way through the filter.
pub(crate) struct NoiseLane {
    noise: RawNoise,
    conditioner: Conditioner,
    /// Set up at the first row, whose bits tell the trajectory from others.
    random: Option<ChaCha8Rng>,
}

impl RawNoise {
    /// The noise that a report found in the signals that rows are made of.
    pub(crate) fn of(report: &ConditionReport, derive: Derive, seed: u64) -> Self {
        let of = |signal: &str, matters: bool| -> Vec<f64> {
            let own = report.signals.iter().filter(|own| own.signal == signal && matters);
            own.map(|own| own.noise.sigma).collect()
        };
        let deviations = [
            of("q", true),
            of("dq", derive != Derive::FromPosition),
            of("ddq", derive == Derive::Measured),
        ];
        Self { seed, deviations }
    }

    /// A lane beside a conditioner of this plan.
    pub(crate) fn lane(&self, plan: Plan) -> NoiseLane {
        let conditioner = Conditioner::new(plan.for_part());
        NoiseLane { noise: self.clone(), conditioner, random: None }
    }
}

impl NoiseLane {
    /// Noise for the next rows; hands out rows of noise as a conditioner does those of signals.
    pub(crate) fn push(&mut self, raw: &Raw) -> Result<Vec<Motion>, MotionError> {
        if raw.t.is_empty() {
            return Ok(Vec::new());
        }
        let seed = self.noise.seed;
        let random = self.random.get_or_insert_with(|| {
            let mut random = ChaCha8Rng::seed_from_u64(seed);
            random.set_stream(key_of(raw));
            random
        });
        let n = raw.joints.len();
        let mut parts =
            self.noise.deviations.each_ref().map(|deviations| {
                (deviations.len() == n).then(|| Mat::<f64>::zeros(raw.t.len(), n))
            });
        // Row by row, so that draws do not depend on where blocks end.
        for row in 0..raw.t.len() {
            for (part, deviations) in parts.iter_mut().zip(&self.noise.deviations) {
                let Some(part) = part else { continue };
                for (joint, deviation) in deviations.iter().enumerate() {
                    let unit: f64 = StandardNormal.sample(random);
                    part[(row, joint)] = deviation * unit;
                }
            }
        }
        let [q, dq, ddq] = parts;
        let q = q.unwrap_or_else(|| Mat::zeros(raw.t.len(), n));
        let (joints, t) = (raw.joints.clone(), raw.t.clone());
        self.conditioner.push(&Raw { joints, t, q, dq, ddq, tau: None })
    }

    /// The rest.
    pub(crate) fn finish(mut self) -> Result<Vec<Motion>, MotionError> {
        self.conditioner.finish()
    }
}

/// A number that depends on the first row of a trajectory and on nothing else.
fn key_of(raw: &Raw) -> u64 {
    let torque = raw.tau.iter().flat_map(|tau| (0..tau.ncols()).map(|joint| tau[(0, joint)]));
    let values = (0..raw.q.ncols()).map(|joint| raw.q[(0, joint)]).chain(torque);
    values.fold(0xcbf2_9ce4_8422_2325, |key: u64, x| {
        (key ^ x.to_bits()).wrapping_mul(0x0000_0100_0000_01b3).rotate_left(29)
    })
}
