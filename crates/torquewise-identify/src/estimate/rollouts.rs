//! Rotors refined by simulated windows of the log as well as by torque (E23).

use super::equations::Equations;
use super::linearisation::Linearisation;
use super::pass::add_up;
use super::step::Step;
use super::windows::{add_up_windows, drifts_of};
use crate::{DriveTerm, Fitted, Progress, Watch};
use faer::{ColRef, Mat};
use torquewise_model::Choice;
use torquewise_model::rollout::Drift;
use torquewise_motion::Recording;
use torquewise_regression::NormalSums;
use torquewise_rigid::PER_BODY;
use torquewise_rigid::feasible::{Prior, Quadratic, minimise};
use torquewise_stepwise::IdentifyError;

/// What a window may count beside the torque, in quarters of powers of ten of an independent row.
const EXPONENTS: std::ops::RangeInclusive<i32> = -12..=12;
/// So much more of the torque may be left: other motion pays up to twice as much.
const MOST_TORQUE: f64 = 1.015;
/// Fewer windows are too few to learn from.
const LEAST_WINDOWS: usize = 8;
/// Rounds at most, and the part of the cost that a further one must gain.
const ROUNDS: usize = 8;
const LEAST_GAIN: f64 = 0.05;
/// Parts of a step that are tried.
const SHARES: [f64; 3] = [1.0, 0.3, 0.1];

/// Refines the rotors of a chain by windows simulated all over a recording.
///
/// A small inertia is what a log of torque tells least and a simulation needs most, and what the
/// gear reflects of a rotor is most of it. All other parameters stay: those that the torque leaves
/// open would follow the windows of this log, and no others.
///
/// - `sums`: of the torque, at the linearisation of the chain
pub(crate) fn refined_by_rollouts(
    recording: &(impl Recording + ?Sized),
    fitted: Fitted,
    sums: &NormalSums,
    watch: Watch<'_>,
) -> Result<Fitted, IdentifyError> {
    let start = fitted.solved.at.clone();
    let (places, shafts) = rotors_of(&start);
    let before = drifts_of(recording, &start)?;
    let weights = weights(&before);
    let windows_at = |at: &Linearisation, made: usize| {
        Progress::Rollouts { made, most: ROUNDS }.tell(watch)?;
        add_up_windows(recording, at, &shafts, &weights)
    };
    let windows = windows_at(&start, 0)?;
    if windows.blocks() < LEAST_WINDOWS as u64 {
        let windows = before.first().map_or(0, |drift| drift.windows);
        return Err(IdentifyError::TooFewWindows { windows, needed: LEAST_WINDOWS });
    }
    let mut rotors: Vec<f64> = places.iter().map(|&k| start.linear[k]).collect();
    let torque = TorqueOf::new(Step::new(sums, &start, &fitted.sizes), places);
    let at = |rotors: &[f64]| start.at(&torque.step.whole(&torque.places, rotors));
    let mut drifted = half_squares(&before, &weights);
    let mut chosen = torque.chosen(&windows, &rotors)?;
    for made in 1..=ROUNDS {
        let cost = |rotors: &[f64], drifted: f64| torque.cost(rotors) + chosen.weight * drifted;
        let from = cost(&rotors, drifted);
        let mut better = None;
        for share in SHARES {
            let pairs = rotors.iter().zip(&chosen.best);
            let tried: Vec<f64> = pairs.map(|(from, to)| from + share * (to - from)).collect();
            Progress::Working.tell(watch)?;
            let drifted = half_squares(&drifts_of(recording, &at(&tried))?, &weights);
            if cost(&tried, drifted) < from {
                better = Some((tried, drifted));
                break;
            }
        }
        let Some(better) = better else { break };
        (rotors, drifted) = better;
        if from - cost(&rotors, drifted) < LEAST_GAIN * from {
            break;
        }
        chosen = torque.chosen(&windows_at(&at(&rotors), made)?, &rotors)?;
    }
    let refined = at(&rotors);
    let left = add_up(recording, &refined)?.residual_rms();
    let Fitted { mut solved, mut choices, .. } = fitted;
    for &k in &torque.places {
        // What torque and motion say apart is not known better than that.
        solved.covariance[(k, k)] += (refined.linear[k] - start.linear[k]).powi(2);
    }
    solved.at = refined;
    choices.push(Choice {
        what: "what simulated windows count for the rotors".to_owned(),
        chosen: chosen.label,
        rule: format!("the most for which at most {MOST_TORQUE} times the torque is missed"),
        from: Vec::new(),
    });
    Ok(Fitted { solved, residual_rms: left, choices, ..fitted })
}

