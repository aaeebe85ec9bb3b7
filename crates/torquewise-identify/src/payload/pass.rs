//! What a pass over a log says of a load on each link.

use super::rows::{Columns, Weights, visit};
use super::{STRENGTH, TOLD};
use crate::clustered::{Stretches, scatter, score};
use faer::{ColRef, Mat};
use nalgebra::Vector3;
use torquewise_model::{Model, RigidChain};
use torquewise_motion::Recording;
use torquewise_regression::NormalEquations;
use torquewise_rigid::feasible::{Factored, Prior, Quadratic, minimise};
use torquewise_rigid::inertia::{plain_link, seen_from};
use torquewise_rigid::{ChainError, PER_BODY, Placement};
use torquewise_stepwise::IdentifyError;

/// Stretches of time at most, and rows of each at least: a log for a load is short.
const STRETCHES: (usize, usize) = (256, 128);
/// Spread of a nominal load \[m\], and its least mass \[kg\].
const NOMINAL: (f64, f64) = (0.05, 1e-3);
/// Levers of a load whose mass gravity does not tell \[m\]: the longest, the ratio of two, and their
/// number.
const LEVERS: (f64, f64, i32) = (1.0, 0.7, 14);
/// A load is elsewhere, or the log lighter than the model, by more than so many standard errors.
const ELSEWHERE: f64 = 4.0;
/// It is where a joint leaves so many times what the model misses of other motion.
const TWICE: f64 = 2.0;
/// How much more than by all rows a known centre is held.
const HELD: f64 = 1e3;

/// What one pass over the rows adds up to, for a load on one link.
#[derive(Clone)]
pub(super) struct Pass {
    /// Of Y β = what the model leaves, ten columns, for each joint, n.
    pub(super) sums: Vec<Stretches>,
    /// Squares of what the model leaves of each joint, n.
    pub(super) squares: Vec<f64>,
    pub(super) rows: usize,
}

impl Pass {
    /// For a load on each link, n.
    pub(super) fn over(
        model: &Model,
        chain: &RigidChain,
        recording: &(impl Recording + ?Sized),
    ) -> Result<Vec<Self>, IdentifyError> {
        model.check_joints(recording.joints())?;
        let n = model.n_joints();
        let (weights, mut columns) = (Weights::of(model), Columns::of(chain)?);
        let (most, rows) = STRETCHES;
        let sums = vec![Stretches::new(PER_BODY, most, rows); n];
        let mut passes = vec![Self { sums, squares: vec![0.0; n], rows: 0 }; n];
        let mut y = Mat::zeros(n, PER_BODY * n);
        visit(model, recording, &mut |block, left, _| {
            for row in 0..block.n_rows() {
                let state = block.state(row);
                columns.at(state.each_ref().map(Vec::as_slice), &mut y);
                for (link, pass) in passes.iter_mut().enumerate() {
                    for (joint, sums) in pass.sums.iter_mut().enumerate() {
                        let (weight, error) =
                            (weights.square(joint, state[1][joint]), left[(row, joint)]);
                        let own: [f64; PER_BODY] =
                            std::array::from_fn(|k| y[(joint, PER_BODY * link + k)]);
                        sums.add(&own, error, weight);
                        pass.squares[joint] += error * error;
                    }
                    pass.rows += 1;
                }
            }
            Ok(())
        })?;
        Ok(passes)
    }

