//! What the torque columns are: without gravity, or with a gain for each joint (E27).

use crate::few_rows::at_a_glance;
use crate::unseen::CHOICE_ROWS;
use crate::{
    HeldOut, Linearisation, Unseen, Warning, Watch, both_ways, first_look, geometric_mean, spread,
};
use faer::{Mat, MatRef};
use std::ops::Range;
use torquewise_model::{Kind, Model, Term, Torque};
use torquewise_motion::Motion;
use torquewise_regression::NormalEquations;
use torquewise_rigid::feasible::Factored;
use torquewise_rigid::{PER_BASE, PER_BODY};
use torquewise_stepwise::{IdentifyError, Survey, thinned};

/// Rows that are tried on.
const ROWS: usize = 2_000;
/// Taken for something else, torques must leave this part of what they leave as they are on held-out
/// rows, by time and by region.
const WORTH: f64 = 0.9;
/// Where nothing weighs, links leave less than this times what they leave, and do in 5 to 14 times on
/// arms of which gravity is logged.
const ALIKE: f64 = 1.1;
/// Gravity makes this part of the columns of links on joints that turn, or all axes stand upright.
const PULLED: f64 = 0.3;
/// Gravity that varies by less than this part of the torque of every joint is hardly any: of arms
/// whose currents show next to none it is 0.16.
const HARDLY: f64 = 0.1;
/// Gains and all other parameters are found anew so often at most, until no gain moves by this part.
const ROUNDS: (usize, f64) = (30, 1e-4);
/// A gain is held at that of the others where links load its joint by no more than a tenth of noise.
const HOLD: f64 = 0.01;
/// A round changes a gain by this factor at most.
const MOST_CHANGE: f64 = 1.5;
/// A gain within this factor of that of the joint which links load most is taken for the same:
/// torque sensors differ by as much, and what the links lack passes for it.
const SAME: f64 = 1.2;
/// So many of its errors; these are told from so many parts of the time, each left out in turn.
const TELLS: f64 = 3.0;
const PARTS: usize = 8;
const LEAST_PARTS: usize = 6;
/// Where links load a joint by less than so many times its noise, friction that no law holds says more of
/// its gain than they.
const FELT: f64 = 2.0;
/// Gains that are further apart are no gains.
const MOST_APART: f64 = 20.0;
/// What is left of held-out torque, in units of the least residual that weights are made of, below
/// which it is rounding, as of a log without noise: no reading of it is better.
const NOTHING: f64 = 0.01;
/// How often axes are searched anew with the gains put right.
const LOOKS: usize = 2;
/// Ridge on columns of unit length, which may be linearly dependent.
const RIDGE: f64 = 1e-8;

/// Whether links explain held-out torque as well where nothing weighs; or whether links that joints
/// share ask for gains of their own: a gain is not free, since the same mass loads several joints. Axes
/// that were learned from torques of unequal units lie elsewhere: they are searched anew with the gains
/// put right, and what is left of these is found there.
///
/// - returns: [`Warning::Weightless`] or [`Warning::Gains`]; `None` where what is logged is best taken
///   as torque
pub(crate) fn torque_kind(
    at: &Linearisation,
    (sample, dq_peak): (&Motion, &[f64]),
    seed: u64,
    watch: Watch<'_>,
) -> Result<Option<Warning>, IdentifyError> {
    let mut kind = kind_at(at, sample)?;
    let Some(Warning::Gains { gains, .. }) = &mut kind else { return Ok(kind) };
    // Of slides and coupled joints a glance knows nothing.
    let is_usual = at.geometry.kinds().all_turn() && at.geometry.coupling().is_none();
    let is_learned = at.free.iter().any(|parameter| *parameter >= PER_BASE);
    for _ in 0..if is_usual && is_learned { LOOKS } else { 0 } {
        let mut signals = thinned(sample, ROWS).into_signals();
        let right = |tau: Mat<f64>| {
            Mat::from_fn(tau.nrows(), tau.ncols(), |row, k| gains[k][0] * tau[(row, k)])
        };
        signals.tau = signals.tau.map(right);
        let motion = Motion::new(signals)?;
        let Ok(mut at) = at_a_glance((&motion, dq_peak), seed, watch) else { break };
        at.free = at.geometry.movable();
        let (columns, weights) = at.columns_of(&motion, true)?;
        let Some(left) = Gains::at(&at, &motion, (&columns, &weights)) else { break };
        for ([gain, error], [own, own_error]) in gains.iter_mut().zip(left.each()) {
            (*gain, *error) = (*gain * own, *gain * own_error);
        }
    }
    let is_apart = gains.iter().any(|[gain, _]| gain.ln().abs() > SAME.ln());
    Ok(kind.filter(|_| is_apart))
}

