//! Kept terms, all rows → R factor, and what noise in the rows does to it (E6) (E7).

use crate::candidates::Group;
use crate::rows::rub;
use faer::Mat;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use torquewise_model::FrictionTerm;
use torquewise_regression::SparseError;
use torquewise_regression::accumulate::Accumulate;
use torquewise_regression::products::add_gram;
use torquewise_regression::samples::{Evaluator, Samples};
use torquewise_regression::triangle::Triangle;
use torquewise_survey::noise::NoiseFloor;

/// The terms of one group to be fitted together.
#[derive(Clone, Debug)]
pub(crate) struct Kept {
    pub(crate) group: Group,
    /// Columns of the library, ascending.
    pub(crate) columns: Vec<usize>,
    /// Weight of the rows of each equation: one over its noise variance.
    pub(crate) weights: Vec<f64>,
}

/// A group with its columns ready to be evaluated.
#[derive(Clone, Copy)]
pub(crate) struct Fit<'a> {
    pub(crate) kept: &'a Kept,
    pub(crate) evaluator: &'a Evaluator,
    /// Laws of friction whose values are among the variables.
    pub(crate) friction: &'a [FrictionTerm],
    pub(crate) noise: &'a NoiseFloor,
}

impl Fit<'_> {
    pub(crate) fn n_columns(&self) -> usize {
        self.kept.columns.len()
    }

    /// (matrix of columns, response, weight) of each equation.
    pub(crate) fn equations<'s>(
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
pub(crate) struct FactorSum<'a> {
    fit: &'a Fit<'a>,
    triangle: Triangle,
    /// \[Y τ\]ᵀ\[Y τ\] as noise changes it, (p+1)×(p+1), lower triangle.
    bias: Mat<f64>,
    /// Times that noise is drawn for each row.
    draws: usize,
    random: ChaCha8Rng,
}

impl<'a> FactorSum<'a> {
    pub(crate) fn new(fit: &'a Fit<'a>, draws: usize, seed: u64, lane: usize) -> Self {
        let size = fit.n_columns() + 1;
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        random.set_stream(lane as u64);
        Self { fit, triangle: Triangle::new(size), bias: Mat::zeros(size, size), draws, random }
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

    /// What the noise did to the sums, seen by doing it once more: with ε drawn as the noise is,
    /// and −ε beside it so that odd powers cancel, E\[½(S(z+ε) + S(z−ε)) − S(z)\] = E\[S(z)\] −
    /// S(true).
    fn probe(&mut self, samples: &Samples, rows: &[Mat<f64>]) -> Result<(), SparseError> {
        let noise = self.fit.noise;
        let share = 1.0 / self.draws.max(1) as f64;
        let drawn = noise.draw(&mut self.random, samples.n_rows());
        let (angles, rates) = drawn.split_at_col(noise.q.len());
        for sign in [1.0, -1.0] {
            let mut shifted = samples.clone();
            shifted.angles += faer::Scale(sign) * angles;
            let mut moved = shifted.variables.subcols_mut(0, rates.ncols());
            moved += faer::Scale(sign) * rates;
            rub(&mut shifted, self.fit.friction);
            for moved in self.rows(&shifted)? {
                add_gram(&mut self.bias, moved.as_ref(), 0.5 * share);
            }
        }
        for still in rows {
            add_gram(&mut self.bias, still.as_ref(), -share);
        }
        Ok(())
    }

    /// The factor with what follows from it.
    pub(crate) fn finish(self) -> Factor {
        let r = self.triangle.r();
        let gram = r.transpose() * &r;
        Factor { r, gram, bias: self.bias }
    }
}

/// The finished sums of a part of a log, (p+1)×(p+1) each, in \[Y τ\].
pub(crate) struct Factor {
    pub(crate) r: Mat<f64>,
    /// RᵀR
    pub(crate) gram: Mat<f64>,
    /// What noise adds to it, lower triangle.
    pub(crate) bias: Mat<f64>,
}

impl Accumulate for FactorSum<'_> {
    fn add(&mut self, samples: &Samples) -> Result<(), SparseError> {
        let rows = self.rows(samples)?;
        rows.iter().try_for_each(|rows| self.triangle.add(rows.as_ref()))?;
        let draws = if self.fit.noise.is_none() { 0 } else { self.draws };
        (0..draws).try_for_each(|_| self.probe(samples, &rows))
    }

    fn merge(&mut self, other: Self) -> Result<(), SparseError> {
        self.bias += &other.bias;
        self.triangle.merge(&other.triangle)
    }
}
