//! The steps: which rows are asked for which candidates, and what they say.

use crate::candidates::Candidates;
use crate::patterns::index_of;
use torquewise_motion::Pattern;
use torquewise_regression::accumulate::Route;
use torquewise_regression::gram::Gram;

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
pub struct StepEquations {
    /// Normal equations of each equation of the design, in the columns of the step.
    pub grams: Vec<Gram>,
    /// Which route computed them.
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
        waiting.extend(&candidates.offered[index_of(pattern)]);
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
