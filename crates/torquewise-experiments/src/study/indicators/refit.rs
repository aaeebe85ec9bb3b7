//! From kept terms, weighted rows to coefficients \[E6\], with and without the noise correction
//! \[E7\].

use crate::error::ExperimentError;
use crate::study::indicators::first_fit::FirstFit;
use crate::study::indicators::steps::{Selected, add_gram};
use faer::Mat;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use torquewise_regression::elimination::{Equations, Estimate};
use torquewise_regression::problem::Problem;
use torquewise_regression::samples::{Evaluator, Samples};
use torquewise_stepwise::candidates::Group;

/// A coefficient whose column adds less than this part of the torque cannot be told from rounding.
const PRECISION: f64 = 1e-11;
/// The same noise is drawn for all ways to weigh the rows of a log.
const SEED: u64 = 17;

/// (column, coefficient) of each group.
pub(super) type Coefficients = Vec<Vec<(usize, f64)>>;

/// Fits the selected terms of each group together on weighted rows, and lets the weakest leave.
///
/// - `weights`: weight of each row in the equation of each joint, m×n
/// - returns: the fit with the bias of noise in q, q̇, q̈ taken out, and the plain one
pub(super) fn refit(
    first: &FirstFit,
    selected: &Selected,
    weights: &Mat<f64>,
) -> Result<[Coefficients; 2], ExperimentError> {
    let threshold = first.criterion.threshold(first.n_rows() as f64, first.candidates.len());
    let mut found = [Vec::new(), Vec::new()];
    for (place, group) in first.groups.iter().enumerate() {
        let kept: Vec<usize> = (0..first.candidates.len())
            .filter(|&column| selected.coefficients[place][column] != 0.0)
            .collect();
        let evaluator = Evaluator::new(first.candidates.design.subset(&kept)?);
        let fit = Fit { group, evaluator, weights, by: &selected.equation_weights[place] };
        let estimates = fit.estimates(first, threshold)?;
        for (found, estimate) in found.iter_mut().zip(estimates) {
            let terms = estimate.active.iter().zip(&estimate.coefficients);
            found.push(terms.map(|(&j, &coefficient)| (kept[j], coefficient)).collect());
        }
    }
    Ok(found)
}

/// Rows \[Y τ\] of an equation, m×(p+1), and their weights, m.
type WeightedRows = (Mat<f64>, Vec<f64>);

/// The kept columns of a group, ready to be evaluated.
struct Fit<'a> {
    group: &'a Group,
    evaluator: Evaluator,
    weights: &'a Mat<f64>,
    /// Weight of each equation.
    by: &'a [f64],
}

