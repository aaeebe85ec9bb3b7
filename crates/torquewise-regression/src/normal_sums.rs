//! Normal equations of blocks of weighted rows \[J e\], which add up: derivatives of a prediction by
//! its parameters and its residual, both over the noise (E11). Their sums are exact, so that blocks
//! and logs add up to the same bits in any order.

use crate::Result;
use crate::exact::ExactSums;
use crate::products::{add_gram, add_gram_of_equations};
use faer::{Mat, MatRef};
use serde::{Deserialize, Serialize};

/// Folds that blocks of time are usually dealt out to, for cross-validation.
pub const FOLDS: usize = 8;

/// Which rows of a block err alike.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Alike {
    /// All of them: neighbours in time, filtered or told apart from a model that is wrong.
    Block,
    /// Those of one instant: an even sample of rows under white noise.
    Instant,
}

/// Scores are squared: where the noise is next to nothing and a first fit far off, they are huge.
/// They are counted in this unit, 2⁻²⁰.
const SCORE_UNIT: f64 = 1.0 / 1_048_576.0;
/// Sums that are kept of the residual of each equation.
const PER_EQUATION: usize = 3;

/// What blocks of rows add up to, p parameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NormalSums {
    parameters: usize,
    /// Equations per instant n.
    equations: usize,
    /// Lower triangles row by row: \[J e\]ᵀ\[J e\] of each fold; what noise in the rows adds to them
    /// (E7); Σ s sᵀ, s = Jᵀe of the rows that err alike; Jᵀe and the squares of each column by equation. Then of each equation
    /// Σ e², Σ w² and Σ (e/w)², w what its rows were multiplied by.
    sums: ExactSums,
    /// Instants of each fold.
    rows: Vec<u64>,
    blocks: u64,
}

/// The sums of one block of time.
#[derive(Clone, Debug)]
pub struct BlockSums {
    fold: usize,
    rows: u64,
    gram: Mat<f64>,
    bias: Mat<f64>,
    /// Σ s sᵀ of its instants, where these err alike and not the whole block.
    instants: Option<Mat<f64>>,
    /// Jᵀe of each equation, p×n, what noise adds to it, and the squares of each column.
    apart: [Mat<f64>; 3],
    energies: Vec<f64>,
}

impl BlockSums {
    /// Sums up one block.
    ///
    /// - `rows`: \[J e\], all instants of equation 1 first, (m·n)×(p+1)
    /// - `weights`: what each row was multiplied by, m·n
    pub fn new(
        fold: usize,
        rows: MatRef<'_, f64>,
        weights: &[f64],
        (equations, alike): (usize, Alike),
    ) -> Self {
        let p = rows.ncols() - 1;
        let m = rows.nrows() / equations.max(1);
        let mut gram = Mat::zeros(p + 1, p + 1);
        add_gram_of_equations(&mut gram, rows, equations, 1.0);
        let instants = (alike == Alike::Instant).then(|| {
            let score = |row: usize, j: usize| -> f64 {
                let own = (0..equations).map(|equation| equation * m + row);
                own.map(|k| rows[(k, j)] * rows[(k, p)]).sum()
            };
            squares(&Mat::from_fn(m, p, |row, j| SCORE_UNIT * score(row, j)))
        });
        let residual = rows.col(p);
        let energies_of = |equation: usize| {
            let mut sums = [0.0; PER_EQUATION];
            for k in equation * m..(equation + 1) * m {
                let (e, w) = (residual[k], weights[k]);
                sums.iter_mut().zip([e, w, e / w]).for_each(|(sum, x)| *sum += x * x);
            }
            sums
        };
        let energies = (0..equations).flat_map(energies_of).collect();
        let own = |k, equation: usize| rows.col(k).subrows(equation * m, m);
        let square = |k, equation| own(k, equation).iter().map(|x| x * x).sum::<f64>();
        let squares = Mat::from_fn(p, equations, square);
        let apart = [scores_apart(rows, equations), Mat::zeros(p, equations), squares];
        let bias = Mat::zeros(p + 1, p + 1);
        Self { fold, rows: m as u64, gram, bias, instants, apart, energies }
    }

