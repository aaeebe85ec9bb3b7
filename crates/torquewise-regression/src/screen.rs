//! From known columns, response to what each further column would explain of what they leave (E10).

use crate::cholesky::regular_factor;
use crate::error::SparseError;
use crate::orthonormal::orthonormal;
use crate::products::product;
use faer::linalg::triangular_solve::{
    solve_lower_triangular_in_place, solve_upper_triangular_in_place,
};
use faer::{ColRef, Mat, MatRef, Par};
use std::ops::Range;

/// What known columns leave of a response, ready to try further columns one by one.
///
/// The rows come in blocks, each of which can be left out.
#[derive(Clone, Debug)]
pub struct Screen {
    /// Orthonormal columns that span the known ones, then the residual, N×(g+1).
    basis: Mat<f64>,
    /// Rows of each block, one after the other.
    blocks: Vec<Range<usize>>,
    /// ‖r‖²
    energy: f64,
    /// The fit without each block.
    folds: Vec<Fold>,
}

/// What the rows outside a block say of the known columns.
#[derive(Clone, Debug)]
struct Fold {
    /// L of QᵀQ + [`UNSEEN`], g×g, lower.
    factor: Mat<f64>,
    /// L⁻¹Qᵀr, g×1.
    solved: Mat<f64>,
    /// What is left of ‖r‖².
    energy: f64,
}

/// What a column explains if it joins the known ones, all of them fitted again.
#[derive(Clone, Debug, PartialEq)]
pub struct Gain {
    /// Part of the sum of squares of the residual that goes, 0 to 1.
    pub share: f64,
    /// The same with each block of rows left out.
    pub without: Vec<f64>,
}

/// A column of which less than this part, squared, is its own says what the known ones say.
const OWN: f64 = 1e-8;
/// A direction of the known columns that has less than this part of its squares outside a block is
/// held where the fit to all rows has it.
const UNSEEN: f64 = 1e-5;

impl Screen {
    /// - `known`: columns that are fitted whatever joins them, N×p, of any rank
    /// - `response`: N
    /// - `block_rows`: how many rows each block has, one block after the other
    ///
    /// # Errors
    /// [`SparseError::Shape`] if the response or the blocks have another number of rows,
    /// [`SparseError::NotFinite`].
    pub fn new(
        known: Mat<f64>,
        response: &[f64],
        block_rows: &[usize],
    ) -> Result<Self, SparseError> {
        let rows = known.nrows();
        expect("the response of a screen", response.len(), rows)?;
        expect("the blocks of a screen", block_rows.iter().sum(), rows)?;
        let bad = |x: &[f64]| x.iter().position(|x| !x.is_finite());
        let of_known = (0..known.ncols()).find_map(|j| bad(known.col_as_slice(j)));
        for (what, bad) in [("a known column", of_known), ("the response", bad(response))] {
            if let Some(entry) = bad {
                return Err(SparseError::NotFinite { what, entry });
            }
        }
        let span = orthonormal(known);
        let mut rest = ColRef::from_slice(response).to_owned();
        // Twice: what rounding leaves in the span the first time is gone the second time.
        for _ in 0..2 {
            rest -= &span * (span.transpose() * &rest);
        }
        let g = span.ncols();
        let basis =
            Mat::from_fn(rows, g + 1, |row, j| if j < g { span[(row, j)] } else { rest[row] });
        let mut start = 0;
        let blocks: Vec<Range<usize>> = block_rows
            .iter()
            .map(|&count| {
                start += count;
                start - count..start
            })
            .collect();
        let energy = rest.squared_norm_l2();
        let folds = blocks.iter().map(|block| Fold::new(&basis, block, energy)).collect();
        Ok(Self { basis, blocks, energy, folds })
    }

    /// Number of rows N.
    pub fn n_rows(&self) -> usize {
        self.basis.nrows()
    }

    /// Number of independent known columns g.
    pub fn rank(&self) -> usize {
        self.basis.ncols() - 1
    }

    /// Rows of each block.
    pub fn blocks(&self) -> &[Range<usize>] {
        &self.blocks
    }

    /// What each of some columns would explain, N×k.
    ///
    /// # Errors
    /// [`SparseError::Shape`] if they have another number of rows.
    pub fn gains(&self, columns: MatRef<'_, f64>) -> Result<Vec<Gain>, SparseError> {
        expect("a column to be tried", columns.nrows(), self.n_rows())?;
        let parts: Vec<Sums> = self
            .blocks
            .iter()
            .map(|block| {
                let part = columns.subrows(block.start, block.len());
                Sums::of(self.basis.subrows(block.start, block.len()), part)
            })
            .collect();
        let all = Sums::total(&parts, self.basis.ncols(), columns.ncols());
        let whole = all.shares(self.energy);
        let without: Vec<Vec<f64>> = (self.folds.iter().zip(&parts))
            .map(|(fold, part)| fold.seen(all.less(part)).shares(fold.energy))
            .collect();
        // What lies in the span lies there without a block as well.
        let gain = |(j, share): (usize, &f64)| Gain {
            share: *share,
            without: without.iter().map(|own| if all.tells(j) { own[j] } else { 0.0 }).collect(),
        };
        Ok(whole.iter().enumerate().map(gain).collect())
    }

