//! Kept terms, all rows → final coefficients and standard errors: QR, noise bias out [E6] [E7].

use crate::candidates::{Candidates, Group};
use crate::error::IdentifyError;
use crate::noise::NoiseFloor;
use crate::rows::samples_of;
use faer::Mat;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use torquewise_motion::Recording;
use torquewise_sparse::SparseError;
use torquewise_sparse::accumulate::{Accumulate, Lanes};
use torquewise_sparse::elimination::{Equations, Estimate};
use torquewise_sparse::samples::{Evaluator, Samples};
use torquewise_sparse::triangle::Triangle;

/// The terms of one group to be fitted together.
#[derive(Clone, Debug)]
pub(crate) struct Kept {
    pub(crate) group: Group,
    /// Columns of the library, ascending.
    pub(crate) columns: Vec<usize>,
    /// Weight of the rows of each equation: one over its noise variance.
    pub(crate) weights: Vec<f64>,
}

/// The fit of one group.
#[derive(Clone, Debug)]
pub(crate) struct Refitted {
    /// (column of the library, coefficient, standard error)
    pub(crate) weights: Vec<(usize, f64, f64)>,
    /// Columns that say nothing the others do not say.
    pub(crate) dependent: Vec<usize>,
    /// RMS of the residual of each equation \[N·m\].
    pub(crate) residual_rms: Vec<f64>,
}

/// How kept terms are fitted.
#[derive(Clone, Debug)]
pub(crate) struct RefitPlan<'a> {
    pub(crate) noise: &'a NoiseFloor,
    pub(crate) seed: u64,
    /// Terms of less t² leave.
    pub(crate) least_t_squared: f64,
    /// Terms of at most this size leave.
    pub(crate) least_size: f64,
}

/// A coefficient whose column adds less than this part of the torque cannot be told from rounding.
const PRECISION: f64 = 1e-11;

/// Fits the kept terms of all groups on all rows, in two passes: the factors, then the residuals.
pub(crate) fn refit(
    recording: &(impl Recording + ?Sized),
    candidates: &Candidates,
    kept: &[Kept],
    plan: &RefitPlan<'_>,
) -> Result<Vec<Refitted>, IdentifyError> {
    let evaluators = kept
        .iter()
        .map(|kept| Ok(Evaluator::new(candidates.design.subset(&kept.columns)?)))
        .collect::<Result<Vec<_>, SparseError>>()?;
    let fits: Vec<Fit<'_>> = kept
        .iter()
        .zip(&evaluators)
        .map(|(kept, evaluator)| Fit { kept, evaluator, noise: plan.noise })
        .collect();
    let factors = pass(recording, &fits, |fit, lane| FactorSum::new(fit, plan.seed, lane))?;
    let first: Vec<Start> = factors.iter().map(FactorSum::solve).collect::<Result<_, _>>()?;
    let scores = {
        let starts: Vec<(&Fit<'_>, &[f64])> =
            fits.iter().zip(&first).map(|(fit, start)| (fit, &start.coefficients[..])).collect();
        pass(recording, &starts, |&(fit, coefficients), _| ScoreSum::new(fit, coefficients))?
    };
    fits.iter()
        .zip(factors.iter().zip(&first))
        .zip(&scores)
        .map(|((fit, (factor, start)), score)| finish(fit, factor, start, score, plan))
        .collect()
}

/// Hands every block to a sum for each group.
fn pass<'a, T, A: Accumulate>(
    recording: &(impl Recording + ?Sized),
    groups: &'a [T],
    start: impl Fn(&'a T, usize) -> A,
) -> Result<Vec<A>, IdentifyError> {
    let mut lanes: Vec<Lanes<A>> =
        groups.iter().map(|group| Lanes::new(SUM_BYTES, |lane| start(group, lane))).collect();
    recording
        .read(&mut |_, block| {
            let samples = samples_of(block)?;
            Ok(lanes.iter_mut().try_for_each(|lanes| lanes.push(samples.clone()))?)
        })
        .map_err(IdentifyError::Read)?;
    lanes.into_iter().map(|lanes| Ok(lanes.finish()?)).collect()
}

/// Nominal size of a sum: eight lanes.
const SUM_BYTES: usize = 16 << 20;

#[derive(Clone, Copy)]
struct Fit<'a> {
    kept: &'a Kept,
    evaluator: &'a Evaluator,
    noise: &'a NoiseFloor,
}

impl Fit<'_> {
    fn n_columns(&self) -> usize {
        self.kept.columns.len()
    }

    /// (matrix of columns, response, weight) of each equation.
    fn equations<'s>(
        &'s self,
        columns: &'s [Mat<f64>],
        samples: &'s Samples,
    ) -> impl Iterator<Item = (&'s Mat<f64>, &'s [f64], f64)> {
        self.kept.group.equations.iter().zip(&self.kept.weights).map(
            |(&(equation, response), &weight)| {
                (&columns[equation], samples.responses.col_as_slice(response), weight)
            },
        )
    }
}

