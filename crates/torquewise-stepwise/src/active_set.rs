//! Kept terms: their first fit, their normal equations near it, and what noise does to these (E6)
//! (E7).

use crate::candidates::{Candidates, Group};
use crate::noise::NoiseFloor;
use crate::rows::fill_friction;
use crate::step::{of_joint, unexplained, weighted_problem};
use faer::Mat;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use torquewise_model::FrictionTerm;
use torquewise_regression::SparseError;
use torquewise_regression::normal_equations::{NormalEquations, Selection};
use torquewise_regression::normal_sums::{Alike, BlockSums, NormalSums};
use torquewise_regression::samples::{Evaluator, Samples};

/// The terms of one group to be fitted together.
#[derive(Clone, Debug)]
pub(crate) struct ActiveSet {
    pub(crate) group: Group,
    /// Columns of the library, ascending.
    pub(crate) columns: Vec<usize>,
    /// Weight of the rows of each joint: one over its noise variance.
    pub(crate) weights: Vec<f64>,
}

/// The largest weight of a row, a power of two squared: rows are then well within what exact sums
/// hold, and so is what they leave where torque is explained but for rounding.
const LARGEST: f64 = 4_294_967_296.0;

/// A group with its columns ready to be evaluated.
pub(crate) struct Fit<'a> {
    pub(crate) kept: ActiveSet,
    evaluator: Evaluator,
    /// Laws of friction whose values are among the variables.
    friction: &'a [FrictionTerm],
    pub(crate) noise: &'a NoiseFloor,
}

impl<'a> Fit<'a> {
    /// The weights of `kept` get a unit of their own, which changes no fit.
    pub(crate) fn new(
        mut kept: ActiveSet,
        candidates: &'a Candidates,
        noise: &'a NoiseFloor,
    ) -> Result<Self, SparseError> {
        let most = kept.weights.iter().fold(f64::MIN_POSITIVE, |most, weight| most.max(*weight));
        for weight in &mut kept.weights {
            *weight = *weight / most * LARGEST;
        }
        let evaluator = Evaluator::new(candidates.design.subset(&kept.columns)?);
        Ok(Self { kept, evaluator, friction: &candidates.friction, noise })
    }

    pub(crate) fn n_columns(&self) -> usize {
        self.kept.columns.len()
    }

    /// Rows √w·\[Y τ − Yβ\] of all joints, all instants of one after those of the one before.
    fn rows(&self, samples: &Samples, coefficients: &[f64]) -> Result<Mat<f64>, SparseError> {
        let columns = self.evaluator.columns(samples)?;
        let (m, p) = (samples.n_rows(), self.n_columns());
        let joints = self.kept.group.joints.iter().zip(&self.kept.weights);
        let mut rows = Mat::zeros(m * self.kept.weights.len(), p + 1);
        for (place, (&joint, &weight)) in joints.enumerate() {
            let (root, y) = (weight.sqrt(), &columns[if columns.len() == 1 { 0 } else { joint }]);
            let tau = samples.responses.col_as_slice(joint);
            for row in 0..m {
                let explained: f64 = (0..p).map(|j| coefficients[j] * y[(row, j)]).sum();
                let k = place * m + row;
                (0..p).for_each(|j| rows[(k, j)] = root * y[(row, j)]);
                rows[(k, p)] = root * (tau[row] - explained);
            }
        }
        Ok(rows)
    }