    /// The load among bodies that can be, with what it is held at, and the information.
    ///
    /// - `center`: of mass, where it is known
    pub(super) fn solved(
        &self,
        center: Option<Vector3<f64>>,
    ) -> Result<(Vec<f64>, Prior, Mat<f64>), IdentifyError> {
        let NormalEquations { mut gram, cross, .. } = self.total();
        let right = cross.col_as_slice(0);
        if let Some(center) = center {
            let hold = HELD * (1..4).map(|k| gram[(k, k)]).sum::<f64>();
            for (k, lever) in (1..4).zip(&center) {
                gram[(k, k)] += hold;
                gram[(0, k)] -= hold * lever;
                gram[(k, 0)] -= hold * lever;
                gram[(0, 0)] += hold * lever * lever;
            }
        }
        let cost = Quadratic { hessian: &gram, right };
        let mut best = None;
        let mut least = f64::INFINITY;
        for nominal in self.likely(&gram, right) {
            let prior = Prior { bodies: vec![nominal], ..Prior::default() };
            let solution = minimise(cost, &prior, STRENGTH, &nominal)?;
            let held = prior.value(&solution).unwrap_or(f64::INFINITY);
            let left = cost.value(&solution) + STRENGTH * held;
            if left < least {
                (best, least) = (Some((solution, prior)), left);
            }
        }
        let (solution, prior) = best.ok_or(ChainError::Singular)?;
        Ok((solution, prior, gram))
    }

    /// How far each joint is from what it would say of how heavy the load is, what its square may be,
    /// and the information that it has: xᵀs, its variance, xᵀHx.
    ///
    /// - `arm`: what the uncertain arm makes of the scores of a joint, 10×10
    fn heaviness(&self, load: &[f64], arm: &dyn Fn(usize) -> Option<Mat<f64>>) -> Vec<[f64; 3]> {
        let x = ColRef::from_slice(load).as_mat();
        let along = |square: &Mat<f64>| (x.transpose() * square * x)[(0, 0)];
        let of = |(joint, own): (usize, &Stretches)| {
            let total = own.total();
            let allowed = along(&scatter(own.all().map(|own| score(own, x))))
                + arm(joint).map_or(0.0, |arm| along(&arm));
            [(x.transpose() * score(&total, x))[(0, 0)], allowed, along(&total.gram)]
        };
        self.sums.iter().enumerate().map(of).collect()
    }

    /// What equations of each joint count, given how they err together and how uncertain the arm is,
    /// beside equations that err apart, n: at most 1.
    pub(super) fn counts(&self, load: &[f64], arm: &dyn Fn(usize) -> Option<Mat<f64>>) -> Vec<f64> {
        let counts = |[_, allowed, information]: [f64; 3]| {
            if allowed > information { information / allowed } else { 1.0 }
        };
        self.heaviness(load, arm).into_iter().map(counts).collect()
    }

    pub(super) fn weighted(&self, counts: &[f64]) -> Self {
        let sums = self.sums.iter().zip(counts).map(|(own, by)| own.weighted(*by)).collect();
        Self { sums, squares: self.squares.clone(), rows: self.rows }
    }

    /// How far joints disagree about how heavy the load is, over what their errors allow (Birge):
    /// √(χ² / (n − 1)), at least 1.
    pub(super) fn disagreement(
        &self,
        load: &[f64],
        arm: &dyn Fn(usize) -> Option<Mat<f64>>,
    ) -> f64 {
        let all = self.heaviness(load, arm);
        let told = all.iter().filter(|[_, allowed, _]| *allowed > 0.0);
        let squares: Vec<f64> =
            told.map(|[excess, allowed, _]| excess * excess / allowed).collect();
        let degrees = f64::max(squares.len() as f64 - 1.0, 1.0);
        f64::max(squares.iter().sum::<f64>() / degrees, 1.0).sqrt()
    }

    /// The link on which a load leaves least, if significantly less than one on `link`.
    pub(super) fn better(passes: &[Self], link: usize) -> Option<usize> {
        let left = |pass: &Self| -> Option<Vec<f64>> {
            let (load, ..) = pass.solved(None).ok()?;
            Some(pass.stretches().map(|own| own.residual_energy(&load, 0)).collect())
        };
        let all: Vec<Option<Vec<f64>>> = passes.iter().map(left).collect();
        let sum = |left: &[f64]| left.iter().sum::<f64>();
        let some = all.iter().enumerate().filter_map(|(link, left)| Some((link, left.as_ref()?)));
        let (best, least) = some.min_by(|a, b| sum(a.1).total_cmp(&sum(b.1)))?;
        let own = all[link].as_ref()?;
        let gained: Vec<f64> = own.iter().zip(least).map(|(own, least)| own - least).collect();
        let mean = sum(&gained) / gained.len() as f64;
        let error = gained.iter().map(|gain| (gain - mean).powi(2)).sum::<f64>().sqrt();
        (best != link && sum(&gained) > ELSEWHERE * error).then_some(best)
    }