    /// The residual, and what is left of it once a column has joined; N each.
    ///
    /// Where a block is left out, its rows are those of a fit to all others.
    ///
    /// # Errors
    /// [`SparseError::Shape`] if the column has another number of rows,
    /// [`SparseError::Column`] if there is no such block.
    pub fn left(
        &self,
        column: &[f64],
        without: Option<usize>,
    ) -> Result<[Vec<f64>; 2], SparseError> {
        expect("a column to be tried", column.len(), self.n_rows())?;
        let g = self.rank();
        let columns = MatRef::from_column_major_slice(column, column.len(), 1);
        let all = Sums::of(self.basis.as_ref(), columns);
        let (mut before, mut after) = (Mat::zeros(g, 1), all.across.subrows(0, g).to_owned());
        let mut sums = all;
        if let Some(place) = without {
            let (Some(fold), Some(block)) = (self.folds.get(place), self.blocks.get(place)) else {
                return Err(SparseError::Column { column: place, columns: self.folds.len() });
            };
            let part = columns.subrows(block.start, block.len());
            let part = Sums::of(self.basis.subrows(block.start, block.len()), part);
            sums = fold.seen(sums.less(&part));
            before.copy_from(&fold.solved);
            after = sums.across.subrows(0, g).to_owned();
            for side in [&mut before, &mut after] {
                let upper = fold.factor.transpose();
                solve_upper_triangular_in_place(upper, side.as_mut(), Par::Seq);
            }
        }
        let coefficient = if sums.tells(0) { sums.slope(0) / sums.own(0) } else { 0.0 };
        let span = self.basis.subcols(0, g);
        let (known, follows) = (span * &before, span * &after);
        let rest = self.basis.col_as_slice(g);
        let base: Vec<f64> = (0..rest.len()).map(|k| rest[k] - known[(k, 0)]).collect();
        let own = |k: usize| coefficient * (column[k] - follows[(k, 0)]);
        let with = base.iter().enumerate().map(|(k, base)| base - own(k)).collect();
        Ok([base, with])
    }
}

impl Fold {
    fn new(basis: &Mat<f64>, block: &Range<usize>, energy: f64) -> Self {
        let g = basis.ncols() - 1;
        let part = basis.subrows(block.start, block.len());
        let own = product(part.transpose(), part);
        // What all rows sum up to is known: 1, and no residual in the span.
        let gram =
            Mat::from_fn(g, g, |i, j| (if i == j { 1.0 + UNSEEN } else { 0.0 }) - own[(i, j)]);
        let mut solved = Mat::from_fn(g, 1, |i, _| -own[(i, g)]);
        let factor = regular_factor(gram).unwrap_or_else(|| Mat::identity(g, g));
        solve_lower_triangular_in_place(factor.as_ref(), solved.as_mut(), Par::Seq);
        let energy = (energy - own[(g, g)] - solved.squared_norm_l2()).max(0.0);
        Self { factor, solved, energy }
    }

    /// Sums over the rows outside the block, in coordinates in which the known columns are
    /// orthonormal there.
    fn seen(&self, mut sums: Sums) -> Sums {
        let g = self.factor.nrows();
        let across = sums.across.subrows_mut(0, g);
        solve_lower_triangular_in_place(self.factor.as_ref(), across, Par::Seq);
        for j in 0..sums.energy.len() {
            let follows: f64 = (0..g).map(|i| sums.across[(i, j)] * self.solved[(i, 0)]).sum();
            sums.across[(g, j)] -= follows;
        }
        sums
    }
}

/// Products of columns with the basis and with themselves over some rows.
struct Sums {
    /// \[Q r\]ᵀC, (g+1)×k.
    across: Mat<f64>,
    /// ‖c‖² of each column, k.
    energy: Vec<f64>,
}

impl Sums {
    fn of(basis: MatRef<'_, f64>, columns: MatRef<'_, f64>) -> Self {
        let energy = columns.col_iter().map(|column| column.squared_norm_l2()).collect();
        Self { across: product(basis.transpose(), columns), energy }
    }

    fn total(parts: &[Self], size: usize, columns: usize) -> Self {
        let mut total = Self { across: Mat::zeros(size, columns), energy: vec![0.0; columns] };
        for part in parts {
            total.across += &part.across;
            total.energy.iter_mut().zip(&part.energy).for_each(|(sum, part)| *sum += part);
        }
        total
    }

    fn less(&self, part: &Self) -> Self {
        let energy = self.energy.iter().zip(&part.energy).map(|(all, part)| all - part).collect();
        Self { across: &self.across - &part.across, energy }
    }

    /// (c·(I − P)r)²/(c·(I − P)c) over what is left of the squares of the response.
    fn shares(&self, energy: f64) -> Vec<f64> {
        let share = |j: usize| {
            let tells = energy > 0.0 && self.tells(j);
            let share = self.slope(j).powi(2) / (self.own(j) * energy);
            if tells { share.clamp(0.0, 1.0) } else { 0.0 }
        };
        (0..self.energy.len()).map(share).collect()
    }

    /// c·(I − P)r
    fn slope(&self, column: usize) -> f64 {
        self.across[(self.across.nrows() - 1, column)]
    }

    /// c·(I − P)c
    fn own(&self, column: usize) -> f64 {
        let g = self.across.nrows() - 1;
        let spanned: f64 = self.across.col_as_slice(column)[..g].iter().map(|x| x * x).sum();
        self.energy[column] - spanned
    }

    /// Whether a column is more than what the known ones say.
    fn tells(&self, column: usize) -> bool {
        self.own(column) > OWN * self.energy[column]
    }
}

fn expect(what: &'static str, found: usize, expected: usize) -> Result<(), SparseError> {
    if found == expected { Ok(()) } else { Err(SparseError::Shape { what, found, expected }) }
}

#[cfg(test)]
mod tests;