    /// Adds the same rows once more, seen through more noise, `share` times; and takes the rows as
    /// they are away as often.
    pub fn add_noisy(&mut self, noisy: MatRef<'_, f64>, share: f64) {
        let equations = self.energies.len() / PER_EQUATION;
        add_gram_of_equations(&mut self.bias, noisy, equations, share);
        self.bias -= faer::Scale(share) * &self.gram;
        let [own, noise, _] = &mut self.apart;
        *noise += faer::Scale(share) * (scores_apart(noisy, equations) - &*own);
    }

    /// Σ s sᵀ of the rows that err alike, without what noise adds to a score s = Jᵀe.
    fn scores(&self) -> Mat<f64> {
        let p = self.gram.ncols() - 1;
        self.instants.clone().unwrap_or_else(|| {
            let score = |j: usize| self.gram[(p, j)] - self.bias[(p, j)];
            squares(&Mat::from_fn(1, p, |_, j| SCORE_UNIT * score(j)))
        })
    }
}

fn squares(x: &Mat<f64>) -> Mat<f64> {
    let mut gram = Mat::zeros(x.ncols(), x.ncols());
    add_gram(&mut gram, x.as_ref(), 1.0);
    gram
}

/// Jᵀe of each equation of some rows \[J e\], p×n.
fn scores_apart(rows: MatRef<'_, f64>, equations: usize) -> Mat<f64> {
    let (m, p) = (rows.nrows() / equations.max(1), rows.ncols() - 1);
    let mut scores = Mat::zeros(p, equations);
    for equation in 0..equations {
        let own = rows.subrows(equation * m, m);
        scores.col_mut(equation).copy_from(own.subcols(0, p).transpose() * own.col(p));
    }
    scores
}

fn packed(matrix: &Mat<f64>) -> Vec<f64> {
    (0..matrix.nrows()).flat_map(|i| (0..=i).map(move |j| matrix[(i, j)])).collect()
}

fn triangle(size: usize) -> usize {
    size * (size + 1) / 2
}

impl NormalSums {
    /// Sums of nothing: p parameters, n equations an instant, dealt out to so many folds.
    pub fn new(parameters: usize, equations: usize, folds: usize) -> Self {
        let (sums, rows) = (ExactSums::zeros(0), vec![0; folds.max(1)]);
        let mut empty = Self { parameters, equations, sums, rows, blocks: 0 };
        empty.sums = ExactSums::zeros(empty.energies() + PER_EQUATION * equations);
        empty
    }

    /// Where the Gram matrix of a fold begins, or what follows that of the last one: the bias.
    fn gram_at(&self, fold: usize) -> usize {
        fold * triangle(self.parameters + 1)
    }

    fn scores_at(&self) -> usize {
        self.gram_at(self.rows.len() + 1)
    }

    fn apart_at(&self) -> usize {
        self.scores_at() + triangle(self.parameters)
    }

    fn energies(&self) -> usize {
        self.apart_at() + 2 * self.parameters * self.equations
    }

    /// The symmetric matrix whose lower triangle begins at a place.
    fn matrix(&self, first: usize, size: usize) -> Mat<f64> {
        Mat::from_fn(size, size, |i, j| self.sums.value(first + triangle(i.max(j)) + i.min(j)))
    }

