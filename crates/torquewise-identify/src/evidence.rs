//! Recording, patterns → normal equations of each step: one pass, all that selection needs.

use crate::candidates::Candidates;
use crate::error::IdentifyError;
use crate::noise::{NoiseFloor, NoiseSum};
use crate::patterns::{Patterns, place_of};
use crate::rows::{Gathering, clear_of_reversals, samples_of};
use std::borrow::Cow;
use torquewise_model::FrictionTerm;
use torquewise_motion::{Motion, Pattern, ReadError, Recording};
use torquewise_sparse::accumulate::{GramSum, Lanes, Prepared, Route, cheaper_route};
use torquewise_sparse::gram::Gram;
use torquewise_sparse::samples::Samples;

/// One regression: the rows of a pattern, or all, and the candidates they are asked for.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// Whose rows; `None` for all.
    pub pattern: Option<Pattern>,
    /// Columns offered, ascending.
    pub offered: Vec<usize>,
    /// Columns that play a part: offered now or found before, ascending.
    pub columns: Vec<usize>,
}

impl Step {
    /// Name of its pattern.
    pub fn name(&self) -> &'static str {
        self.pattern.map_or("all rows", Pattern::name)
    }
}

/// What the rows of a step say.
#[derive(Clone, Debug)]
pub struct Evidence {
    /// Normal equations of each equation of the design, in the columns of the step.
    pub grams: Vec<Gram>,
    /// How they were come by.
    pub route: Route,
    /// Rows.
    pub rows: usize,
}

/// The steps a log allows: the candidates of a pattern it does not show join the next step.
///
/// Returns the steps and the candidates that no pattern is left for.
pub fn plan_steps(candidates: &Candidates, present: &[Pattern]) -> (Vec<Step>, Vec<usize>) {
    let mut steps: Vec<Step> = Vec::new();
    let (mut waiting, mut known) = (Vec::new(), Vec::new());
    for pattern in Pattern::ALL {
        waiting.extend(&candidates.offered[place_of(pattern)]);
        if present.contains(&pattern) {
            let offered = ascending(std::mem::take(&mut waiting));
            known.extend(&offered);
            known = ascending(known);
            steps.push(Step { pattern: Some(pattern), offered, columns: known.clone() });
        }
    }
    (steps, ascending(waiting))
}

/// The one step of one-shot SINDy.
pub fn one_shot(candidates: &Candidates) -> Vec<Step> {
    let columns: Vec<usize> = (0..candidates.len()).collect();
    vec![Step { pattern: None, offered: columns.clone(), columns }]
}

fn ascending(mut columns: Vec<usize>) -> Vec<usize> {
    columns.sort_unstable();
    columns.dedup();
    columns
}

/// Sums the normal equations of all steps, and the noise at standstill if there is enough, in one
/// pass.
///
/// # Errors
/// [`IdentifyError::Read`] with the reader's message.
pub fn gather_evidence(
    recording: &(impl Recording + ?Sized),
    patterns: &Patterns,
    candidates: &Candidates,
    steps: &[Step],
    n_rows: usize,
) -> Result<(Vec<Evidence>, Option<NoiseFloor>), IdentifyError> {
    let n = recording.joints().len();
    let mut prepared = Vec::with_capacity(steps.len());
    for step in steps {
        let design = candidates.design.subset(&step.columns)?;
        let route = cheaper_route(&design, n, n_rows / steps.len().max(1));
        prepared.push((Prepared::new(&design, route), route));
    }
    let mut sorter = Sorter::new(n, &candidates.friction, steps, &prepared);
    let mut noise = NoiseSum::new(n);
    recording
        .read(&mut |_, block| {
            let labels = patterns.label(block);
            noise.add(block, |row| labels[row] == Pattern::Standstill);
            match clear_of_reversals(block, &candidates.friction) {
                Cow::Borrowed(block) => sorter.add(block, &labels),
                Cow::Owned(block) => sorter.add(&block, &patterns.label(&block)),
            }
        })
        .map_err(IdentifyError::Read)?;
    Ok((sorter.finish(&prepared)?, noise.finish_still()))
}

/// Hands each row to the step of its pattern.
struct Sorter<'a> {
    friction: &'a [FrictionTerm],
    steps: Vec<Bin<'a>>,
}

struct Bin<'a> {
    pattern: Option<Pattern>,
    gathering: Gathering,
    lanes: Lanes<GramSum<'a>>,
    rows: usize,
}

impl<'a> Sorter<'a> {
    fn new(
        n_joints: usize,
        friction: &'a [FrictionTerm],
        steps: &[Step],
        prepared: &'a [(Prepared, Route)],
    ) -> Self {
        let bin = |(step, (design, _)): (&Step, &'a (Prepared, Route))| Bin {
            pattern: step.pattern,
            gathering: Gathering::new(n_joints, friction.len()),
            lanes: Lanes::new(design.size(n_joints), |_| design.start(n_joints)),
            rows: 0,
        };
        Self { friction, steps: steps.iter().zip(prepared).map(bin).collect() }
    }

    fn add(&mut self, block: &Motion, labels: &[Pattern]) -> Result<(), ReadError> {
        let samples = samples_of(block, self.friction)?;
        for bin in &mut self.steps {
            for (row, &label) in labels.iter().enumerate() {
                if bin.pattern.is_none_or(|pattern| pattern == label) {
                    bin.rows += 1;
                    let full: Option<Samples> = bin.gathering.push(&samples, row);
                    full.map_or(Ok(()), |full| bin.lanes.push(full))?;
                }
            }
        }
        Ok(())
    }

    fn finish(self, prepared: &[(Prepared, Route)]) -> Result<Vec<Evidence>, IdentifyError> {
        let mut evidence = Vec::with_capacity(self.steps.len());
        for (mut bin, (_, route)) in self.steps.into_iter().zip(prepared) {
            if let Some(rest) = bin.gathering.take() {
                bin.lanes.push(rest)?;
            }
            let grams = bin.lanes.finish()?.grams();
            evidence.push(Evidence { grams, route: *route, rows: bin.rows });
        }
        Ok(evidence)
    }
}
