//! Moments or rows → normal equations YᵀY and Yᵀy of a design, by whichever route costs less [E3].

use crate::design::Design;
use crate::error::SparseError;
use crate::moments::{MomentPlan, Moments, add_product};
use crate::samples::{Evaluator, Samples};
use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::{Accum, ColMut, Mat, Par};
use rayon::prelude::*;

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
        let shapes = [
            (self.gram.ncols(), other.gram.ncols()),
            (self.cross.ncols(), other.cross.ncols()),
        ];
        if let Some(&(expected, found)) = shapes.iter().find(|(a, b)| a != b) {
            return Err(SparseError::Shape { what: "a Gram matrix", found, expected });
        }
        self.gram += &other.gram;
        self.cross += &other.cross;
        self.energy.iter_mut().zip(&other.energy).for_each(|(a, b)| *a += b);
        self.rows += other.rows;
        Ok(())
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
        triangular::matmul(
            gram.gram.as_mut(),
            BlockStructure::TriangularLower,
            Accum::Add,
            y.transpose(),
            BlockStructure::Rectangular,
            y.as_ref(),
            BlockStructure::Rectangular,
            1.0,
            Par::Seq,
        );
        let own = responses_of(equation, n_equations, n_responses);
        let responses = samples.responses.subcols(own.start, own.len()).to_owned();
        add_product(&mut gram.cross, y, &responses);
        for (energy, response) in gram.energy.iter_mut().zip(responses.col_iter()) {
            *energy += response.squared_norm_l2();
        }
        gram.rows += samples.n_rows();
    }
    Ok(())
}

/// The normal equations of each equation of the plan's design, gathered from moments.
pub fn gather(plan: &MomentPlan, moments: &Moments) -> Vec<Gram> {
    let design = plan.design();
    let n_equations = design.n_equations();
    (0..n_equations)
        .map(|equation| {
            let own = responses_of(equation, n_equations, moments.energy.len());
            let columns = &design.equations[equation];
            Gram {
                gram: gather_gram(plan, moments, columns),
                cross: gather_cross(design, moments, columns, own.clone()),
                energy: moments.energy[own].to_vec(),
                rows: moments.rows,
            }
        })
        .collect()
}

type Entries = Vec<(usize, f64)>;

/// Σ over the atoms of both columns; the atoms of a design are sorted by wave, so that the pair of
/// waves is looked up once for many monomials.
fn gather_gram(plan: &MomentPlan, moments: &Moments, columns: &[Entries]) -> Mat<f64> {
    if columns.iter().all(|entries| entries.len() == 1) {
        let single: Vec<(usize, f64)> = columns.iter().map(|entries| entries[0]).collect();
        return atom_gram(plan, moments, &single);
    }
    let mut used: Vec<usize> = columns.iter().flatten().map(|&(atom, _)| atom).collect();
    used.sort_unstable();
    used.dedup();
    let unit: Vec<(usize, f64)> = used.iter().map(|&atom| (atom, 1.0)).collect();
    let atoms = atom_gram(plan, moments, &unit);
    let local: Vec<Entries> = columns
        .iter()
        .map(|entries| {
            entries.iter().filter_map(|&(a, w)| Some((used.binary_search(&a).ok()?, w))).collect()
        })
        .collect();
    let mut half = Mat::<f64>::zeros(used.len(), columns.len());
    for (j, entries) in local.iter().enumerate() {
        for &(atom, weight) in entries {
            for (out, x) in half.col_as_slice_mut(j).iter_mut().zip(atoms.col_as_slice(atom)) {
                *out += weight * x;
            }
        }
    }
    let half = &half;
    Mat::from_fn(columns.len(), columns.len(), |i, j| {
        let (low, high) = (i.min(j), i.max(j));
        local[low].iter().map(|&(atom, weight)| weight * half[(atom, high)]).sum()
    })
}

/// The Gram matrix of weighted single atoms.
fn atom_gram(plan: &MomentPlan, moments: &Moments, atoms: &[(usize, f64)]) -> Mat<f64> {
    let design = plan.design();
    let mut order: Vec<usize> = (0..atoms.len()).collect();
    order.sort_unstable_by_key(|&slot| atoms[slot].0);
    let items: Vec<Item> = order
        .iter()
        .map(|&slot| {
            let (wave, monomial) = design.atoms[atoms[slot].0];
            Item { slot, wave, monomial, weight: atoms[slot].1 }
        })
        .collect();
    let groups: Vec<&[Item]> = items.chunk_by(|a, b| a.wave == b.wave).collect();
    let mut gram = Mat::zeros(atoms.len(), atoms.len());
    gram.par_col_iter_mut().enumerate().for_each(|(slot, column)| {
        let (atom, weight) = atoms[slot];
        let (wave, monomial) = design.atoms[atom];
        fill_column(plan, moments, &groups, Item { slot, wave, monomial, weight }, column);
    });
    gram
}

#[derive(Clone, Copy)]
struct Item {
    slot: usize,
    wave: usize,
    monomial: usize,
    weight: f64,
}

fn fill_column(
    plan: &MomentPlan,
    moments: &Moments,
    groups: &[&[Item]],
    column: Item,
    mut out: ColMut<'_, f64>,
) {
    let products = plan.monomial_pairs(column.monomial);
    for group in groups {
        let [(s, first), (r, second)] = plan.wave_pair(group[0].wave, column.wave);
        let (first, second) = (moments.table.col_as_slice(first), moments.table.col_as_slice(second));
        for item in *group {
            let place = products[item.monomial];
            let value = s * first[place] + r * second[place];
            out[item.slot] = item.weight * column.weight * value;
        }
    }
}

fn gather_cross(
    design: &Design,
    moments: &Moments,
    columns: &[Entries],
    responses: std::ops::Range<usize>,
) -> Mat<f64> {
    let n_monomials = design.monomials.len();
    Mat::from_fn(columns.len(), responses.len(), |j, r| {
        let place = (responses.start + r) * n_monomials;
        columns[j]
            .iter()
            .map(|&(atom, weight)| {
                let (wave, monomial) = design.atoms[atom];
                weight * moments.cross[(wave, place + monomial)]
            })
            .sum()
    })
}