    /// Adds a block.
    ///
    /// # Errors
    /// [`SparseError::OutOfRange`](crate::SparseError::OutOfRange) if a sum is not finite or too large.
    pub fn add(&mut self, block: &BlockSums) -> Result<()> {
        let fold = block.fold % self.rows.len();
        self.sums.add(self.gram_at(fold), &packed(&block.gram))?;
        self.sums.add(self.gram_at(self.rows.len()), &packed(&block.bias))?;
        self.sums.add(self.scores_at(), &packed(&block.scores()))?;
        let [scores, noise, squares] = &block.apart;
        let scores = scores - noise;
        let columns = scores.col_iter().chain(squares.col_iter());
        let apart: Vec<f64> = columns.flat_map(|own| own.iter().copied()).collect();
        self.sums.add(self.apart_at(), &apart)?;
        self.sums.add(self.energies(), &block.energies)?;
        self.rows[fold] += block.rows;
        self.blocks += 1;
        Ok(())
    }

    /// Adds the blocks of another.
    ///
    /// # Errors
    /// [`SparseError::Shape`](crate::SparseError::Shape) if it is of other parameters, [`SparseError::OutOfRange`](crate::SparseError::OutOfRange).
    pub fn merge(&mut self, other: &Self) -> Result<()> {
        self.sums.merge(&other.sums)?;
        self.rows.iter_mut().zip(&other.rows).for_each(|(rows, more)| *rows += more);
        self.blocks += other.blocks;
        Ok(())
    }

    /// Whether it holds what p parameters, n equations and so many folds ask for.
    pub fn is_sound(&self, parameters: usize, equations: usize, folds: usize) -> bool {
        (self.parameters, self.equations, self.rows.len()) == (parameters, equations, folds)
            && self.sums.count() == self.energies() + PER_EQUATION * equations
    }

    /// Instants summed.
    pub fn rows(&self) -> u64 {
        self.rows.iter().sum()
    }

    /// Instants of a fold.
    pub fn rows_of(&self, fold: usize) -> u64 {
        self.rows.get(fold).copied().unwrap_or(0)
    }

    /// Folds that have instants.
    pub fn folds(&self) -> Vec<usize> {
        (0..self.rows.len()).filter(|&fold| self.rows[fold] > 0).collect()
    }

    /// Blocks summed.
    pub fn blocks(&self) -> u64 {
        self.blocks
    }

    /// \[J e\]ᵀ\[J e\] of all rows, (p+1)×(p+1).
    pub fn gram(&self) -> Mat<f64> {
        let size = self.parameters + 1;
        (0..self.rows.len()).fold(Mat::zeros(size, size), |sum, fold| sum + self.gram_of(fold))
    }

    /// The same of one fold.
    pub fn gram_of(&self, fold: usize) -> Mat<f64> {
        self.matrix(self.gram_at(fold), self.parameters + 1)
    }

    /// What noise in the rows adds to the Gram matrix (E7), (p+1)×(p+1).
    pub fn bias(&self) -> Mat<f64> {
        self.matrix(self.gram_at(self.rows.len()), self.parameters + 1)
    }

    /// Σ s sᵀ over the rows that err alike, p×p: how far the scores Jᵀe scatter.
    pub fn scores(&self) -> Mat<f64> {
        faer::Scale(SCORE_UNIT.powi(-2)) * self.matrix(self.scores_at(), self.parameters)
    }

    /// Of each equation over all rows the score Jᵀe, without what noise adds, and the squares of each
    /// column, p×n each.
    pub fn apart(&self) -> [Mat<f64>; 2] {
        let (p, n) = (self.parameters, self.equations);
        let of = |what: usize| {
            let first = self.apart_at() + what * p * n;
            Mat::from_fn(p, n, |k, equation| self.sums.value(first + equation * p + k))
        };
        [of(0), of(1)]
    }

    /// RMS of the residual of each equation in its own unit, rows counted by their weights, n.
    pub fn weighted_rms(&self) -> Vec<f64> {
        self.rms(|[residual, weights, _]| residual / weights)
    }

    /// RMS of the residual of each equation in its own unit, all rows alike, n.
    pub fn residual_rms(&self) -> Vec<f64> {
        let rows = self.rows() as f64;
        self.rms(|[_, _, plain]| plain / rows)
    }

