//! Exact sums over blocks of rows: the same bits whatever the split, order or threads.

use crate::accumulate::{GramSum, Prepared};
use crate::error::SparseError;
use crate::exact::{ExactSums, add_tables};
use crate::normal_equations::NormalEquations;
use crate::samples::Samples;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// What rows say of a design: its moments or its normal equations, summed without rounding.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct RowSums {
    sums: ExactSums,
    rows: usize,
}

impl RowSums {
    /// The sums of no rows.
    pub fn new(prepared: &Prepared) -> Self {
        Self { sums: ExactSums::zeros(prepared.n_sums()), rows: 0 }
    }

    /// Rows summed.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Adds the rows of another.
    ///
    /// # Errors
    /// [`SparseError::Shape`] if the two were made for different designs.
    pub fn merge(&mut self, other: &Self) -> Result<(), SparseError> {
        self.sums.merge(&other.sums)?;
        self.rows += other.rows;
        Ok(())
    }

    /// The normal equations of each equation, in some of the columns of the design.
    pub fn grams(&self, prepared: &Prepared, columns: &[usize]) -> Vec<NormalEquations> {
        let mut table = vec![0.0; self.sums.len()];
        self.sums.write_to(0, &mut table);
        prepared.grams_of(&table, self.rows, columns)
    }

    /// Whether they are sums for the design.
    pub fn is_sound(&self, prepared: &Prepared) -> bool {
        self.sums.len() == prepared.n_sums()
    }
}

/// Blocks that are summed in floating point before the sum is added exactly.
///
/// Few enough for a rounding that no one sees, enough that exact sums cost next to nothing.
const CHUNK_BLOCKS: usize = 4;
/// Memory that the sums of all lanes together may take.
const LANE_BYTES: usize = 128 << 20;

/// Sums blocks, as many chunks at a time as there are threads.
///
/// Chunks are cut by the number of the block alone, and their sums are added exactly: which thread
/// sums which chunk leaves no trace.
pub struct RowAdder<'a> {
    lanes: Vec<Lane<'a>>,
    waiting: Vec<Samples>,
    total: RowSums,
}

/// The sum of a chunk, and its numbers.
struct Lane<'a> {
    sum: GramSum<'a>,
    table: Vec<f64>,
}

impl<'a> RowAdder<'a> {
    /// Starts from nothing.
    pub fn new(prepared: &'a Prepared) -> Self {
        // Numbers of a sum, and the square that a triangle of them is kept in.
        let most = (LANE_BYTES / (2 * 8 * prepared.n_sums()).max(1)).max(1);
        let lane = |_| Lane { sum: prepared.start(), table: Vec::new() };
        let lanes = (0..rayon::current_num_threads().clamp(1, most)).map(lane).collect();
        Self { lanes, waiting: Vec::new(), total: RowSums::new(prepared) }
    }

    /// Hands over the next block.
    ///
    /// # Errors
    /// [`SparseError`] if a block does not fit, or holds what is too large to be summed.
    pub fn push(&mut self, samples: Samples) -> Result<(), SparseError> {
        self.waiting.push(samples);
        if self.waiting.len() == CHUNK_BLOCKS * self.lanes.len() { self.drain() } else { Ok(()) }
    }

    /// The sums of all blocks.
    ///
    /// # Errors
    /// As [`Self::push`].
    pub fn finish(mut self) -> Result<RowSums, SparseError> {
        self.drain()?;
        Ok(self.total)
    }

    fn drain(&mut self) -> Result<(), SparseError> {
        let chunks = self.waiting.par_chunks(CHUNK_BLOCKS);
        let work = self.lanes.par_iter_mut().zip(chunks).map(|(lane, blocks)| {
            lane.sum.clear();
            blocks.iter().try_for_each(|block| lane.sum.add(block))?;
            lane.sum.write_to(&mut lane.table);
            Ok(&lane.table[..])
        });
        let tables = work.collect::<Result<Vec<&[f64]>, SparseError>>()?;
        add_tables(&mut self.total.sums, &tables)?;
        self.total.rows += self.waiting.drain(..).map(|block| block.n_rows()).sum::<usize>();
        Ok(())
    }
}