impl Fit<'_> {
    fn n_columns(&self) -> usize {
        self.evaluator.design().n_columns()
    }

    /// \[Y τ\] and the weights of its rows, equation by equation.
    fn equations(&self, samples: &Samples) -> Result<Vec<WeightedRows>, ExperimentError> {
        let columns = self.evaluator.columns(samples)?;
        let p = self.n_columns();
        let one = |(&(equation, joint), by): (&(usize, usize), &f64)| {
            let (y, tau) = (&columns[equation], samples.responses.col_as_slice(joint));
            let rows =
                Mat::from_fn(y.nrows(), p + 1, |t, j| if j < p { y[(t, j)] } else { tau[t] });
            let weights = self.weights.col_as_slice(joint).iter().map(|w| w * by).collect();
            (rows, weights)
        };
        Ok(self.group.equations.iter().zip(self.by).map(one).collect())
    }

    /// \[Y τ\]ᵀU\[Y τ\] of all equations, lower triangle.
    fn gram(&self, samples: &Samples) -> Result<Mat<f64>, ExperimentError> {
        let mut gram = Mat::zeros(self.n_columns() + 1, self.n_columns() + 1);
        for (rows, weights) in self.equations(samples)? {
            add_gram(&mut gram, &rows, &weights);
        }
        Ok(gram)
    }

    /// What the noise did to the Gram matrix, seen by doing it once more (E7).
    fn bias(&self, first: &FirstFit, still: &Mat<f64>) -> Result<Mat<f64>, ExperimentError> {
        let noise = &first.noise;
        let rates: Vec<f64> = noise.dq.iter().chain(&noise.ddq).copied().collect();
        let mut random = ChaCha8Rng::seed_from_u64(SEED);
        let angles = draw(&mut random, first.n_rows(), &noise.q);
        let variables = draw(&mut random, first.n_rows(), &rates);
        let mut bias = faer::Scale(-1.0) * still;
        for sign in [1.0, -1.0] {
            let mut moved = first.samples.clone();
            moved.angles += faer::Scale(sign) * &angles;
            moved.variables += faer::Scale(sign) * &variables;
            bias += faer::Scale(0.5) * self.gram(&moved)?;
        }
        Ok(bias)
    }

    /// The estimates with and without the correction for noise.
    fn estimates(&self, first: &FirstFit, least: f64) -> Result<[Estimate; 2], ExperimentError> {
        let p = self.n_columns();
        let gram = self.gram(&first.samples)?;
        let none = Mat::zeros(p + 1, p + 1);
        let bias = if first.noise.is_none() { none.clone() } else { self.bias(first, &gram)? };
        let lower = |sums: &Mat<f64>, i: usize, j: usize| sums[(i.max(j), i.min(j))];
        let right = (0..p).map(|j| gram[(p, j)]).collect();
        let plain = Mat::from_fn(p, p, |i, j| lower(&gram, i, j));
        let problem = Problem::new(plain, right, gram[(p, p)], first.n_rows().max(1) as f64)?;
        let start = problem.refit(&(0..p).collect::<Vec<_>>())?;
        let spread = self.spread(&first.samples, &start.coefficients)?;
        let floor = |j| PRECISION * (gram[(p, p)].max(f64::MIN_POSITIVE) / gram[(j, j)]).sqrt();
        let estimate = |bias: &Mat<f64>| -> Result<Estimate, ExperimentError> {
            let information = |i, j| lower(&gram, i, j) - lower(bias, i, j);
            let mut equations = Equations {
                information: Mat::from_fn(p, p, information),
                right: (0..p).map(|j| information(j, p)).collect(),
                spread: spread.clone(),
                floor: (0..p).map(floor).collect(),
            };
            for &j in &start.dependent {
                equations.information[(j, j)] = 0.0;
            }
            // Where the corrected equations cannot be solved, the plain fit stands.
            let plain = || Estimate {
                coefficients: start.active.iter().map(|&j| start.coefficients[j]).collect(),
                std_errors: vec![0.0; start.active.len()],
                active: start.active.clone(),
            };
            Ok(equations.eliminate(least).unwrap_or_else(plain))
        };
        Ok([estimate(&bias)?, estimate(&none)?])
    }

    /// Covariance of the scores, one cluster per row: equations of an instant share its noise.
    fn spread(&self, samples: &Samples, coefficients: &[f64]) -> Result<Mat<f64>, ExperimentError> {
        let (m, p) = (samples.n_rows(), self.n_columns());
        let mut scores = Mat::<f64>::zeros(m, p);
        for (rows, weights) in self.equations(samples)? {
            let mut residual = rows.col_as_slice(p).to_vec();
            for (j, c) in coefficients.iter().enumerate() {
                let column = rows.col_as_slice(j);
                residual.iter_mut().zip(column).for_each(|(r, y)| *r -= c * y);
            }
            residual.iter_mut().zip(&weights).for_each(|(r, w)| *r *= w);
            for j in 0..p {
                let terms = rows.col_as_slice(j).iter().zip(&residual);
                let score = scores.col_as_slice_mut(j).iter_mut();
                score.zip(terms).for_each(|(score, (y, r))| *score += y * r);
            }
        }
        let sums: Vec<f64> = (0..p).map(|j| scores.col_as_slice(j).iter().sum()).collect();
        let products = scores.transpose() * &scores;
        Ok(Mat::from_fn(p, p, |i, j| products[(i, j)] - sums[i] * sums[j] / m.max(1) as f64))
    }
}

/// Independent normal noise of the given standard deviations, rows × deviations.
fn draw(random: &mut ChaCha8Rng, rows: usize, deviations: &[f64]) -> Mat<f64> {
    let mut out = Mat::zeros(rows, deviations.len());
    for (j, &sigma) in deviations.iter().enumerate() {
        for value in out.col_as_slice_mut(j) {
            let unit: f64 = StandardNormal.sample(random);
            *value = sigma * unit;
        }
    }
    out
}
