//! Normal equations of a design from blocks of rows, by the cheaper of two routes, in exact sums:
//! the same bits whatever the split, order or threads.

use crate::exact::ExactSums;
use crate::moments::{MomentPlan, gather, responses_of};
use crate::normal_equations::mirror_lower;
use crate::products::{add_gram, add_product};
use crate::{Design, NormalEquations, Result, Samples, expect};
use faer::Mat;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Which route computes the normal equations of a design.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Route {
    /// Moments, then gathering.
    Moments,
    /// Evaluate the rows, then a symmetric product.
    Direct,
}

/// A design made ready to be summed by one of the routes, and how many responses it explains.
pub struct PreparedDesign {
    design: Design,
    /// Those of the design, by the route of moments.
    moments: Option<MomentPlan>,
    n_responses: usize,
}

/// Three matrices of sums over rows: the moments of waves with monomials and with responses, or the
/// lower triangle of YᵀY and Yᵀy of an equation; then the energy of each response.
type Sums = [Mat<f64>; 3];

impl PreparedDesign {
    /// Makes a design ready for a route.
    pub fn new(design: &Design, n_responses: usize, route: Route) -> Self {
        let moments = (route == Route::Moments).then(|| MomentPlan::new(design));
        Self { design: design.clone(), moments, n_responses }
    }

    /// Makes a design ready for the cheaper route by multiplications: per row, and once for
    /// gathering (two per pair of atoms).
    pub fn cheaper(design: &Design, n_responses: usize, n_rows: usize) -> Self {
        let direct = Self::new(design, n_responses, Route::Direct);
        // So many go into moments at least: a cheap look before the products of a very large design
        // are listed.
        let least = design.waves.len() as f64 * design.monomials.len() as f64;
        if least <= direct.cost() {
            let moments = Self::new(design, n_responses, Route::Moments);
            let pairs = (design.n_equations() as f64) * (design.atoms.len() as f64).powi(2);
            if moments.cost() * n_rows as f64 + 2.0 * pairs < direct.cost() * n_rows as f64 {
                return moments;
            }
        }
        direct
    }

    /// Its route.
    pub fn route(&self) -> Route {
        if self.moments.is_some() { Route::Moments } else { Route::Direct }
    }

    /// Multiplications per row. The direct route evaluates the columns, then half of YᵀY each.
    pub fn cost(&self) -> f64 {
        if let Some(plan) = &self.moments {
            return plan.cost(self.n_responses);
        }
        let (p, count) = (self.design.n_columns() as f64, self.design.n_equations());
        let responses = responses_of(0, count, self.n_responses).len() as f64;
        self.design.cost() + count as f64 * p * (p / 2.0 + responses)
    }

    fn zeros(&self) -> Vec<Sums> {
        if let Some(plan) = &self.moments {
            return vec![plan.zeros(self.n_responses)];
        }
        let (p, count) = (self.design.n_columns(), self.design.n_equations());
        let own = responses_of(0, count, self.n_responses).len();
        let zeros = |_| [Mat::zeros(p, p), Mat::zeros(p, own), Mat::zeros(own, 1)];
        (0..count).map(zeros).collect()
    }

    /// All numbers of sums, always in the same order.
    fn numbers<'s>(&self, sums: &'s mut [Sums]) -> impl Iterator<Item = &'s mut [f64]> {
        let is_direct = self.moments.is_none();
        sums.iter_mut().flat_map(move |sums| {
            sums.iter_mut().enumerate().flat_map(move |(place, matrix)| {
                let is_triangle = is_direct && place == 0;
                matrix.col_iter_mut().enumerate().filter_map(move |(j, column)| {
                    let column = column.try_as_col_major_mut()?.as_slice_mut();
                    Some(&mut column[if is_triangle { j } else { 0 }..])
                })
            })
        })
    }

    fn n_sums(&self) -> usize {
        self.numbers(&mut self.zeros()).map(|part| part.len()).sum()
    }

    fn add(&self, blocks: &[Samples], sums: &mut [Sums]) -> Result<()> {
        for samples in blocks {
            samples.check(&self.design)?;
            expect("the responses of a block", samples.responses.ncols(), self.n_responses)?;
        }
        if let Some(plan) = &self.moments {
            plan.add(blocks, &mut sums[0]);
            return Ok(());
        }
        for samples in blocks {
            let columns = self.design.columns(samples)?;
            for (equation, (y, [gram, cross, energy])) in columns.iter().zip(&mut *sums).enumerate()
            {
                let own = responses_of(equation, columns.len(), self.n_responses);
                let own = samples.responses.subcols(own.start, own.len());
                add_gram(gram, y.as_ref(), 1.0);
                add_product(cross, y.as_ref(), own);
                for (r, response) in own.col_iter().enumerate() {
                    energy[(r, 0)] += response.squared_norm_l2();
                }
            }
        }
        Ok(())
    }
}

/// Sums of rows of a design: its moments or its normal equations, without rounding.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct RowSums {
    sums: ExactSums,
    /// Rows summed.
    pub rows: usize,
}

