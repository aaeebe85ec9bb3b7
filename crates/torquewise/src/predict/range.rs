//! Where a motion leaves the range a model was fitted on.

use torquewise_model::units;
use torquewise_model::{Model, number};
use torquewise_motion::{LARGEST, Motion};

/// A position may be this part of the trained range beyond its ends.
const Q_MARGIN: f64 = 0.05;
/// A speed or acceleration may be this many times the largest trained on.
const RATE_FACTOR: f64 = 1.5;
/// What to do beyond the range.
const TRUST: &str = "do not trust its torque there, or fit on a log that covers it";

/// The range of a motion, joint by joint, to be compared with that of a model.
#[derive(Clone, Debug)]
pub struct MotionRange {
    q: Vec<[f64; 2]>,
    dq: Vec<f64>,
    ddq: Vec<f64>,
    /// Sum of the squares of q̇, n, of so many rows.
    squares: Vec<f64>,
    rows: usize,
}

impl MotionRange {
    /// No motion yet, of n joints.
    pub fn new(n_joints: usize) -> Self {
        let q = vec![[f64::INFINITY, f64::NEG_INFINITY]; n_joints];
        let [dq, ddq, squares] = [(); 3].map(|()| vec![0.0; n_joints]);
        Self { q, dq, ddq, squares, rows: 0 }
    }

    /// Widens the range by a block.
    pub fn add(&mut self, block: &Motion) {
        for (joint, [low, high]) in self.q.iter_mut().enumerate() {
            for &q in block.q().col(joint).iter() {
                (*low, *high) = (low.min(q), high.max(q));
            }
        }
        self.rows += block.n_rows();
        for (sum, dq) in self.squares.iter_mut().zip(block.dq().col_iter()) {
            *sum += dq.squared_norm_l2();
        }
        for (peaks, rates) in [(&mut self.dq, block.dq()), (&mut self.ddq, block.ddq())] {
            for (joint, peak) in peaks.iter_mut().enumerate() {
                *peak = rates.col(joint).iter().fold(*peak, |peak, rate| peak.max(rate.abs()));
            }
        }
    }

    /// Which joints rest, but for what is next to nothing of the speeds that a model was fitted on.
    pub(crate) fn at_rest(&self, model: &Model) -> Vec<bool> {
        let pairs = self.squares.iter().zip(model.rest_speeds());
        pairs.map(|(sum, slow)| *sum < self.rows as f64 * slow * slow).collect()
    }

    /// Which rows of a block leave the range a model was fitted on, with any joint.
    pub fn outside(model: &Model, block: &Motion) -> Vec<bool> {
        let mut range = Self::new(model.n_joints());
        let is_outside = |row: usize| {
            for joint in 0..model.n_joints() {
                range.q[joint] = [block.q()[(row, joint)]; 2];
                range.dq[joint] = block.dq()[(row, joint)].abs();
                range.ddq[joint] = block.ddq()[(row, joint)].abs();
            }
            (0..model.n_joints()).any(|joint| range.beyond(model, joint).contains(&true))
        };
        (0..block.n_rows()).map(is_outside).collect()
    }

    /// Whether position, speed and acceleration of a joint are beyond what a model was fitted on.
    pub(crate) fn beyond(&self, model: &Model, joint: usize) -> [bool; 3] {
        let (training, [low, high]) = (&model.training, self.q[joint]);
        let is_faster = |reached: &[f64], trained: &[f64]| {
            trained.get(joint).is_some_and(|trained| reached[joint] > RATE_FACTOR * trained)
        };
        let is_off = training.q_range.get(joint).is_some_and(|[from, to]| {
            let margin = Q_MARGIN * (to - from);
            low < from - margin || high > to + margin
        });
        [is_off, is_faster(&self.dq, &training.dq_peak), is_faster(&self.ddq, &training.ddq_peak)]
    }

    /// One warning for each joint that left the range a model was fitted on.
    pub fn warnings(&self, model: &Model) -> Vec<String> {
        let training = &model.training;
        let mut warnings = Vec::new();
        for (joint, name) in model.joints.iter().enumerate() {
            let kind = model.kinds().of(joint);
            let [is_off, rates @ ..] = self.beyond(model, joint);
            let (mut beyond, mut advice) = (Vec::new(), TRUST);
            if is_off {
                let ([low, high], [from, to]) = (self.q[joint], training.q_range[joint]);
                let reached = match (short(low), short(high)) {
                    (low, high) if low == high => format!("at {low}"),
                    (low, high) => format!("from {low} to {high}"),
                };
                beyond.push(format!("q {reached} {}, not {from:.2} to {to:.2}", kind.unit));
                if f64::max(-low, high) > LARGEST[0] && f64::max(-from, to) <= LARGEST[0] {
                    advice = "are these degrees?";
                }
            }
            let signals = [
                ("dq", "rad/s", &self.dq, &training.dq_peak),
                ("ddq", "rad/s²", &self.ddq, &training.ddq_peak),
            ];
            for (_, (signal, unit, reached, trained)) in
                rates.into_iter().zip(signals).filter(|(is_faster, _)| *is_faster)
            {
                let (unit, reached) = (units::unit(kind, unit), short(reached[joint]));
                beyond.push(format!("{signal} to {reached} {unit}, not {:.2}", trained[joint]));
            }
            if !beyond.is_empty() {
                warnings.push(format!(
                    "{name} leaves the range the model was fitted on ({}): {advice}",
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