/// The same at axes as they are.
fn kind_at(at: &Linearisation, sample: &Motion) -> Result<Option<Warning>, IdentifyError> {
    let motion = thinned(sample, ROWS);
    let tau = motion.require_tau()?.to_owned();
    if motion.n_rows() < CHOICE_ROWS || tau.col_iter().all(|tau| spread(tau) == 0.0) {
        return Ok(None);
    }
    let (columns, weights) = at.columns_of(&motion, true)?;
    let targets = [(&tau, &tau)];
    let held_out = both_ways(&motion, sample);
    let left = |columns: &Mat<f64>| -> Option<Vec<f64>> {
        let of = |blocks: &Vec<HeldOut>| {
            let columns = (columns.clone(), weights.clone());
            let unseen = Unseen::of_columns(columns, motion.n_rows(), &targets, blocks)?;
            Some(unseen.errors_of_all()?.first()?.all())
        };
        held_out.iter().map(of).collect()
    };
    let Some(as_it_is) = left(&columns) else { return Ok(None) };
    if as_it_is.iter().all(|left| *left < NOTHING) {
        return Ok(None);
    }
    let leaves = |columns: &Mat<f64>, part: f64| {
        left(columns).is_some_and(|left| left.iter().zip(&as_it_is).all(|(a, b)| *a < part * b))
    };
    let (weightless, _) = at.columns_of(&motion, false)?;
    // On a slide, gravity and the offset of its sensor are one constant.
    let size = |columns: &Mat<f64>| -> f64 {
        let turning = (0..motion.n_joints()).filter(|&joint| !at.geometry.kinds().slides(joint));
        let rows = motion.n_rows();
        let of = |joint: usize| columns.subrows(joint * rows, rows).squared_norm_l2();
        turning.map(of).sum::<f64>().sqrt()
    };
    let pulled = size(&(&columns - &weightless));
    if pulled > PULLED * size(&columns) && leaves(&weightless, ALIKE) {
        return Ok(Some(Warning::Weightless));
    }
    let Some(gains) = Gains::at(at, &motion, (&columns, &weights)) else { return Ok(None) };
    let per = &gains.per;
    let is_apart = |joint: usize| {
        let error = gains.error(&|per| per[joint].ln());
        per[joint].ln().abs() > SAME.ln().max(TELLS * error)
    };
    let own: Vec<f64> =
        (0..per.len()).map(|joint| if is_apart(joint) { per[joint] } else { 1.0 }).collect();
    if !leaves(&gains.all.widened(&columns, &own, &gains.loads), WORTH) {
        return Ok(None);
    }
    Ok(Some(Warning::Gains { joints: sample.joints().to_vec(), gains: gains.each() }))
}

/// Whether gravity does nothing to the torques of logs to which nothing was fitted yet, by a chain that
/// is searched on few rows: [`Warning::Weightless`], or `None` where it does, where no chain is found,
/// where the watcher breaks, where no joint moves, or where one may slide, on which gravity is a constant.
pub fn weightless(survey: &Survey, seed: u64, watch: Watch<'_>) -> Option<Warning> {
    if survey.stands_still() {
        return None;
    }
    let look = first_look(&survey.sample, seed, watch).ok()?;
    if !look.kinds.all_turn() || !look.may_slide.is_empty() {
        return None;
    }
    let at = at_a_glance((&survey.sample, &survey.dq_peak), seed, watch).ok()?;
    kind_at(&at, &survey.sample).ok()?.filter(|found| *found == Warning::Weightless)
}

/// Whether gravity hardly has a part in the torques of a model.
pub(crate) fn hardly_weighs(model: &Model, sample: &Motion) -> Result<bool, IdentifyError> {
    let gravity = Torque::new(model).parts(&thinned(sample, ROWS))?.gravity;
    let torque = model.training.torque_std.iter().enumerate();
    let mut changing = torque.filter(|(_, std)| **std > 0.0);
    Ok(changing.all(|(joint, std)| spread(gravity.col(joint)) <= HARDLY * std))
}

/// Whether the terms of a library hold gravity.
pub(crate) fn has_gravity(model: &Model) -> bool {
    let all_turn = model.kinds().all_turn();
    let weighs = |(_, term): &(f64, Term)| {
        term.kind() == Kind::Gravity && (!term.factors.is_empty() || !all_turn)
    };
    model.equations().iter().flatten().any(weighs)
}

/// One over the gain of each joint beside that of one of them.
struct Gains {
    /// By all rows, n, and but for each part of the time.
    per: Vec<f64>,
    without: Vec<Vec<f64>>,
    /// Joints that links load by enough to tell their gain.
    felt: Vec<usize>,
    /// The parameters of the links, p×1.
    loads: Mat<f64>,
    all: JointRows,
}