impl RowSums {
    /// The sums of no rows.
    pub fn new(prepared: &PreparedDesign) -> Self {
        Self { sums: ExactSums::zeros(prepared.n_sums()), rows: 0 }
    }

    /// Adds the rows of another.
    ///
    /// # Errors
    /// [`SparseError::Shape`](crate::SparseError::Shape) if the two were made for different designs.
    pub fn merge(&mut self, other: &Self) -> Result<()> {
        self.sums.merge(&other.sums)?;
        self.rows += other.rows;
        Ok(())
    }

    fn add(&mut self, prepared: &PreparedDesign, mut sums: Vec<Sums>) -> Result<()> {
        let mut first = 0;
        prepared.numbers(&mut sums).try_for_each(|part| {
            first += part.len();
            self.sums.add(first - part.len(), part)
        })
    }

    /// The normal equations of each equation.
    pub fn all_grams(&self, prepared: &PreparedDesign) -> Vec<NormalEquations> {
        self.grams(prepared, &(0..prepared.design.n_columns()).collect::<Vec<_>>())
    }

    /// The same in some of the columns of the design.
    pub fn grams(&self, prepared: &PreparedDesign, columns: &[usize]) -> Vec<NormalEquations> {
        let mut sums = prepared.zeros();
        for (place, value) in prepared.numbers(&mut sums).flatten().enumerate() {
            *value = self.sums.value(place);
        }
        if let Some(plan) = &prepared.moments {
            return gather(plan, &sums[0], self.rows, columns);
        }
        let own = sums.into_iter().map(|[mut gram, cross, energy]| {
            mirror_lower(&mut gram);
            let (energy, rows) = (energy.col_as_slice(0).to_vec(), self.rows as f64);
            NormalEquations { gram, cross, energy, rows }.restricted(columns)
        });
        own.collect()
    }

    /// Whether they are sums for the design.
    pub fn is_sound(&self, prepared: &PreparedDesign) -> bool {
        self.sums.count() == prepared.n_sums()
    }
}

/// Blocks that are summed in floating point before the sum is added exactly.
///
/// Few enough for a rounding that no one sees, enough that exact sums cost next to nothing.
const CHUNK_BLOCKS: usize = 4;
/// Memory that the sums of all chunks under way may take.
const CHUNK_BYTES: usize = 128 << 20;

/// Sums blocks, as many chunks at a time as there are threads.
///
/// Chunks are cut by the number of the block alone, and their sums are added exactly: which thread
/// sums which chunk leaves no trace.
pub struct RowAdder<'a> {
    prepared: &'a PreparedDesign,
    /// Blocks that are summed at a time.
    most: usize,
    waiting: Vec<Samples>,
    /// The one sum of all blocks, where they are summed in floating point as they come.
    running: Option<Vec<Sums>>,
    total: RowSums,
}

impl<'a> RowAdder<'a> {
    /// Starts from nothing.
    pub fn new(prepared: &'a PreparedDesign) -> Self {
        let total = RowSums::new(prepared);
        // Numbers of a sum, and the square that a triangle of them is kept in.
        let most = (CHUNK_BYTES / (2 * 8 * total.sums.count()).max(1)).max(1);
        let most = CHUNK_BLOCKS * rayon::current_num_threads().clamp(1, most);
        Self { prepared, most, waiting: Vec::new(), running: None, total }
    }

    /// The same for blocks that are added in floating point, one after the other.
    pub fn in_order(prepared: &'a PreparedDesign) -> Self {
        Self { most: 1, running: Some(prepared.zeros()), ..Self::new(prepared) }
    }

    /// Hands over the next block.
    ///
    /// # Errors
    /// [`SparseError`](crate::SparseError) if a block does not fit, or holds what is too large to be summed.
    pub fn push(&mut self, samples: Samples) -> Result<()> {
        self.waiting.push(samples);
        if self.waiting.len() == self.most { self.drain() } else { Ok(()) }
    }

    /// The sums of all blocks.
    ///
    /// # Errors
    /// As [`Self::push`].
    pub fn finish(mut self) -> Result<RowSums> {
        self.drain()?;
        if let Some(sums) = self.running {
            self.total.add(self.prepared, sums)?;
        }
        Ok(self.total)
    }

    fn drain(&mut self) -> Result<()> {
        let prepared = self.prepared;
        if let Some(sums) = &mut self.running {
            prepared.add(&self.waiting, sums)?;
        } else {
            let of_chunk = |blocks| {
                let mut sums = prepared.zeros();
                prepared.add(blocks, &mut sums).map(|()| sums)
            };
            let chunks = self.waiting.par_chunks(CHUNK_BLOCKS).map(of_chunk);
            for sums in chunks.collect::<Result<Vec<_>, _>>()? {
                self.total.add(prepared, sums)?;
            }
        }
        self.total.rows += self.waiting.drain(..).map(|block| block.n_rows()).sum::<usize>();
        Ok(())
    }
}
