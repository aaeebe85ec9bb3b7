//! Rotors refined by simulated windows of the log as well as by torque (E23).

use super::equations::Equations;
use super::linearisation::Linearisation;
use super::nominal::Sizes;
use super::pass::add_up;
use super::step::Step;
use super::windows::{add_up_windows, drifts_of};
use crate::drive_terms::DriveTerm;
use crate::fitted::Fitted;
use crate::reconstruction::{Progress, Watch};
use crate::unseen::geometric_mean;
use faer::{ColRef, Mat};
use torquewise_model::model::Choice;
use torquewise_model::rollout::Drift;
use torquewise_motion::Recording;
use torquewise_regression::normal_sums::NormalSums;
use torquewise_rigid::feasible::{Prior, Quadratic, minimise};
use torquewise_rigid::recursion::PER_BODY;
use torquewise_stepwise::error::IdentifyError;
use torquewise_stepwise::held_out::{CvScore, listed, mean};

/// What windows count beside the torque, in powers of ten of what they would if a window told as much
/// as an independent row.
const EXPONENTS: [i32; 7] = [-3, -2, -1, 0, 1, 2, 3];
/// So much more of the torque may be left.
const MOST_TORQUE: f64 = 1.02;
/// Fewer windows are too few to choose by, and so are fewer folds with windows.
const LEAST_WINDOWS: usize = 8;
const LEAST_FOLDS: usize = 3;
/// Rounds at most, and the part of the cost that a further one must gain.
const ROUNDS: usize = 8;
const LEAST_GAIN: f64 = 1e-3;
/// Parts of a step that are tried.
const SHARES: [f64; 4] = [1.0, 0.5, 0.25, 0.1];

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
    (sums, sizes): (&NormalSums, &Sizes),
    watch: Watch<'_>,
) -> Result<Fitted, IdentifyError> {
    let start = fitted.solved.at.clone();
    let (places, shafts) = rotors_of(&start);
    let before = drifts_of(recording, &start)?;
    let weights = weights(&before);
    let windows_at = |at: &Linearisation, made: usize| -> Result<Windows, IdentifyError> {
        Progress::Rollouts { made, most: ROUNDS }.tell(watch)?;
        let sums = add_up_windows(recording, at, &shafts, &weights)?;
        Ok(Windows { sums, at: places.iter().map(|&k| at.linear[k]).collect() })
    };
    let windows = windows_at(&start, 0)?;
    if windows.sums.folds().len() < LEAST_FOLDS || windows.sums.blocks() < LEAST_WINDOWS as u64 {
        let windows = before.first().map_or(0, |drift| drift.windows);
        return Err(IdentifyError::TooFewWindows { windows, needed: LEAST_WINDOWS });
    }
    let torque = TorqueOf::new(Step::new(sums, &start, sizes), places.clone());
    let (weight, choice) = torque.chosen(&windows)?;
    let at = |rotors: &[f64]| start.at(&torque.step.whole(&torque.places, rotors));
    let cost = |rotors: &[f64]| -> Result<f64, IdentifyError> {
        Progress::Working.tell(watch)?;
        let drifts = drifts_of(recording, &at(rotors))?;
        Ok(torque.cost(rotors) + weight * half_squares(&drifts, &weights))
    };
    let mut rotors = windows.at.clone();
    let (mut windows, mut least) = (windows, cost(&rotors)?);
    for made in 1..=if weight > 0.0 { ROUNDS } else { 0 } {
        let wanted = torque.best(&windows, weight)?;
        let mut better = None;
        for share in SHARES {
            let tried: Vec<f64> =
                rotors.iter().zip(&wanted).map(|(from, to)| from + share * (to - from)).collect();
            let cost = cost(&tried)?;
            if cost < least {
                better = Some((tried, cost));
                break;
            }
        }
        let Some((tried, cost)) = better else { break };
        let is_last = least - cost < LEAST_GAIN * least;
        (rotors, least) = (tried, cost);
        if is_last {
            break;
        }
        windows = windows_at(&at(&rotors), made)?;
    }
    let most = MOST_TORQUE * geometric_mean(&fitted.residual_rms);
    let mut refined = at(&rotors);
    let mut left = add_up(recording, &refined)?.residual_rms();
    while geometric_mean(&left) > most {
        // Between two physical arms all are.
        refined = start.towards(&refined, 0.5);
        left = add_up(recording, &refined)?.residual_rms();
    }
    let Fitted { mut solved, mut choices, .. } = fitted;
    for &k in &torque.places {
        // What torque and motion say apart is not known better than that.
        solved.covariance[(k, k)] += (refined.linear[k] - start.linear[k]).powi(2);
    }
    solved.at = refined;
    choices.push(choice);
    Ok(Fitted { solved, residual_rms: left, choices, ..fitted })
}

/// The rotors of a chain: their places among the parameters, and their shafts, n each.
fn rotors_of(at: &Linearisation) -> (Vec<usize>, Vec<Vec<f64>>) {
    let first = PER_BODY * at.n_joints();
    let drive = at.structure.drive.iter().enumerate();
    let rotors = drive.filter_map(|(k, term)| match term {
        DriveTerm::Rotor(shaft) => Some((first + k, shaft.clone())),
        DriveTerm::Friction(_) | DriveTerm::Energy(_) => None,
    });
    rotors.unzip()
}

