//! One step: regressing what the earlier steps leave unexplained.

use crate::candidates::Group;
use crate::step_equations::{Step, StepEquations};
use faer::Mat;
use torquewise_regression::SparseError;
use torquewise_regression::gram::Gram;
use torquewise_regression::problem::Problem;
use torquewise_regression::select::Selector;

/// Rounds of weighing the joints by what the round before left unexplained.
const ROUNDS: usize = 2;

/// Selects among the offered columns of a step, given what is known.
///
/// - `known`: weight of each column of the library, p
/// - returns: (column of the library, weight) of the offered columns that stay
///
/// Rows of several joints are divided by their own noise, or the strong joints drown the wrist:
/// first the unexplained torque, then the residual of the first fit stands for it.
pub(crate) fn select(
    step: &Step,
    equations: &StepEquations,
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
    let grams = &equations.grams[..];
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
    grams: &[Gram],
    equations: &[(usize, usize)],
    weights: &[f64],
    fixed: &[f64],
    places: &[usize],
) -> Result<Problem, SparseError> {
    let p = places.len();
    let (mut gram, mut cross) = (Mat::<f64>::zeros(p, p), vec![0.0; p]);
    let (mut energy, mut rows) = (0.0, 0.0);
    for (&(equation, response), &weight) in equations.iter().zip(weights) {
        let part = &grams[equation];
        let own = response_index(grams.len(), response);
        for (j, &column) in places.iter().enumerate() {
            let from = part.gram.col_as_slice(column);
            for (out, &row) in gram.col_as_slice_mut(j).iter_mut().zip(places) {
                *out += weight * from[row];
            }
            let explained: f64 = from.iter().zip(fixed).map(|(g, c)| g * c).sum();
            cross[j] += weight * (part.cross[(column, own)] - explained);
        }
        energy += weight * unexplained(grams, equation, response, fixed);
        rows += part.rows as f64;
    }
    Problem::new(gram, cross, energy, rows.max(1.0))
}

/// One over the unexplained variance of each joint of a group.
pub(crate) fn noise_weights(grams: &[Gram], group: &Group, total: &[f64]) -> Vec<f64> {
    group
        .equations
        .iter()
        .map(|&(equation, response)| {
            let rows = grams[equation].rows as f64;
            let left = unexplained(grams, equation, response, total);
            if left > 0.0 { rows / left } else { 1.0 }
        })
        .collect()
}

/// ‖τ − Y c‖² of one equation, at least what rounding leaves of it.
pub(crate) fn unexplained(grams: &[Gram], equation: usize, response: usize, total: &[f64]) -> f64 {
    residual_energy(&grams[equation], response_index(grams.len(), response), total)
}

/// The same of one response of normal equations.
pub(crate) fn residual_energy(part: &Gram, own: usize, total: &[f64]) -> f64 {
    let mut left = part.energy[own];
    for (j, &weight) in total.iter().enumerate().filter(|&(_, &weight)| weight != 0.0) {
        let fitted: f64 = part.gram.col_as_slice(j).iter().zip(total).map(|(g, c)| g * c).sum();
        left += weight * (fitted - 2.0 * part.cross[(j, own)]);
    }
    left.max(ROUNDING * part.energy[own])
}

/// Sums over rows keep about 13 digits.
const ROUNDING: f64 = 1e-13;

/// Place of a response in the cross products of its equation.
pub(crate) fn response_index(n_equations: usize, response: usize) -> usize {
    if n_equations == 1 { response } else { 0 }
}
