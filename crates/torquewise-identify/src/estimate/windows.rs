//! Normal equations of simulated windows in the rotors of the arm (E23).

use super::linearisation::Linearisation;
use crate::fitted::movable;
use faer::Mat;
use faer::linalg::solvers::Solve;
use rayon::prelude::*;
use torquewise_model::rollout::{Drift, Window, drifts, windows};
use torquewise_model::{ModelError, Torque};
use torquewise_motion::Recording;
use torquewise_regression::{Alike, BlockSums, NormalSums};
use torquewise_stepwise::IdentifyError;

/// Times from the start of a window \[s\] at which it is compared.
const HORIZONS: [f64; 2] = [0.2, 0.5];
/// Time between two states at which derivatives are taken \[s\].
const TAKEN: f64 = 5e-3;
/// Changes \[rad, rad/s\] by which the stiffness and the damping of an arm are found: across the
/// reversal of its friction, which holds a joint at rest.
const CHANGE: f64 = 1e-3;

/// How far the windows of a recording drift from it at each horizon.
pub(super) fn drifts_of(
    recording: &(impl Recording + ?Sized),
    at: &Linearisation,
) -> Result<Vec<Drift>, IdentifyError> {
    Ok(drifts(&movable(at, recording.joints()), None, recording, &HORIZONS)?)
}

/// Adds up the normal equations of where windows end, an instant for each horizon; a window whose
/// simulation runs away does not count.
///
/// - `rotors`: shafts of the rotors that are moved, n each
/// - `weights`: one over the usual drift of each joint at each horizon \[1/rad\]
pub(super) fn add_up_windows(
    recording: &(impl Recording + ?Sized),
    at: &Linearisation,
    rotors: &[Vec<f64>],
    weights: &[Vec<f64>],
) -> Result<NormalSums, IdentifyError> {
    let model = movable(at, recording.joints());
    let torque = Torque::new(&model);
    let mut sums = NormalSums::new(rotors.len(), at.n_joints(), 1);
    let arm = Arm { torque, at, rotors, weights };
    let longest = HORIZONS[HORIZONS.len() - 1];
    windows(&model, recording, (longest, None), &mut |windows| {
        let blocks = windows.par_iter().map(|window| arm.block(window));
        for block in blocks.collect::<Result<Vec<_>, ModelError>>()?.into_iter().flatten() {
            sums.add(&block)?;
        }
        Ok(())
    })?;
    Ok(sums)
}

/// An arm whose windows are simulated.
struct Arm<'a> {
    torque: Torque,
    at: &'a Linearisation,
    rotors: &'a [Vec<f64>],
    weights: &'a [Vec<f64>],
}

/// On the way of a window: times of the last derivatives and of the arm \[s\], ∂q/∂β and ∂q̇/∂β,
/// n×p, and the first of them at each horizon so far.
struct Moves {
    before: f64,
    t: f64,
    position: Mat<f64>,
    speed: Mat<f64>,
    reached: Vec<Mat<f64>>,
}