    fn rms(&self, mean: impl Fn([f64; PER_EQUATION]) -> f64) -> Vec<f64> {
        let of = |equation| {
            let sum = |k| self.sums.value(self.energies() + PER_EQUATION * equation + k);
            let mean = mean(std::array::from_fn(sum));
            if mean.is_finite() { mean.max(0.0).sqrt() } else { 0.0 }
        };
        (0..self.equations).map(of).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(m: usize, seed: f64) -> Mat<f64> {
        Mat::from_fn(2 * m, 4, |i, j| ((i as f64 + seed) * (1.3 + j as f64)).sin())
    }

    fn block(m: usize, seed: f64) -> BlockSums {
        BlockSums::new(m, rows(m, seed).as_ref(), &vec![1.0; 2 * m], (2, Alike::Block))
    }

    #[test]
    fn blocks_add_up_to_the_same_bits_in_any_order() {
        let blocks: Vec<BlockSums> = (0..7).map(|k| block(3 + k, k as f64)).collect();
        let sum = |order: &[usize]| {
            let mut sums = NormalSums::new(3, 2, FOLDS);
            for &k in order {
                sums.add(&blocks[k]).unwrap();
            }
            sums
        };

        let mut merged = sum(&[6, 2]);
        merged.merge(&sum(&[0, 5, 3, 1, 4])).unwrap();

        assert_eq!(merged, sum(&[0, 1, 2, 3, 4, 5, 6]));
        assert_eq!((merged.rows(), merged.blocks()), (42, 7));
    }

    #[test]
    fn sums_are_those_of_all_rows_at_once_and_scores_scatter_block_by_block() {
        let mut sums = NormalSums::new(3, 2, FOLDS);
        let (mut gram, mut scores) = (Mat::<f64>::zeros(4, 4), Mat::<f64>::zeros(3, 3));
        for k in 0..4 {
            sums.add(&block(5, f64::from(k))).unwrap();
            let rows = rows(5, f64::from(k));
            gram += rows.transpose() * &rows;
            let score = rows.subcols(0, 3).transpose() * rows.col(3);
            scores += &score * score.transpose();
        }

        assert!((sums.gram() - &gram).norm_max() < 1e-13);
        assert!((sums.scores() - scores).norm_max() < 1e-12);
        let energy: f64 = sums.residual_rms().iter().map(|x| 20.0 * x * x).sum();
        assert!((energy - gram[(3, 3)]).abs() < 1e-13);
    }

    #[test]
    fn the_bias_is_what_noise_adds() {
        let (still, noisy) = (rows(5, 0.0), rows(5, 0.3));
        let mut block = block(5, 0.0);
        block.add_noisy(noisy.as_ref(), 0.5);
        let mut sums = NormalSums::new(3, 2, FOLDS);
        sums.add(&block).unwrap();

        let added = noisy.transpose() * &noisy - still.transpose() * &still;
        assert!((sums.bias() - faer::Scale(0.5) * added).norm_max() < 1e-13);
        let [scores, squares] = sums.apart();
        let first = |rows: &Mat<f64>| rows.subrows(0, 5).to_owned();
        let score = |rows: &Mat<f64>| rows.subcols(0, 3).transpose() * rows.col(3);
        let own = 1.5 * score(&first(&still)) - 0.5 * score(&first(&noisy));
        assert!((scores.col(0) - own).norm_max() < 1e-13, "{scores:?}");
        for k in 0..3 {
            let both = sums.gram()[(3, k)] - sums.bias()[(3, k)];
            assert!((scores[(k, 0)] + scores[(k, 1)] - both).abs() < 1e-13, "{scores:?}");
            assert!((squares[(k, 0)] + squares[(k, 1)] - sums.gram()[(k, k)]).abs() < 1e-13);
        }
    }
}
