//! From noise measured in raw signals to draws like it, conditioned as the signals are (E7).

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use torquewise_motion::signals::{ConditionReport, Conditioner, SignalPlan};
use torquewise_motion::{Motion, MotionError, Raw, Signal};

/// The key before the first row.
const FIRST_KEY: u64 = 0xcbf2_9ce4_8422_2325;

/// The noise of one trajectory on its way through the filter.
pub(crate) struct NoiseLane {
    /// Standard deviation of the white noise of raw q of each joint, n: q̇ and q̈ are derived from it.
    deviations: Vec<f64>,
    pub(crate) conditioner: Conditioner,
    random: ChaCha8Rng,
    /// Made of the bits of all rows so far: from where two trajectories differ, so do their draws.
    key: u64,
}

impl NoiseLane {
    pub(crate) fn new(report: &ConditionReport, seed: u64, plan: SignalPlan) -> Self {
        let positions = report.signals.iter().filter(|own| own.signal == "q");
        let deviations = positions.map(|own| own.noise).collect();
        let conditioner = Conditioner::new(plan.for_part());
        Self { deviations, conditioner, random: ChaCha8Rng::seed_from_u64(seed), key: FIRST_KEY }
    }

    /// Noise for the next rows; hands out rows of noise as a conditioner does those of signals.
    pub(crate) fn push(&mut self, raw: &Raw) -> Result<Vec<Motion>, MotionError> {
        if raw.t.is_empty() {
            return Ok(Vec::new());
        }
        let mut q = vec![Vec::with_capacity(raw.t.len()); raw.joints.len()];
        // Row by row, so that draws do not depend on where blocks end.
        for row in 0..raw.t.len() {
            let values = raw.of(Signal::Q).iter().chain(raw.of(Signal::Tau)).map(|x| x[row]);
            self.key = values.fold(self.key, |key: u64, x| {
                (key ^ x.to_bits()).wrapping_mul(0x0000_0100_0000_01b3).rotate_left(29)
            });
            self.random.set_stream(self.key);
            self.random.set_word_pos(0);
            for (q, deviation) in q.iter_mut().zip(&self.deviations) {
                let unit: f64 = StandardNormal.sample(&mut self.random);
                q.push(deviation * unit);
            }
        }
        let (joints, t) = (raw.joints.clone(), raw.t.clone());
        self.conditioner.push(Raw { joints, t, signals: [Some(q), None, None, None] })
    }
}