impl Gains {
    /// Those of the rows of a motion at a linearisation; `None` where they are no gains.
    ///
    /// - `columns`: (m·n)×p, and what each row was multiplied by, m·n
    fn at(
        at: &Linearisation,
        motion: &Motion,
        (columns, weights): (&Mat<f64>, &[f64]),
    ) -> Option<Self> {
        let (tau, m) = (motion.tau()?, motion.n_rows());
        let drive = [PER_BODY * motion.n_joints(), at.linear.len()];
        let edge = |part: usize| part * m / PARTS;
        let part = |part: usize| {
            JointRows::new((columns, weights), tau, drive, &(edge(part)..edge(part + 1)))
        };
        let parts: Vec<JointRows> = (0..PARTS).map(part).collect();
        let all = JointRows::of(parts.iter())?;
        // The joint that links load most.
        let links = all.links(&at.linear);
        let load = |joint: usize| (links.transpose() * &all.sums[joint].gram * &links)[(0, 0)];
        let joints = 0..all.sums.len();
        let most = joints.max_by(|a, b| load(*a).total_cmp(&load(*b))).unwrap_or(0);
        let is_felt = |&joint: &usize| load(joint) > FELT.powi(2) * all.sums[joint].rows;
        let felt = (0..all.sums.len()).filter(is_felt).collect();
        let (per, loads) = all.gains(&at.linear, most)?;
        let others = |part: usize| parts[..part].iter().chain(&parts[part + 1..]);
        let without = |part: usize| Some(JointRows::of(others(part))?.gains(&at.linear, most)?.0);
        let without: Vec<Vec<f64>> = (0..parts.len()).filter_map(without).collect();
        (without.len() >= LEAST_PARTS).then_some(Self { per, without, felt, loads, all })
    }

    /// What a unit of each torque is worth beside the others, geometric mean 1, and its error, n: without
    /// end where links do not tell.
    fn each(&self) -> Vec<[f64; 2]> {
        let felt = |per: &[f64]| self.felt.iter().map(|&joint| per[joint]).collect::<Vec<f64>>();
        let gain = |per: &[f64], joint: usize| geometric_mean(&felt(per)) / per[joint];
        let of = |joint: usize| {
            if !self.felt.contains(&joint) {
                return [1.0, f64::INFINITY];
            }
            let own = gain(&self.per, joint);
            [own, own * self.error(&|per| gain(per, joint).ln())]
        };
        (0..self.per.len()).map(of).collect()
    }

    /// Standard error of what follows from them, by the jackknife.
    fn error(&self, of: &dyn Fn(&[f64]) -> f64) -> f64 {
        let (all, count) = (of(&self.per), self.without.len() as f64);
        let squares = self.without.iter().map(|part| (of(part) - all).powi(2));
        (squares.sum::<f64>() * (count - 1.0) / count).sqrt()
    }
}

/// Sums of the rows of each joint, of columns of which those from `drive[0]` to `drive[1]` are of its
/// drive alone, whatever its gain.
struct JointRows {
    /// Of p columns, n.
    sums: Vec<NormalEquations>,
    drive: [usize; 2],
}

impl JointRows {
    fn new(
        (columns, weights): (&Mat<f64>, &[f64]),
        tau: MatRef<'_, f64>,
        drive: [usize; 2],
        rows: &Range<usize>,
    ) -> Self {
        let (m, p) = (tau.nrows(), columns.ncols());
        let of = |joint: usize| {
            let first = joint * m + rows.start;
            let own = columns.submatrix(first, 0, rows.len(), p);
            let response = Mat::from_fn(rows.len(), 1, |row, _| {
                weights[first + row] * tau[(rows.start + row, joint)]
            });
            NormalEquations {
                gram: own.transpose() * own,
                cross: own.transpose() * &response,
                energy: vec![response.squared_norm_l2()],
                rows: rows.len() as f64,
            }
        };
        Self { sums: (0..tau.ncols()).map(of).collect(), drive }
    }