/// R of \[Y τ\], and what noise in the rows adds to YᵀY and Yᵀτ.
struct FactorSum<'a> {
    fit: &'a Fit<'a>,
    triangle: Triangle,
    /// \[Y τ\]ᵀ\[Y τ\] as noise changes it, (p+1)×(p+1).
    bias: Mat<f64>,
    random: ChaCha8Rng,
}

impl<'a> FactorSum<'a> {
    fn new(fit: &'a Fit<'a>, seed: u64, lane: usize) -> Self {
        let size = fit.n_columns() + 1;
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        random.set_stream(lane as u64);
        Self { fit, triangle: Triangle::new(size), bias: Mat::zeros(size, size), random }
    }

    /// Rows √w·\[Y τ\] of all equations.
    fn rows(&self, samples: &Samples) -> Result<Vec<Mat<f64>>, SparseError> {
        let columns = self.fit.evaluator.columns(samples)?;
        let p = self.fit.n_columns();
        let rows = self.fit.equations(&columns, samples).map(|(y, tau, weight)| {
            let root = weight.sqrt();
            Mat::from_fn(y.nrows(), p + 1, |row, j| {
                root * if j < p { y[(row, j)] } else { tau[row] }
            })
        });
        Ok(rows.collect())
    }

    /// What the noise did to the sums, seen by doing it once more: with ε drawn as the noise is, and
    /// −ε beside it so that odd powers cancel, E\[½(S(z+ε) + S(z−ε)) − S(z)\] = E\[S(z)\] − S(true).
    fn probe(&mut self, samples: &Samples, rows: &[Mat<f64>]) -> Result<(), SparseError> {
        let noise = self.fit.noise;
        let rates: Vec<f64> = noise.dq.iter().chain(&noise.ddq).copied().collect();
        let angles = draw(&mut self.random, samples.n_rows(), &noise.q);
        let variables = draw(&mut self.random, samples.n_rows(), &rates);
        for sign in [1.0, -1.0] {
            let shifted = Samples {
                angles: &samples.angles + faer::Scale(sign) * &angles,
                variables: &samples.variables + faer::Scale(sign) * &variables,
                responses: samples.responses.clone(),
            };
            for (moved, still) in self.rows(&shifted)?.iter().zip(rows) {
                add_gram(&mut self.bias, moved, 0.5);
                add_gram(&mut self.bias, still, -0.5);
            }
        }
        Ok(())
    }

    /// The plain fit, with the columns that depend on others found out.
    fn solve(&self) -> Result<Start, SparseError> {
        let p = self.fit.n_columns();
        let gram = self.triangle.r().transpose() * self.triangle.r();
        let corner = gram[(p, p)];
        let plain = Mat::from_fn(p, p, |i, j| gram[(i, j)]);
        let right = (0..p).map(|j| gram[(j, p)]).collect();
        let rows = self.triangle.rows().max(1) as f64;
        let problem = torquewise_sparse::problem::Problem::new(plain, right, corner, rows)?;
        let all: Vec<usize> = (0..p).collect();
        let fit = problem.refit(&all)?;
        Ok(Start { coefficients: fit.coefficients, dependent: fit.dependent })
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

fn add_gram(target: &mut Mat<f64>, rows: &Mat<f64>, weight: f64) {
    faer::linalg::matmul::matmul(
        target.as_mut(),
        faer::Accum::Add,
        rows.transpose(),
        rows.as_ref(),
        weight,
        faer::Par::Seq,
    );
}

impl Accumulate for FactorSum<'_> {
    fn add(&mut self, samples: &Samples) -> Result<(), SparseError> {
        let rows = self.rows(samples)?;
        rows.iter().try_for_each(|rows| self.triangle.add(rows.as_ref()))?;
        if self.fit.noise.is_none() { Ok(()) } else { self.probe(samples, &rows) }
    }

    fn merge(&mut self, other: Self) -> Result<(), SparseError> {
        self.bias += &other.bias;
        self.triangle.merge(&other.triangle)
    }
}

struct Start {
    coefficients: Vec<f64>,
    dependent: Vec<usize>,
}

/// Residuals of a fit, and the spread of its scores: rows of all equations at one instant share the
/// noise of that instant, so they count as one.
struct ScoreSum<'a> {
    fit: &'a Fit<'a>,
    coefficients: &'a [f64],
    squares: Vec<f64>,
    sum: Vec<f64>,
    spread: Mat<f64>,
    rows: usize,
}

impl<'a> ScoreSum<'a> {
    fn new(fit: &'a Fit<'a>, coefficients: &'a [f64]) -> Self {
        let p = fit.n_columns();
        Self {
            fit,
            coefficients,
            squares: vec![0.0; fit.kept.group.equations.len()],
            sum: vec![0.0; p],
            spread: Mat::zeros(p, p),
            rows: 0,
        }
    }

    /// Covariance of the summed scores.
    fn covariance(&self) -> Mat<f64> {
        let m = self.rows.max(1) as f64;
        let p = self.sum.len();
        Mat::from_fn(p, p, |i, j| self.spread[(i, j)] - self.sum[i] * self.sum[j] / m)
    }
}

