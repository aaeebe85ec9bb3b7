//! From noise measured in raw signals to draws like it, conditioned as the signals are (E7).

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use torquewise_motion::signals::{ConditionReport, Conditioner, Raw, Signal, SignalPlan};
use torquewise_motion::{Motion, MotionError};

/// Standard deviation of the white noise of raw q of each joint, n: q̇ and q̈ are derived from it.
#[derive(Clone, Debug)]
pub(crate) struct RawNoise {
    seed: u64,
    deviations: Vec<f64>,
}

/// The noise of one trajectory on its way through the filter.
pub(crate) struct NoiseLane {
    noise: RawNoise,
    pub(crate) conditioner: Conditioner,
    /// Set up at the first row, whose bits tell the trajectory from others.
    random: Option<ChaCha8Rng>,
}

impl RawNoise {
    pub(crate) fn of(report: &ConditionReport, seed: u64) -> Self {
        let positions = report.signals.iter().filter(|own| own.signal == "q");
        Self { seed, deviations: positions.map(|own| own.noise).collect() }
    }

    pub(crate) fn lane(&self, plan: SignalPlan) -> NoiseLane {
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
            let values = raw.of(Signal::Q).iter().chain(raw.of(Signal::Tau)).map(|x| x[0]);
            random.set_stream(values.fold(0xcbf2_9ce4_8422_2325, |key: u64, x| {
                (key ^ x.to_bits()).wrapping_mul(0x0000_0100_0000_01b3).rotate_left(29)
            }));
            random
        });
        let mut q = vec![Vec::with_capacity(raw.t.len()); raw.joints.len()];
        // Row by row, so that draws do not depend on where blocks end.
        for _ in &raw.t {
            for (q, deviation) in q.iter_mut().zip(&self.noise.deviations) {
                let unit: f64 = StandardNormal.sample(random);
                q.push(deviation * unit);
            }
        }
        let (joints, t) = (raw.joints.clone(), raw.t.clone());
        self.conditioner.push(Raw { joints, t, signals: [Some(q), None, None, None] })
    }
}
