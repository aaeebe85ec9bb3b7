//! One step: which rows are asked for which candidates, and the regression of what the earlier steps
//! leave unexplained.

use crate::candidates::{Candidates, Group};
use torquewise_motion::Pattern;
use torquewise_regression::SparseError;
use torquewise_regression::normal_equations::NormalEquations;
use torquewise_regression::select::Selector;

/// Rounds of weighing the joints by what the round before left unexplained.
const ROUNDS: usize = 2;

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

/// The steps a log allows: the candidates of a pattern it does not show join the next step.
///
/// Returns the steps and the candidates that no pattern is left for.
pub fn plan_steps(candidates: &Candidates, present: &[Pattern]) -> (Vec<Step>, Vec<usize>) {
    let mut steps: Vec<Step> = Vec::new();
    let (mut waiting, mut known) = (Vec::new(), Vec::new());
    for pattern in Pattern::ALL {
        waiting.extend(&candidates.offered[pattern as usize]);
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

/// Selects among the offered columns of a step, given what is known.
///
/// - `known`: weight of each column of the library, p
/// - returns: (column of the library, weight) of the offered columns that stay
///
/// Rows of several joints are divided by their own noise, or the strong joints drown the wrist:
/// first the unexplained torque, then the residual of the first fit stands for it.
pub(crate) fn select(
    step: &Step,
    grams: &[NormalEquations],
    group: &Group,
    known: &[f64],
    selector: &Selector,
) -> Result<Vec<(usize, f64)>, SparseError> {
    let before: Vec<f64> = step.columns.iter().map(|&column| known[column]).collect();
    // What is offered is found anew; only the rest of what is known counts as explained.
    let mut fixed = before.clone();
    let offered: Vec<usize> = step
        .offered
        .iter()
        .copied()
        .filter(|column| !group.of_other_joints.contains(column))
        .collect();
    let places: Vec<usize> =
        offered.iter().filter_map(|column| step.columns.binary_search(column).ok()).collect();
    for &place in &places {
        fixed[place] = 0.0;
    }
    let mut weights = noise_weights(grams, group, &fixed);
    let mut found = None;
    for _ in 0..if group.equations.len() > 1 { ROUNDS } else { 1 } {
        let problem = weighted_problem(grams, &group.equations, &weights, &fixed, &places)?;
        let selection = selector.select(&problem)?;
        let mut total = fixed.clone();
        for (&place, &weight) in places.iter().zip(&selection.coefficients) {
            total[place] = weight;
        }
        weights = noise_weights(grams, group, &total);
        found = Some(selection);
    }
    let Some(selection) = found else { return Ok(Vec::new()) };
    let active = selection.active.iter();
    Ok(active.map(|&j| (offered[j], selection.coefficients[j])).collect())
}

/// Normal equations of some columns for the torque that `fixed` weights of all leave unexplained.
///
/// - `equations`: (equation, response) pairs, added up with their `weights`
/// - `places`: the columns
pub(crate) fn weighted_problem(
    grams: &[NormalEquations],
    equations: &[(usize, usize)],
    weights: &[f64],
    fixed: &[f64],
    places: &[usize],
) -> Result<NormalEquations, SparseError> {
    let mut sum = NormalEquations::zeros(places.len(), 1);
    for (&(equation, response), &weight) in equations.iter().zip(weights) {
        let own = response_index(grams.len(), response);
        let mut left = grams[equation].left_by(fixed, own, places);
        left.energy[0] = unexplained(grams, equation, response, fixed);
        sum.add(&left, weight)?;
    }
    sum.rows = sum.rows.max(1.0);
    sum.checked()
}

/// One over the unexplained variance of each joint of a group.
pub(crate) fn noise_weights(grams: &[NormalEquations], group: &Group, total: &[f64]) -> Vec<f64> {
    group
        .equations
        .iter()
        .map(|&(equation, response)| {
            let rows = grams[equation].rows;
            let left = unexplained(grams, equation, response, total);
            if left > 0.0 { rows / left } else { 1.0 }
        })
        .collect()
}

/// ‖τ − Y c‖² of one equation, at least what rounding leaves of it.
pub(crate) fn unexplained(
    grams: &[NormalEquations],
    equation: usize,
    response: usize,
    total: &[f64],
) -> f64 {
    let (own, part) = (response_index(grams.len(), response), &grams[equation]);
    part.residual_energy(total, own).max(ROUNDING * part.energy[own])
}

/// Sums over rows keep about 13 digits.
const ROUNDING: f64 = 1e-13;

/// Place of a response in the cross products of its equation.
pub(crate) fn response_index(n_equations: usize, response: usize) -> usize {
    if n_equations == 1 { response } else { 0 }
}
