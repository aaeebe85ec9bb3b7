//! Sums of a library over the rows of each pattern.

use crate::error::IdentifyError;
use crate::library::{Basis, SummedLibrary};
use crate::noise::{NoiseFloor, NoiseSum};
use crate::patterns::{LEAST_SHARE, PatternPlan, Patterns};
use crate::rows::{Gathering, clear_of_reversals, samples_of};
use crate::step::Step;
use std::borrow::Cow;
use torquewise_model::FrictionTerm;
use torquewise_model::model::Choice;
use torquewise_motion::{Motion, Pattern, ReadError};
use torquewise_regression::SparseError;
use torquewise_regression::row_sums::{RowAdder, RowSums};

/// What logs were summed up to for a library.
#[derive(Clone, Debug)]
pub struct LibrarySums {
    /// Which columns were summed.
    pub library: SummedLibrary,
    /// How rows were told apart, log by log.
    pub patterns: PatternPlan,
    /// What the rows of each pattern say, or all rows.
    pub sums: Vec<RowSums>,
    /// The noise at standstill, if enough rows stand still.
    pub still: Option<NoiseFloor>,
    /// How the laws of friction among the candidates were chosen.
    pub choices: Vec<Choice>,
}

impl LibrarySums {
    /// The patterns that some log shows in more than a few rows, of those that all logs together
    /// show: a short log may take its slowest motion for none. The rows of the others join those of
    /// variable velocity, which assume nothing. Where all rows are one sum, the patterns stay.
    ///
    /// - `rows`: those of all logs
    pub(crate) fn assign_patterns(
        &mut self,
        basis: &Basis,
        together: &[Pattern],
        rows: usize,
    ) -> Result<Vec<Pattern>, IdentifyError> {
        if self.sums.len() < Pattern::ALL.len() {
            return Ok(together.to_vec());
        }
        let least = LEAST_SHARE * rows as f64;
        let last = Pattern::VariableVelocity as usize;
        let mut present = Vec::new();
        for pattern in Pattern::ALL {
            let place = pattern as usize;
            let is_shown = place == last || together.contains(&pattern);
            if is_shown && self.sums[place].rows() as f64 > least {
                present.push(pattern);
            } else if place != last {
                let few = std::mem::replace(&mut self.sums[place], RowSums::new(&basis.prepared));
                self.sums[last].merge(&few)?;
            }
        }
        Ok(present)
    }

    /// The sums over the rows of a step.
    pub(crate) fn of_step(&self, step: &Step) -> &RowSums {
        &self.sums[step.pattern.map_or(0, |pattern| pattern as usize)]
    }

    /// All rows as one.
    pub(crate) fn whole(&self, basis: &Basis) -> Result<RowSums, SparseError> {
        let mut whole = RowSums::new(&basis.prepared);
        self.sums.iter().try_for_each(|sums| whole.merge(sums))?;
        Ok(whole)
    }
}

/// Hands each row of a log to the sums of its pattern.
pub struct PatternAccumulator<'a> {
    patterns: &'a Patterns,
    friction: &'a [FrictionTerm],
    noise: NoiseSum,
    bins: Vec<Bin<'a>>,
}

struct Bin<'a> {
    gathering: Gathering,
    adder: RowAdder<'a>,
}

impl<'a> PatternAccumulator<'a> {
    /// Empty sums of each part.
    ///
    /// - `parts`: the patterns whose rows are summed apart; `None` stands for all rows
    pub fn new(basis: &'a Basis, patterns: &'a Patterns, parts: &[Option<Pattern>]) -> Self {
        let n = basis.candidates.n_joints;
        let friction = &basis.candidates.friction[..];
        let bin = |&pattern: &Option<Pattern>| Bin {
            gathering: Gathering::new(pattern, n, friction.len()),
            adder: RowAdder::new(&basis.prepared),
        };
        let bins = parts.iter().map(bin).collect();
        Self { patterns, friction, noise: NoiseSum::new(n), bins }
    }

    /// Adds a block of the log.
    ///
    /// # Errors
    /// [`ReadError`] if it holds no torque, or numbers too large to be summed.
    pub fn add(&mut self, block: &Motion) -> Result<(), ReadError> {
        let labels = self.patterns.label(block);
        self.noise.add(block, |row| labels[row] == Pattern::Standstill);
        match clear_of_reversals(block, self.friction) {
            Cow::Borrowed(block) => self.add_rows(block, &labels),
            Cow::Owned(block) => self.add_rows(&block, &self.patterns.label(&block)),
        }
    }

    fn add_rows(&mut self, block: &Motion, labels: &[Pattern]) -> Result<(), ReadError> {
        let samples = samples_of(block, self.friction)?;
        for bin in &mut self.bins {
            for full in bin.gathering.add(&samples, labels) {
                bin.adder.push(full)?;
            }
        }
        Ok(())
    }

    /// The sums of each part, and the noise at standstill.
    ///
    /// # Errors
    /// [`SparseError`] if its numbers are too large to be summed.
    pub fn finish(self) -> Result<(Vec<RowSums>, NoiseSum), SparseError> {
        let sums = self.bins.into_iter().map(|mut bin| {
            if let Some(rest) = bin.gathering.take() {
                bin.adder.push(rest)?;
            }
            bin.adder.finish()
        });
        Ok((sums.collect::<Result<_, _>>()?, self.noise))
    }
}