/// Normal equations of simulated windows in the rotors, at those they were simulated with.
struct Windows {
    sums: NormalSums,
    at: Vec<f64>,
}

impl Windows {
    /// Sum of squares of a Gram matrix at other rotors.
    fn squares(&self, gram: &Mat<f64>, rotors: &[f64]) -> f64 {
        let step = self.at.iter().zip(rotors).map(|(at, x)| at - x);
        let z: Vec<f64> = step.chain([1.0]).collect();
        let product = gram * ColRef::from_slice(&z);
        z.iter().zip(product.iter()).map(|(z, y)| z * y).sum::<f64>().max(0.0)
    }
}

/// Normal equations of torque and prior in the rotors, where all else stays.
struct TorqueOf<'a> {
    step: Step<'a>,
    places: Vec<usize>,
    prior: Prior,
}

impl<'a> TorqueOf<'a> {
    fn new(step: Step<'a>, places: Vec<usize>) -> Self {
        let place = |index: usize| places.iter().position(|own| *own == index);
        let rotors = step.prior.rotors.iter().filter_map(|&(k, usual)| Some((place(k)?, usual)));
        let prior = Prior { rotors: rotors.collect(), ..Prior::default() };
        Self { step, places, prior }
    }

    /// Half the sum of squares of torque, with what the prior adds.
    fn cost(&self, rotors: &[f64]) -> f64 {
        let prior = self.prior.value(rotors).unwrap_or(f64::INFINITY);
        self.step.all.cost(self.step.at, &self.step.whole(&self.places, rotors))
            + self.step.strength() * prior
    }

    /// The best rotors for the torque and so many times the windows.
    fn best(&self, windows: &Windows, weight: f64) -> Result<Vec<f64>, IdentifyError> {
        let own = self.step.all.of(&self.places, self.step.at, (0.0, 0.0));
        self.minimum(&own, windows, (&windows.sums.gram(), weight))
    }

    fn minimum(
        &self,
        own: &Equations,
        windows: &Windows,
        (gram, weight): (&Mat<f64>, f64),
    ) -> Result<Vec<f64>, IdentifyError> {
        let p = windows.at.len();
        let of_windows = gram.submatrix(0, 0, p, p);
        let known = of_windows * ColRef::from_slice(&windows.at);
        let hessian = &own.hessian + faer::Scale(weight) * of_windows;
        let right: Vec<f64> =
            (0..p).map(|k| own.right[k] + weight * (gram[(p, k)] + known[k])).collect();
        let both = Quadratic { hessian: &hessian, right: &right };
        Ok(minimise(both, &self.prior, self.step.strength(), &windows.at)?)
    }

    /// What windows count beside the torque: where those of held-out regions drift least, among those
    /// where the torque there is as good.
    fn chosen(&self, windows: &Windows) -> Result<(f64, Choice), IdentifyError> {
        let (all, folds) = (windows.sums.gram(), windows.sums.folds());
        let tens = EXPONENTS.map(|exponent| self.step.repeats * 10_f64.powi(exponent));
        let weights: Vec<f64> = std::iter::once(0.0).chain(tens).collect();
        let mut errors = vec![[Vec::new(), Vec::new()]; weights.len()];
        for &fold in folds.iter().filter(|fold| self.step.sums.rows_of(**fold) > 0) {
            let (torque, rest, _) = self.step.without(fold);
            let held = windows.sums.gram_of(fold);
            let others = &all - &held;
            let own = rest.of(&self.places, self.step.at, (0.0, 0.0));
            for (weight, errors) in weights.iter().zip(&mut errors) {
                let best = self.minimum(&own, windows, (&others, *weight))?;
                let whole = self.step.whole(&self.places, &best);
                let count = windows.sums.rows_of(fold) as f64 * self.step.at.n_joints() as f64;
                errors[0].push(self.step.error(&torque, fold, &whole));
                errors[1].push((windows.squares(&held, &best) / count).sqrt());
            }
        }
        let most = MOST_TORQUE * mean(&errors[0][0]);
        let allowed = (0..weights.len()).filter(|&k| mean(&errors[k][0]) <= most);
        let least = allowed.min_by(|&a, &b| mean(&errors[a][1]).total_cmp(&mean(&errors[b][1])));
        let place = least.unwrap_or(0);
        let label = |k: usize| match k {
            0 => "nothing".to_owned(),
            k => format!("{} rows each", 10_f64.powi(EXPONENTS[k - 1])),
        };
        let trials: Vec<CvScore> = errors
            .into_iter()
            .enumerate()
            .map(|(k, [_, errors])| CvScore {
                label: label(k),
                complexity: self.places.len(),
                errors,
            })
            .collect();
        let rule = format!("least drift, {} regions held out", folds.len());
        let what = "what simulated windows count for the rotors".to_owned();
        Ok((weights[place], Choice { what, chosen: label(place), rule, from: listed(&trials) }))
    }
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