    /// All joints together, stretch by stretch.
    pub(super) fn stretches(&self) -> impl Iterator<Item = NormalEquations> {
        let all: Vec<Vec<&NormalEquations>> =
            self.sums.iter().map(|own| own.all().collect()).collect();
        let count = all.first().map_or(0, Vec::len);
        (0..count).map(move |k| all.iter().map(|stretches| stretches[k]).sum())
    }

    pub(super) fn total(&self) -> NormalEquations {
        self.stretches().collect::<Vec<_>>().iter().sum()
    }

    pub(super) fn scatter(&self, load: &[f64]) -> Mat<f64> {
        scatter(self.stretches().map(|own| score(&own, ColRef::from_slice(load).as_mat())))
    }

    /// By how much the log is lighter than the model \[kg\], if it significantly is.
    ///
    /// - `arm`: what the uncertain arm makes of the scores, 10×10
    /// - `usual`: what the model misses of any motion \[N·m\], n, which is no sign of another load
    pub(super) fn lighter(&self, arm: Option<&Mat<f64>>, usual: &[f64]) -> Option<f64> {
        let most = |usual: &f64| self.rows as f64 * (TWICE * usual).powi(2);
        let is_more = |(squares, usual): (&f64, &f64)| *squares > most(usual);
        if !usual.is_empty() && !self.squares.iter().zip(usual).any(is_more) {
            return None;
        }
        let NormalEquations { gram, cross, .. } = self.total();
        let (found, uncertain) = self.weighed(&gram, cross.col_as_slice(0), arm);
        (found[0] < -ELSEWHERE * uncertain).then_some(-found[0])
    }

    /// Mass and first moment that gravity says, positive or not, and the error of the mass \[kg\].
    fn weighed(
        &self,
        information: &Mat<f64>,
        right: &[f64],
        arm: Option<&Mat<f64>>,
    ) -> (Vec<f64>, f64) {
        // Gravity tells mass and first moment; a little of each keeps what it does not tell at zero.
        let ridge = |k: usize| 1e-9 * information[(k, k)] + 1e-12 * information[(0, 0)] + 1e-30;
        let first =
            Mat::from_fn(4, 4, |i, j| information[(i, j)] + if i == j { ridge(i) } else { 0.0 });
        let mut found = vec![0.0; PER_BODY];
        let mut uncertain = 0.0;
        if let Ok(factor) = Factored::new(first) {
            found[..4].copy_from_slice(&factor.solve(&right[..4]));
            let mut scatter = self.scatter(&found);
            if let Some(arm) = arm {
                scatter += arm;
            }
            let scatter = scatter.submatrix(0, 0, 4, 4).to_owned();
            uncertain = factor.sandwiched(&scatter)[(0, 0)].max(0.0).sqrt();
        }
        (found, uncertain)
    }

    /// Loads that may well be, of the first moment that gravity says: of the mass that it says, or where
    /// it says none, of those that have it at some lever.
    fn likely(&self, information: &Mat<f64>, right: &[f64]) -> Vec<[f64; PER_BODY]> {
        let (found, uncertain) = self.weighed(information, right, None);
        let moment = Vector3::new(found[1], found[2], found[3]);
        let of = |mass: f64| {
            let mass = mass.max(NOMINAL.1);
            let round = plain_link(mass, &Vector3::zeros(), NOMINAL.0);
            let origin = (moment / mass).map(|center| center.clamp(-1.0, 1.0));
            seen_from(&round, &Placement { rotation: nalgebra::Matrix3::identity(), origin })
        };
        if uncertain < TOLD.0 * found[0] {
            return vec![of(found[0])];
        }
        let (longest, ratio, count) = LEVERS;
        (0..count).map(|k| of(moment.norm() / (longest * ratio.powi(k)))).collect()
    }
}