    /// What pieces of the sample say near a first fit, noise and its own spread included.
    ///
    /// - `coefficients`: where it is linearised
    /// - `draws`: times that noise is drawn for each row
    /// - `random`: seed and stream of the noise
    pub(crate) fn normal_sums<'s>(
        &self,
        coefficients: &[f64],
        draws: usize,
        (seed, stream): (u64, u64),
        pieces: impl Iterator<Item = &'s Samples>,
    ) -> Result<NormalSums, SparseError> {
        let weights = &self.kept.weights;
        let mut sums = NormalSums::new(self.n_columns(), weights.len(), 1);
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        random.set_stream(stream);
        let draws = if self.noise.is_none() { 0 } else { draws };
        for samples in pieces {
            let m = samples.n_rows();
            let roots = weights.iter().map(|weight| weight.sqrt());
            let roots: Vec<f64> = roots.flat_map(|root| std::iter::repeat_n(root, m)).collect();
            let rows = self.rows(samples, coefficients)?;
            let equations = (weights.len(), Alike::Instant);
            let mut block = BlockSums::new(0, rows.as_ref(), &roots, equations);
            // Noise drawn once more shows what noise did (E7).
            for _ in 0..draws {
                let drawn = self.noise.draw(&mut random, m);
                let (angles, rates) = drawn.split_at_col(self.noise.q.len());
                for sign in [1.0, -1.0] {
                    let mut shifted = samples.clone();
                    shifted.angles += faer::Scale(sign) * angles;
                    let mut moved = shifted.variables.subcols_mut(0, rates.ncols());
                    moved += faer::Scale(sign) * rates;
                    fill_friction(&mut shifted, self.friction);
                    let noisy = self.rows(&shifted, coefficients)?;
                    block.add_noisy(noisy.as_ref(), 0.5 / draws as f64);
                }
            }
            sums.add(&block)?;
        }
        Ok(sums)
    }
}

/// Where least squares leaves less than this part of the torque, squared, normal equations cannot
/// say how much less: they keep about 13 digits.
const EXPLAINED: f64 = 1e-10;

/// The normal equations of a group over all rows, its equations weighted and added up, with their
/// plain least-squares fit: where the refit begins (E6).
pub(crate) struct FirstFit {
    /// \[Y τ\]ᵀ\[Y τ\], (p+1)×(p+1).
    pub(crate) gram: Mat<f64>,
    rows: f64,
    /// Least-squares weights, p.
    pub(crate) coefficients: Vec<f64>,
    /// Columns that depend on others, ascending.
    pub(crate) dependent: Vec<usize>,
    /// Whether the torque is explained but for rounding.
    pub(crate) is_explained: bool,
}

impl FirstFit {
    /// - `grams`: of each equation over all rows
    pub(crate) fn new(kept: &ActiveSet, grams: &[NormalEquations]) -> Result<Self, SparseError> {
        let all: Vec<usize> = (0..kept.columns.len()).collect();
        let (joints, none) = (&kept.group.joints, vec![0.0; all.len()]);
        let equations = weighted_problem(grams, joints, &kept.weights, &none, &all)?;
        let Selection { coefficients, dependent, .. } = equations.refit(&all)?;
        let is_explained = joints.iter().all(|&joint| {
            let (gram, response) = of_joint(grams, joint);
            unexplained(grams, joint, &coefficients) <= EXPLAINED * gram.energy[response]
        });
        let (gram, rows) = (equations.joined(), equations.rows);
        Ok(Self { gram, rows, coefficients, dependent, is_explained })
    }

    /// A step of iterative refinement: least squares of what the coefficients leave of a sample,
    /// from \[Y e\]ᵀ\[Y e\] of all it stands for.
    pub(crate) fn refine(&mut self, left: &Mat<f64>) -> Result<(), SparseError> {
        self.gram = with_response(left, &self.coefficients);
        let all: Vec<usize> = (0..self.coefficients.len()).collect();
        let change = NormalEquations::of_joined(left, self.rows)?.refit(&all)?;
        self.dependent = change.dependent;
        let weights = self.coefficients.iter_mut().zip(change.coefficients);
        weights.for_each(|(weight, change)| *weight += change);
        Ok(())
    }
}

/// Sums in \[Y e\], e = τ − Yβ, as they are in \[Y τ\].
pub(crate) fn with_response(sums: &Mat<f64>, coefficients: &[f64]) -> Mat<f64> {
    let p = coefficients.len();
    let mut change = Mat::<f64>::identity(p + 1, p + 1);
    coefficients.iter().enumerate().for_each(|(j, c)| change[(j, p)] = *c);
    change.transpose() * (sums * &change)
}