impl Accumulate for ScoreSum<'_> {
    fn add(&mut self, samples: &Samples) -> Result<(), SparseError> {
        let columns = self.fit.evaluator.columns(samples)?;
        let p = self.fit.n_columns();
        let mut scores = Mat::<f64>::zeros(samples.n_rows(), p);
        for ((y, tau, weight), squares) in
            self.fit.equations(&columns, samples).zip(&mut self.squares)
        {
            let mut residual = tau.to_vec();
            for (j, &coefficient) in self.coefficients.iter().enumerate() {
                for (r, y) in residual.iter_mut().zip(y.col_as_slice(j)) {
                    *r -= coefficient * y;
                }
            }
            *squares += residual.iter().map(|r| r * r).sum::<f64>();
            for j in 0..p {
                let terms = y.col_as_slice(j).iter().zip(&residual);
                for (score, (y, r)) in scores.col_as_slice_mut(j).iter_mut().zip(terms) {
                    *score += weight * y * r;
                }
            }
        }
        for (sum, column) in self.sum.iter_mut().zip(scores.col_iter()) {
            *sum += column.iter().sum::<f64>();
        }
        add_gram(&mut self.spread, &scores, 1.0);
        self.rows += samples.n_rows();
        Ok(())
    }

    fn merge(&mut self, other: Self) -> Result<(), SparseError> {
        self.squares.iter_mut().zip(&other.squares).for_each(|(a, b)| *a += b);
        self.sum.iter_mut().zip(&other.sum).for_each(|(a, b)| *a += b);
        self.spread += &other.spread;
        self.rows += other.rows;
        Ok(())
    }
}

fn finish(
    fit: &Fit<'_>,
    factor: &FactorSum<'_>,
    start: &Start,
    score: &ScoreSum<'_>,
    plan: &RefitPlan<'_>,
) -> Result<Refitted, IdentifyError> {
    let p = fit.n_columns();
    let gram = factor.triangle.r().transpose() * factor.triangle.r();
    let reference = gram[(p, p)].max(f64::MIN_POSITIVE);
    let mut equations = Equations {
        information: Mat::from_fn(p, p, |i, j| gram[(i, j)] - factor.bias[(i, j)]),
        right: (0..p).map(|j| gram[(j, p)] - factor.bias[(j, p)]).collect(),
        spread: score.covariance(),
        floor: (0..p).map(|j| PRECISION * (reference / gram[(j, j)]).sqrt()).collect(),
    };
    for &column in &start.dependent {
        equations.information[(column, column)] = 0.0;
    }
    let residual_rms =
        score.squares.iter().map(|s| (s / score.rows.max(1) as f64).sqrt()).collect();
    let mut estimate = equations.eliminate(plan.least_t_squared)?.unwrap_or_else(|| Estimate {
        active: (0..p).filter(|j| !start.dependent.contains(j)).collect(),
        coefficients: start.coefficients.clone(),
        std_errors: vec![0.0; p],
    });
    let large = |c: &f64| c.abs() > plan.least_size;
    if !estimate.coefficients.iter().all(large) {
        let keep: Vec<usize> = (0..estimate.active.len())
            .filter(|&place| large(&estimate.coefficients[place]))
            .collect();
        for (place, &column) in estimate.active.iter().enumerate() {
            if !keep.contains(&place) {
                equations.information[(column, column)] = 0.0;
            }
        }
        if let Some(smaller) = equations.eliminate(0.0)? {
            estimate = smaller;
        }
    }
    let exact = sharpen(factor, &estimate)?;
    let weights = estimate
        .active
        .iter()
        .zip(exact.iter().zip(&estimate.std_errors))
        .map(|(&j, (&coefficient, &std_error))| (fit.kept.columns[j], coefficient, std_error))
        .collect();
    let dependent = start.dependent.iter().map(|&j| fit.kept.columns[j]).collect();
    Ok(Refitted { weights, dependent, residual_rms })
}

/// The coefficients of an estimate to full precision where no noise was taken out: from R instead of
/// RᵀR, whose condition is the square.
fn sharpen(factor: &FactorSum<'_>, estimate: &Estimate) -> Result<Vec<f64>, SparseError> {
    if !factor.fit.noise.is_none() || estimate.active.is_empty() {
        return Ok(estimate.coefficients.clone());
    }
    let (r, p, k) = (factor.triangle.r(), factor.fit.n_columns(), estimate.active.len());
    let mut small = Triangle::new(k + 1);
    let chosen = Mat::from_fn(p + 1, k + 1, |i, j| r[(i, *estimate.active.get(j).unwrap_or(&p))]);
    small.add(chosen.as_ref())?;
    let mut x = Mat::from_fn(k, 1, |i, _| small.r()[(i, k)]);
    let upper = small.r().submatrix(0, 0, k, k);
    faer::linalg::triangular_solve::solve_upper_triangular_in_place(
        upper,
        x.as_mut(),
        faer::Par::Seq,
    );
    Ok((0..k).map(|i| x[(i, 0)]).collect())
}
