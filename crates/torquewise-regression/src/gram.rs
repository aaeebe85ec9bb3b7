//! Normal equations YᵀY and Yᵀy of a design from its rows: the direct route.

use crate::error::SparseError;
use crate::products::{add_gram, add_product};
use crate::samples::{Evaluator, Samples};
use faer::Mat;

/// Normal equations of one equation of a design.
#[derive(Clone, Debug)]
pub struct Gram {
    /// YᵀY, p×p.
    pub gram: Mat<f64>,
    /// Yᵀy, p×r: all responses where the design has one equation, else the response of this one.
    pub cross: Mat<f64>,
    /// yᵀy of each of the r responses.
    pub energy: Vec<f64>,
    /// Rows summed.
    pub rows: usize,
}

impl Gram {
    /// Normal equations without rows.
    pub fn zeros(n_columns: usize, n_responses: usize) -> Self {
        Self {
            gram: Mat::zeros(n_columns, n_columns),
            cross: Mat::zeros(n_columns, n_responses),
            energy: vec![0.0; n_responses],
            rows: 0,
        }
    }

    /// Adds the rows of another.
    ///
    /// # Errors
    /// [`SparseError::Shape`] if the two were made for different designs.
    pub fn merge(&mut self, other: &Self) -> Result<(), SparseError> {
        let shapes =
            [(self.gram.ncols(), other.gram.ncols()), (self.cross.ncols(), other.cross.ncols())];
        if let Some(&(expected, found)) = shapes.iter().find(|(a, b)| a != b) {
            return Err(SparseError::Shape { what: "a Gram matrix", found, expected });
        }
        self.gram += &other.gram;
        self.cross += &other.cross;
        self.energy.iter_mut().zip(&other.energy).for_each(|(a, b)| *a += b);
        self.rows += other.rows;
        Ok(())
    }

    /// The normal equations in some of the columns.
    pub(crate) fn subset(&self, columns: &[usize]) -> Self {
        let p = columns.len();
        Self {
            gram: Mat::from_fn(p, p, |i, j| self.gram[(columns[i], columns[j])]),
            cross: Mat::from_fn(p, self.cross.ncols(), |i, r| self.cross[(columns[i], r)]),
            energy: self.energy.clone(),
            rows: self.rows,
        }
    }

    /// Writes the upper triangle from the lower one.
    pub(crate) fn mirror(&mut self) {
        for j in 0..self.gram.ncols() {
            for i in 0..j {
                self.gram[(i, j)] = self.gram[(j, i)];
            }
        }
    }
}

/// The responses an equation explains: all of them if there is one equation, else its own.
pub(crate) fn responses_of(
    equation: usize,
    n_equations: usize,
    n_responses: usize,
) -> std::ops::Range<usize> {
    if n_equations == 1 { 0..n_responses } else { equation..equation + 1 }
}

/// Multiplications per row of the direct route: evaluate the columns, then half of YᵀY each.
pub fn direct_cost(evaluator: &Evaluator, n_responses: usize) -> f64 {
    let design = evaluator.design();
    let p = design.n_columns() as f64;
    let responses = if design.n_equations() == 1 { n_responses as f64 } else { 1.0 };
    evaluator.cost() + design.n_equations() as f64 * p * (p / 2.0 + responses)
}

/// Adds a block of rows to the normal equations of each equation (lower triangles only): the
/// direct route.
///
/// # Errors
/// [`SparseError::Shape`] if the block does not fit the design.
pub(crate) fn accumulate_rows(
    evaluator: &Evaluator,
    grams: &mut [Gram],
    samples: &Samples,
) -> Result<(), SparseError> {
    let columns = evaluator.columns(samples)?;
    let (n_equations, n_responses) = (columns.len(), samples.responses.ncols());
    for (equation, (y, gram)) in columns.iter().zip(grams).enumerate() {
        add_gram(&mut gram.gram, y.as_ref(), 1.0);
        let own = responses_of(equation, n_equations, n_responses);
        let responses = samples.responses.subcols(own.start, own.len());
        add_product(&mut gram.cross, y.as_ref(), responses);
        for (energy, response) in gram.energy.iter_mut().zip(responses.col_iter()) {
            *energy += response.squared_norm_l2();
        }
        gram.rows += samples.n_rows();
    }
    Ok(())
}