impl Arm<'_> {
    fn block(&self, window: &Window<'_>) -> Result<Option<BlockSums>, ModelError> {
        let (n, p) = (self.at.n_joints(), self.rotors.len());
        let (position, speed) = (Mat::zeros(n, p), Mat::zeros(n, p));
        let mut moves = Moves { before: 0.0, t: 0.0, position, speed, reached: Vec::new() };
        let mut failed = Ok(());
        let ends = window.simulated(&self.torque, &HORIZONS, &mut |arm, seconds| {
            moves.t += seconds;
            if moves.t - moves.before > 0.999 * TAKEN && failed.is_ok() {
                failed = self.follow([arm.path.q(), &arm.dq, &arm.ddq], &mut moves);
            }
        })?;
        failed?;
        let (count, mut weights) = (HORIZONS.len(), vec![0.0; n * HORIZONS.len()]);
        let mut rows = Mat::zeros(n * count, p + 1);
        for (h, (&horizon, end)) in HORIZONS.iter().zip(&ends).enumerate() {
            let (Some(moves), truth) = (moves.reached.get(h), window.measured(horizon)) else {
                return Ok(None);
            };
            for joint in 0..n {
                let (row, weight) = (joint * count + h, self.weights[h][joint]);
                weights[row] = weight;
                (0..p).for_each(|k| rows[(row, k)] = weight * moves[(joint, k)]);
                rows[(row, p)] = weight * (truth[joint] - end[joint]);
            }
        }
        if !rows.is_all_finite() {
            return Ok(None);
        }
        Ok(Some(BlockSums::new(0, rows.as_ref(), &weights, (n, Alike::Block))))
    }

    /// Takes ∂q/∂β to a state by the linear differential equation M δq̈ + D δq̇ + K δq + Y δβ = 0,
    /// whose column of a rotor on a shaft s is s sᵀq̈.
    fn follow(&self, state: [&[f64]; 3], moves: &mut Moves) -> Result<(), ModelError> {
        let [q, _, ddq] = state;
        let seconds = faer::Scale(moves.t - std::mem::replace(&mut moves.before, moves.t));
        let mass = self.torque.mass_matrix(q)?;
        let [stiffness, damping] = self.slopes(state)?;
        let turning = |shaft: &[f64]| shaft.iter().zip(ddq).map(|(s, a)| s * a).sum::<f64>();
        let pushed = Mat::from_fn(q.len(), self.rotors.len(), |joint, k| {
            self.rotors[k][joint] * turning(&self.rotors[k])
        });
        let pushed = pushed + &stiffness * &moves.position;
        let right = &mass * &moves.speed - seconds * pushed;
        // At the end of the step, as what holds a joint at rest is stiff.
        let whole = mass + seconds * (damping + seconds * stiffness);
        moves.speed = whole.partial_piv_lu().solve(right);
        moves.position += seconds * &moves.speed;
        if HORIZONS.iter().any(|horizon| (moves.t - horizon).abs() < 0.5 * TAKEN) {
            moves.reached.push(moves.position.clone());
        }
        Ok(())
    }

    /// ∂τ/∂q \[N·m/rad\] and ∂τ/∂q̇ \[N·m·s/rad\] at a state, n×n each.
    fn slopes(&self, [q, dq, ddq]: [&[f64]; 3]) -> Result<[Mat<f64>; 2], ModelError> {
        let n = q.len();
        let mut slopes = [Mat::zeros(n, n), Mat::zeros(n, n)];
        for joint in 0..n {
            for (which, slope) in slopes.iter_mut().enumerate() {
                let at = |change: f64| {
                    let mut state = [q.to_vec(), dq.to_vec()];
                    state[which][joint] += change;
                    self.torque.at(&state[0], &state[1], ddq)
                };
                let (above, below) = (at(CHANGE)?, at(-CHANGE)?);
                for i in 0..n {
                    slope[(i, joint)] = (above[i] - below[i]) / (2.0 * CHANGE);
                }
            }
        }
        Ok(slopes)
    }
}

#[cfg(test)]
mod tests {
    use super::{add_up_windows, drifts_of};
    use crate::plan::{ChainOptions, FrictionKind};
    use crate::rounds::Searched;
    use crate::{Plan, summary};
    use torquewise_sim::{Arm, MotionPlan, simulate};
    use torquewise_stepwise::progress::UNWATCHED;

    #[test]
    fn derivatives_are_those_of_the_simulation() {
        let plan = MotionPlan { seconds: 10.0, rate: 50.0, seed: 3, ..MotionPlan::default() };
        let log = simulate(&Arm::builtin("puma560-3").unwrap(), &plan).unwrap().motion;
        let options = ChainOptions { friction: FrictionKind::Linear, ..ChainOptions::default() };
        let sums = summary::summarise(&log, &Plan::from(options.clone()), "", UNWATCHED).unwrap();
        let survey = sums.survey.finish().unwrap();
        let searched = Searched::of(&survey, &options, (false, 0), None, UNWATCHED).unwrap();
        let mut at = searched.refined(UNWATCHED).unwrap().passes.at;
        let rotor = 30;
        at.linear[rotor] += 0.05;
        let weights = vec![vec![1.0; 3]; 2];
        let half_squares = |change: f64| {
            let mut at = at.clone();
            at.linear[rotor] += change;
            let drifts = drifts_of(&log, &at).unwrap();
            let rms = drifts.iter().flat_map(|own| own.rms_drift_rad.iter());
            0.5 * drifts[0].windows as f64 * rms.map(|rms| rms * rms).sum::<f64>()
        };

        let shafts = [vec![1.0, 0.0, 0.0]];
        let gram = add_up_windows(&log, &at, &shafts, &weights).unwrap().gram();

        assert!((half_squares(0.0) / (0.5 * gram[(1, 1)]) - 1.0).abs() < 1e-9);
        let slope = (half_squares(1e-4) - half_squares(-1e-4)) / 2e-4;
        assert!((-gram[(1, 0)] / slope - 1.0).abs() < 0.02, "{} {slope}", gram[(1, 0)]);
    }
}