    fn of<'a>(parts: impl Iterator<Item = &'a Self>) -> Option<Self> {
        let parts: Vec<&Self> = parts.collect();
        let Self { sums, drive } = parts.first()?;
        let of = |joint: usize| parts.iter().map(|part| &part.sums[joint]).sum();
        Some(Self { sums: (0..sums.len()).map(of).collect(), drive: *drive })
    }

    /// Parameters, all but those of the links zero.
    fn links(&self, linear: &[f64]) -> Mat<f64> {
        let p = self.sums[0].n_columns();
        Mat::from_fn(p, 1, |k, _| if k < self.drive[0] { linear[k] } else { 0.0 })
    }

    fn factor(&self, per: f64, column: usize) -> f64 {
        if (self.drive[0]..self.drive[1]).contains(&column) { 1.0 } else { per }
    }

    /// One over the gain of each joint, n, beside that of the joint `most`, and the parameters of the
    /// links. `None` where they are no gains.
    fn gains(&self, linear: &[f64], most: usize) -> Option<(Vec<f64>, Mat<f64>)> {
        let (n, p) = (self.sums.len(), self.sums.first()?.n_columns());
        let mut links = self.links(linear);
        let others: Vec<usize> = (0..n).filter(|joint| *joint != most).collect();
        let mut per = vec![1.0; n];
        for _ in 0..ROUNDS.0 {
            let size = p + others.len();
            let (mut gram, mut right) = (Mat::zeros(size, size), Mat::zeros(size, 1));
            for (joint, equations) in self.sums.iter().enumerate() {
                let NormalEquations { gram: own, cross: response, rows, .. } = equations;
                let by = |k: usize| self.factor(per[joint], k);
                for i in 0..p {
                    right[(i, 0)] += by(i) * response[(i, 0)];
                    (0..p).for_each(|j| gram[(i, j)] += by(i) * by(j) * own[(i, j)]);
                }
                let Some(place) = others.iter().position(|other| *other == joint) else { continue };
                // What links load the joint by, once more.
                let load = faer::Scale(per[joint]) * own * &links;
                let place = p + place;
                for i in 0..p {
                    gram[(i, place)] = by(i) * load[(i, 0)];
                    gram[(place, i)] = gram[(i, place)];
                }
                let hold = HOLD * rows;
                gram[(place, place)] = hold + per[joint] * (links.transpose() * &load)[(0, 0)];
                right[(place, 0)] = per[joint] * (links.transpose() * response)[(0, 0)];
                right[(place, 0)] -= hold * per[joint].ln();
            }
            (0..size).for_each(|k| gram[(k, k)] *= 1.0 + RIDGE);
            let found = Factored::new(gram).ok()?.solve(right.col_as_slice(0));
            let mut moved = 0.0_f64;
            for (place, joint) in others.iter().enumerate() {
                let change = (1.0 + found[p + place]).clamp(1.0 / MOST_CHANGE, MOST_CHANGE);
                per[*joint] *= change;
                moved = moved.max((change - 1.0).abs());
            }
            (0..self.drive[0]).for_each(|k| links[(k, 0)] = found[k]);
            if moved < ROUNDS.1 {
                break;
            }
        }
        let extreme = |pick: fn(f64, f64) -> f64| per.iter().copied().reduce(pick);
        let apart = extreme(f64::max)? / extreme(f64::min)?;
        (apart < MOST_APART).then_some((per, links))
    }

    /// Columns of joints with gains of their own, and those by which these move.
    fn widened(&self, columns: &Mat<f64>, per: &[f64], links: &Mat<f64>) -> Mat<f64> {
        let (p, m) = (columns.ncols(), columns.nrows() / per.len());
        let loads = columns * links;
        Mat::from_fn(columns.nrows(), p + per.len(), |row, k| match k.checked_sub(p) {
            None => self.factor(per[row / m], k) * columns[(row, k)],
            Some(joint) if joint == row / m && (per[joint] - 1.0).abs() > 0.0 => loads[(row, 0)],
            Some(_) => 0.0,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::hardly_weighs;
    use faer::Mat;
    use torquewise_model::{EnergyTerm, Form, Model, Place, Term, Training, Trig, Weighted};
    use torquewise_motion::{Motion, Signals};

    #[test]
    fn gravity_that_is_next_to_nothing_of_the_torque_is_told() {
        let wave = |scale: f64| Mat::from_fn(200, 1, |row, _| scale * (0.1 * row as f64).sin());
        let t = (0..200).map(|row| 0.01 * f64::from(row)).collect();
        let (q, dq, ddq) = (wave(1.0), wave(10.0), wave(-100.0));
        let (joints, tau) = (vec!["joint1".to_owned()], Some(ddq.clone()));
        let log = Motion::new(Signals { joints, t, q, dq, ddq, tau }).unwrap();
        let of = |weight: f64| {
            let function = Term::one(1).times(Trig::Cos, 0, 1, 1);
            let potential = EnergyTerm { place: Place::Potential, function };
            let form = Form::Energy(vec![Weighted::new(potential, weight)]);
            let training =
                Training { torque_std: vec![0.5_f64.sqrt() * 100.0], ..Training::default() };
            Model { joints: vec!["joint1".into()], form, training, ..Model::default() }
        };

        assert!(hardly_weighs(&of(1.0), &log).unwrap());
        assert!(!hardly_weighs(&of(50.0), &log).unwrap());
    }
}
