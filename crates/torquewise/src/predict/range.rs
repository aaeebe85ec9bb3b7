//! Where a motion leaves the range a model was fitted on.

use torquewise_model::units;
use torquewise_model::{Model, number};
use torquewise_motion::Motion;

/// A position may be this part of the trained range beyond its ends.
const Q_MARGIN: f64 = 0.05;
/// A speed or acceleration may be this many times the largest trained on.
const RATE_FACTOR: f64 = 1.5;
/// Ranges this close to each other are of the same rows.
const SAME: f64 = 1e-9;

/// The range of a motion, joint by joint, to be compared with that of a model.
#[derive(Clone, Debug)]
pub struct MotionRange {
    q: Vec<[f64; 2]>,
    dq: Vec<f64>,
    ddq: Vec<f64>,
}

impl MotionRange {
    /// No motion yet, of n joints.
    pub fn new(n_joints: usize) -> Self {
        let q = vec![[f64::INFINITY, f64::NEG_INFINITY]; n_joints];
        Self { q, dq: vec![0.0; n_joints], ddq: vec![0.0; n_joints] }
    }

    /// Widens the range by a block.
    pub fn add(&mut self, block: &Motion) {
        for (joint, [low, high]) in self.q.iter_mut().enumerate() {
            for &q in block.q().col(joint).iter() {
                (*low, *high) = (low.min(q), high.max(q));
            }
        }
        for (peaks, rates) in [(&mut self.dq, block.dq()), (&mut self.ddq, block.ddq())] {
            for (joint, peak) in peaks.iter_mut().enumerate() {
                *peak = rates.col(joint).iter().fold(*peak, |peak, rate| peak.max(rate.abs()));
            }
        }
    }

    /// Whether it is the very range of the rows that a model was fitted on.
    pub fn is_trained(&self, model: &Model) -> bool {
        let training = &model.training;
        let same = |a: f64, b: f64| (a - b).abs() <= SAME * b.abs();
        let of_q = self.q.iter().flatten().zip(training.q_range.iter().flatten());
        let of_dq = self.dq.iter().zip(&training.dq_peak);
        !training.dq_peak.is_empty() && of_q.chain(of_dq).all(|(a, b)| same(*a, *b))
    }

    /// One warning for each joint that left the range a model was fitted on.
    pub fn warnings(&self, model: &Model) -> Vec<String> {
        let training = &model.training;
        let mut warnings = Vec::new();
        for (joint, name) in model.joints.iter().enumerate() {
            let (mut beyond, kind) = (Vec::new(), model.kinds().of(joint));
            if let (Some([low, high]), Some([from, to])) =
                (self.q.get(joint), training.q_range.get(joint))
            {
                let margin = Q_MARGIN * (to - from);
                if *low < from - margin || *high > to + margin {
                    let reached = match (short(*low), short(*high)) {
                        (low, high) if low == high => format!("at {low}"),
                        (low, high) => format!("from {low} to {high}"),
                    };
                    let unit = kind.unit();
                    beyond.push(format!("q {reached} {unit}, not {from:.2} to {to:.2}"));
                }
            }
            let rates = [
                ("dq", "rad/s", &self.dq, &training.dq_peak),
                ("ddq", "rad/s²", &self.ddq, &training.ddq_peak),
            ];
            for (signal, unit, reached, trained) in rates {
                if let (Some(reached), Some(trained)) = (reached.get(joint), trained.get(joint))
                    && *reached > RATE_FACTOR * trained
                {
                    let unit = units::unit(kind, unit);
                    beyond
                        .push(format!("{signal} to {} {unit}, not {trained:.2}", short(*reached)));
                }
            }
            if !beyond.is_empty() {
                warnings.push(format!(
                    "{name} leaves the range the model was fitted on ({}): \
                     do not trust its torque there, or fit on a log that covers it",
                    beyond.join("; ")
                ));
            }
        }
        warnings
    }
}
/// Hundredths, or four digits of what no arm reaches.
fn short(value: f64) -> String {
    if value.abs() < 1e6 { format!("{value:.2}") } else { number(value) }
}
