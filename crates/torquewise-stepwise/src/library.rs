//! Which columns are summed, and their sums over the rows of each pattern.

use crate::model_selection::choose_laws;
use crate::noise::NoiseSum;
use crate::patterns::LEAST_SHARE;
use crate::progress::Watch;
use crate::{
    Candidates, FrictionKind, IdentifyError, LibraryKind, LibraryOptions, NoiseFloor, PatternPlan,
    PatternSums, Patterns, Progress, Regression, clear_of_reversals, samples_of, survey,
};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use torquewise_model::{Choice, FrictionTerm, JointKinds};
use torquewise_motion::{BLOCK_ROWS, Motion, Pattern, ReadError, Recording};
use torquewise_regression::{PreparedDesign, RowAdder, RowSums, SparseError};

/// Which columns are summed, and over which rows together.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SummedLibrary {
    /// Candidates.
    pub kind: LibraryKind,
    /// Which joints turn and which slide.
    pub kinds: JointKinds,
    /// One-shot or stepwise: one sum over all rows, or one for each pattern.
    pub regression: Regression,
    /// Laws of friction among the candidates. They follow from the speeds of all logs together, so
    /// that summaries with friction are neither written nor merged.
    #[serde(skip)]
    pub friction: Vec<FrictionTerm>,
}

/// The candidates of a library, made ready to be summed.
pub struct Basis {
    /// The terms offered.
    pub candidates: Candidates,
    /// Their columns, as sums over rows want them.
    pub prepared: PreparedDesign,
}

/// Rows that the route to the sums is chosen for. One number for all logs, lest parts of different
/// size use different routes and do not add up.
const USUAL_ROWS: usize = 1 << 18;

impl SummedLibrary {
    /// The library of a fit with laws of friction that suit a recording, and how these were chosen.
    ///
    /// # Errors
    /// [`IdentifyError`]: the reader's message, missing torque, or a library too large.
    pub fn of(
        recording: &(impl Recording + ?Sized),
        options: &LibraryOptions,
        watch: Watch<'_>,
    ) -> Result<(Self, Vec<Choice>), IdentifyError> {
        let LibraryOptions { library: kind, regression, friction, .. } = *options;
        let kinds = options.kinds.clone();
        IdentifyError::check_kinds(&kinds, recording.joints())?;
        if friction == FrictionKind::None {
            return Ok((Self { kind, kinds, regression, friction: Vec::new() }, Vec::new()));
        }
        Progress::Survey.tell(watch)?;
        let survey = survey(recording)?;
        survey.sample.require_tau()?;
        let (friction, choices) = choose_laws(&survey, options)?;
        Ok((Self { kind, kinds, regression, friction }, choices))
    }

    /// Its candidates for n joints.
    ///
    /// # Errors
    /// [`IdentifyError::LibraryTooLarge`] if its sums would not fit into memory.
    pub fn basis(&self, n_joints: usize) -> Result<Basis, IdentifyError> {
        let (kinds, laws) = (self.kinds.all(n_joints), self.friction.clone());
        let candidates = Candidates::new(&kinds, self.kind, self.regression, laws)?;
        let prepared = PreparedDesign::cheaper(&candidates.design, n_joints, USUAL_ROWS);
        Ok(Basis { candidates, prepared })
    }

    /// The patterns whose rows are summed apart; `None` stands for all rows.
    pub fn parts(&self) -> Vec<Option<Pattern>> {
        let is_stepwise = self.regression == Regression::Stepwise;
        if is_stepwise { Pattern::ALL.map(Some).into() } else { vec![None] }
    }
}

/// What logs were summed up to for a library.
#[derive(Clone, Debug)]
pub struct LibrarySums {
    /// Which columns were summed.
    pub library: SummedLibrary,
    /// Patterns of the rows, log by log.
    pub patterns: PatternPlan,
    /// Sums of the rows of each pattern, or of all rows.
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
            if is_shown && self.sums[place].rows as f64 > least {
                present.push(pattern);
            } else if place != last {
                let few = std::mem::replace(&mut self.sums[place], RowSums::new(&basis.prepared));
                self.sums[last].merge(&few)?;
            }
        }
        Ok(present)
    }
}

/// Hands each row of a log to the sums of its pattern.
pub struct PatternAccumulator<'a> {
    patterns: &'a Patterns,
    friction: &'a [FrictionTerm],
    noise: NoiseSum,
    sums: Vec<PatternSums<'a>>,
}

impl<'a> PatternAccumulator<'a> {
    /// Empty sums of each part.
    ///
    /// - `parts`: the patterns whose rows are summed apart; `None` stands for all rows
    pub fn new(basis: &'a Basis, patterns: &'a Patterns, parts: &[Option<Pattern>]) -> Self {
        let (n, friction) = (basis.candidates.n_joints, &basis.candidates.friction[..]);
        let widths = (n, friction.len());
        let adder = || vec![RowAdder::new(&basis.prepared)];
        let empty = |&part| PatternSums::new(part, widths, BLOCK_ROWS, adder());
        let sums = parts.iter().map(empty).collect();
        Self { patterns, friction, noise: NoiseSum::new(n), sums }
    }

    /// Adds a block of the log.
    ///
    /// # Errors
    /// [`ReadError`] if it holds no torque, or numbers too large to be summed.
    pub fn add(&mut self, block: &Motion) -> Result<(), ReadError> {
        let mut labels = self.patterns.label(block);
        self.noise.add(block, |row| labels[row] == Pattern::Standstill);
        let clear = clear_of_reversals(block, self.friction);
        if let Cow::Owned(clear) = &clear {
            labels = self.patterns.label(clear);
        }
        let samples = samples_of(&clear, self.friction)?;
        self.sums.iter_mut().try_for_each(|sums| sums.add(&samples, &labels))?;
        Ok(())
    }

    /// The sums of each part, and the noise at standstill.
    ///
    /// # Errors
    /// [`SparseError`] if its numbers are too large to be summed.
    pub fn finish(self) -> Result<(Vec<RowSums>, NoiseSum), SparseError> {
        let sums = self.sums.into_iter().map(PatternSums::finish);
        Ok((sums.collect::<Result<Vec<_>, _>>()?.concat(), self.noise))
    }
}
