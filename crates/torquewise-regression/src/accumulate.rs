//! Normal equations of a design, summed over blocks of rows by the cheaper of two routes.

use crate::design::Design;
use crate::error::SparseError;
use crate::gather::gather;
use crate::moments::{MomentPlan, Moments, Strip};
use crate::normal_equations::{NormalEquations, mirror_lower};
use crate::products::{add_gram, add_product};
use crate::samples::{Evaluator, Samples};
use std::ops::Range;

/// Which route computes the normal equations of a design.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Route {
    /// Moments, then gathering.
    Moments,
    /// Evaluate the rows, then a symmetric product.
    Direct,
}

/// A design made ready to be summed by one of the routes, and how many responses it explains.
pub struct Prepared {
    ready: Ready,
    n_responses: usize,
}

enum Ready {
    /// Its moments are listed.
    Moments(Box<MomentPlan>),
    /// Its columns can be evaluated.
    Direct(Box<Evaluator>),
}

/// Accumulates the normal equations of a design by a given route.
pub struct GramSum<'a> {
    way: Way<'a>,
}

enum Way<'a> {
    Moments(&'a MomentPlan, Moments, Box<Strip>),
    Direct(&'a Evaluator, Vec<NormalEquations>),
}

impl Prepared {
    /// Makes a design ready for a route.
    pub fn new(design: &Design, n_responses: usize, route: Route) -> Self {
        let ready = match route {
            Route::Moments => Ready::Moments(Box::new(MomentPlan::new(design))),
            Route::Direct => Ready::Direct(Box::new(Evaluator::new(design.clone()))),
        };
        Self { ready, n_responses }
    }

    /// Makes a design ready for the cheaper route by multiplications: per row, and once for
    /// gathering (two per pair of atoms).
    pub fn cheaper(design: &Design, n_responses: usize, n_rows: usize) -> Self {
        let evaluator = Evaluator::new(design.clone());
        let direct = direct_cost(&evaluator, n_responses) * n_rows as f64;
        if moment_cost_bound(design) * n_rows as f64 <= direct {
            let plan = MomentPlan::new(design);
            let pairs = (design.n_equations() as f64) * (design.atoms.len() as f64).powi(2);
            if plan.cost(n_responses) * n_rows as f64 + 2.0 * pairs < direct {
                return Self { ready: Ready::Moments(Box::new(plan)), n_responses };
            }
        }
        Self { ready: Ready::Direct(Box::new(evaluator)), n_responses }
    }

    /// Its route.
    pub fn route(&self) -> Route {
        match self.ready {
            Ready::Moments(_) => Route::Moments,
            Ready::Direct(_) => Route::Direct,
        }
    }

    /// An empty sum.
    pub fn start(&self) -> GramSum<'_> {
        let n_responses = self.n_responses;
        let way = match &self.ready {
            Ready::Moments(plan) => {
                let strip = Box::new(plan.strip(n_responses));
                Way::Moments(plan, plan.start(n_responses), strip)
            }
            Ready::Direct(evaluator) => {
                let design = evaluator.design();
                let (p, count) = (design.n_columns(), design.n_equations());
                let own = responses_of(0, count, n_responses).len();
                Way::Direct(evaluator, (0..count).map(|_| NormalEquations::zeros(p, own)).collect())
            }
        };
        GramSum { way }
    }

    /// Numbers of one sum: those of [`GramSum::write_to`].
    pub(crate) fn n_sums(&self) -> usize {
        let mut count = 0;
        self.start().parts_mut(|part| count += part.len());
        count
    }

    /// The normal equations of each equation in some of the columns, from the numbers of a sum.
    pub(crate) fn grams_of(
        &self,
        table: &[f64],
        rows: usize,
        columns: &[usize],
    ) -> Vec<NormalEquations> {
        let mut sum = self.start();
        sum.read_from(table, rows);
        sum.grams_of(columns)
    }
}

/// At least this many multiplications per row go into moments: a cheap look before the products of
/// a very large design are listed.
fn moment_cost_bound(design: &Design) -> f64 {
    design.waves.len() as f64 * design.monomials.len() as f64
}

impl GramSum<'_> {
    /// Adds a block of rows.
    ///
    /// # Errors
    /// [`SparseError::Shape`] if the block does not fit.
    pub fn add(&mut self, samples: &Samples) -> Result<(), SparseError> {
        match &mut self.way {
            Way::Moments(plan, moments, strip) => plan.accumulate(strip, moments, samples),
            Way::Direct(evaluator, grams) => accumulate_rows(evaluator, grams, samples),
        }
    }

    /// The normal equations of each equation.
    pub fn grams(self) -> Vec<NormalEquations> {
        let design = match &self.way {
            Way::Moments(plan, ..) => plan.design(),
            Way::Direct(evaluator, _) => evaluator.design(),
        };
        let all: Vec<usize> = (0..design.n_columns()).collect();
        self.grams_of(&all)
    }

    /// The same in some of the columns.
    fn grams_of(self, columns: &[usize]) -> Vec<NormalEquations> {
        match self.way {
            Way::Moments(plan, moments, _) => gather(plan, &moments, columns),
            Way::Direct(_, mut grams) => {
                let own = grams.iter_mut().map(|own| {
                    mirror_lower(&mut own.gram);
                    own.restricted(columns)
                });
                own.collect()
            }
        }
    }

    /// Begins anew.
    pub(crate) fn clear(&mut self) {
        self.parts_mut(|part| part.fill(0.0));
        self.set_rows(0);
    }

    /// Writes all numbers of the sum but its rows, always in the same order.
    pub(crate) fn write_to(&mut self, table: &mut Vec<f64>) {
        table.clear();
        self.parts_mut(|part| table.extend_from_slice(part));
    }

    /// Takes numbers that [`Self::write_to`] wrote.
    fn read_from(&mut self, table: &[f64], rows: usize) {
        let mut rest = table;
        self.parts_mut(|part| {
            let (own, after) = rest.split_at(part.len().min(rest.len()));
            part[..own.len()].copy_from_slice(own);
            rest = after;
        });
        self.set_rows(rows);
    }

    /// Calls `visit` with all numbers of the sum, slice by slice.
    fn parts_mut(&mut self, mut visit: impl FnMut(&mut [f64])) {
        match &mut self.way {
            Way::Moments(_, moments, _) => {
                for matrix in [&mut moments.table, &mut moments.cross] {
                    (0..matrix.ncols()).for_each(|j| visit(matrix.col_as_slice_mut(j)));
                }
                visit(&mut moments.energy);
            }
            Way::Direct(_, grams) => {
                for gram in grams {
                    for j in 0..gram.gram.ncols() {
                        visit(&mut gram.gram.col_as_slice_mut(j)[j..]);
                    }
                    let cross = &mut gram.cross;
                    (0..cross.ncols()).for_each(|j| visit(cross.col_as_slice_mut(j)));
                    visit(&mut gram.energy);
                }
            }
        }
    }

    fn set_rows(&mut self, rows: usize) {
        match &mut self.way {
            Way::Moments(_, moments, _) => moments.rows = rows,
            Way::Direct(_, grams) => grams.iter_mut().for_each(|gram| gram.rows = rows as f64),
        }
    }
}

/// The responses an equation explains: all of them if there is one equation, else its own.
pub(crate) fn responses_of(
    equation: usize,
    n_equations: usize,
    n_responses: usize,
) -> Range<usize> {
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
fn accumulate_rows(
    evaluator: &Evaluator,
    grams: &mut [NormalEquations],
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
        gram.rows += samples.n_rows() as f64;
    }
    Ok(())
}