/// The rotors of a chain: their places among the parameters, and their shafts, n each.
fn rotors_of(at: &Linearisation) -> (Vec<usize>, Vec<Vec<f64>>) {
    let first = PER_BODY * at.n_joints();
    let drive = at.drive.iter().enumerate();
    let rotors = drive.filter_map(|(k, term)| match term {
        DriveTerm::Rotor(shaft) => Some((first + k, shaft.clone())),
        DriveTerm::Friction(_) | DriveTerm::Energy(_) => None,
    });
    rotors.unzip()
}

/// Normal equations of torque and prior in the rotors, where all else stays.
struct TorqueOf<'a> {
    step: Step<'a>,
    places: Vec<usize>,
    own: Equations,
    prior: Prior,
}

impl<'a> TorqueOf<'a> {
    fn new(step: Step<'a>, places: Vec<usize>) -> Self {
        let place = |index: usize| places.iter().position(|own| *own == index);
        let rotors = step.prior.rotors.iter().filter_map(|&(k, usual)| Some((place(k)?, usual)));
        let prior = Prior { rotors: rotors.collect(), ..Prior::default() };
        let own = step.all.of(&places, step.at, (0.0, 0.0));
        Self { step, places, own, prior }
    }

    /// Half the sum of squares of torque, with what the prior adds.
    fn cost(&self, rotors: &[f64]) -> f64 {
        let prior = self.prior.value(rotors).unwrap_or(f64::INFINITY);
        self.step.all.cost(self.step.at, &self.step.whole(&self.places, rotors))
            + self.step.strength() * prior
    }

    /// The most that windows may count beside the torque, for which hardly more of it is left.
    ///
    /// - `windows`: in the rotors, at those they were simulated with
    fn chosen(&self, windows: &NormalSums, at: &[f64]) -> Result<Chosen, IdentifyError> {
        let squares = |x: &[f64]| self.step.squares(&self.step.gram, x);
        let most = MOST_TORQUE.powi(2) * squares(&self.step.before);
        let gram = windows.gram();
        for exponent in EXPONENTS.rev() {
            let rows = 10_f64.powf(0.25 * f64::from(exponent));
            let weight = self.step.repeats * rows;
            let best = self.best(&gram, at, weight)?;
            if squares(&self.step.whole(&self.places, &best)) <= most {
                return Ok(Chosen { weight, best, label: format!("{rows:.3} rows each") });
            }
        }
        Ok(Chosen { weight: 0.0, best: at.to_vec(), label: "nothing".to_owned() })
    }

    /// The best rotors for the torque and so many times the windows.
    fn best(&self, gram: &Mat<f64>, at: &[f64], weight: f64) -> Result<Vec<f64>, IdentifyError> {
        let p = at.len();
        let of_windows = gram.submatrix(0, 0, p, p);
        let known = of_windows * ColRef::from_slice(at);
        let hessian = &self.own.hessian + faer::Scale(weight) * of_windows;
        let right: Vec<f64> =
            (0..p).map(|k| self.own.right[k] + weight * (gram[(p, k)] + known[k])).collect();
        let both = Quadratic { hessian: &hessian, right: &right };
        Ok(minimise(both, &self.prior, self.step.strength(), at)?)
    }
}

/// What windows count, and where torque and windows then agree.
struct Chosen {
    weight: f64,
    best: Vec<f64>,
    label: String,
}

/// One over the usual drift of each joint at each horizon; of one that runs away, over what a held
/// velocity drifts.
fn weights(drifts: &[Drift]) -> Vec<Vec<f64>> {
    let of = |drift: &Drift| {
        let usual = if drift.ran_away > 0 { &drift.hold_rms_rad } else { &drift.rms_drift_rad };
        usual.iter().map(|usual| 1.0 / usual.max(f64::MIN_POSITIVE.sqrt())).collect()
    };
    drifts.iter().map(of).collect()
}

/// Half the sum of squares of drifts in units of what is usual; infinite where one ran away.
fn half_squares(drifts: &[Drift], weights: &[Vec<f64>]) -> f64 {
    if drifts.iter().any(|drift| drift.ran_away > 0) {
        return f64::INFINITY;
    }
    let pairs = drifts.iter().zip(weights).flat_map(|(drift, weights)| {
        let windows = drift.windows as f64;
        drift.rms_drift_rad.iter().zip(weights).map(move |(rms, w)| windows * (rms * w).powi(2))
    });
    0.5 * pairs.sum::<f64>()
}
