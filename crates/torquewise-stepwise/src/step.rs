//! One step: which rows are asked for which candidates, and the regression of what the earlier steps
//! leave unexplained.

use crate::{Candidates, Regression};
use torquewise_motion::Pattern;
use torquewise_regression::{NormalEquations, Selector, SparseError, ascending};

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

/// The steps a log allows: the candidates of a pattern it does not show join the next step; the one
/// step of one-shot SINDy.
///
/// Returns the steps and the candidates that no pattern is left for.
pub fn plan_steps(
    candidates: &Candidates,
    regression: Regression,
    present: &[Pattern],
) -> (Vec<Step>, Vec<usize>) {
    if regression == Regression::OneShot {
        let columns: Vec<usize> = (0..candidates.n_columns()).collect();
        return (vec![Step { pattern: None, offered: columns.clone(), columns }], Vec::new());
    }
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

/// Finds the offered columns of a step anew, given what is known.
///
/// - `grams`: of each equation, in the columns of the step
/// - `joints`: those whose torque they explain together
/// - `known`: weight of each column of the library, p
///
/// Rows of several joints are divided by their own noise, or the strong joints drown the wrist:
/// first the unexplained torque, then the residual of the first fit stands for it.
pub(crate) fn take_step(
    step: &Step,
    grams: &[NormalEquations],
    (candidates, joints): (&Candidates, &[usize]),
    known: &mut [f64],
    selector: &Selector,
) -> Result<(), SparseError> {
    for &column in &step.offered {
        known[column] = 0.0;
    }
    let is_own = |column: &usize| candidates.is_of(joints, *column);
    let places: Vec<usize> = (step.offered.iter().copied().filter(is_own))
        .filter_map(|column| step.columns.binary_search(&column).ok())
        .collect();
    // Only the rest of what is known counts as explained.
    let fixed: Vec<f64> = step.columns.iter().map(|&column| known[column]).collect();
    let mut total = fixed.clone();
    for _ in 0..if joints.len() > 1 { ROUNDS } else { 1 } {
        let weights = noise_weights(grams, joints, &total);
        let problem = weighted_problem(grams, joints, &weights, &fixed, &places)?;
        let selection = selector.select(&problem)?;
        for (&place, &weight) in places.iter().zip(&selection.coefficients) {
            total[place] = weight;
        }
    }
    for &place in &places {
        known[step.columns[place]] = total[place];
    }
    Ok(())
}

/// Normal equations of some columns for the torque that `fixed` weights of all leave unexplained.
///
/// - `joints`: their equations are added up with their `weights`
/// - `places`: the columns
pub(crate) fn weighted_problem(
    grams: &[NormalEquations],
    joints: &[usize],
    weights: &[f64],
    fixed: &[f64],
    places: &[usize],
) -> Result<NormalEquations, SparseError> {
    let mut sum = NormalEquations::zeros(places.len(), 1);
    for (&joint, &weight) in joints.iter().zip(weights) {
        let (gram, response) = of_joint(grams, joint);
        let mut left = gram.left_by(fixed, response, places);
        left.energy[0] = unexplained(grams, joint, fixed);
        sum.add(&left, weight)?;
    }
    sum.rows = sum.rows.max(1.0);
    sum.checked()
}

/// One over the unexplained variance of each of some joints.
pub(crate) fn noise_weights(
    grams: &[NormalEquations],
    joints: &[usize],
    total: &[f64],
) -> Vec<f64> {
    let weight = |&joint: &usize| {
        let left = unexplained(grams, joint, total);
        if left > 0.0 { of_joint(grams, joint).0.rows / left } else { 1.0 }
    };
    joints.iter().map(weight).collect()
}

/// ‖τ − Y c‖² of one joint, at least what rounding leaves of it.
pub(crate) fn unexplained(grams: &[NormalEquations], joint: usize, total: &[f64]) -> f64 {
    let (gram, response) = of_joint(grams, joint);
    gram.residual_energy(total, response).max(ROUNDING * gram.energy[response])
}

/// Sums over rows keep about 13 digits.
const ROUNDING: f64 = 1e-13;

/// The normal equations of a joint, and the place of its torque in them: one equation serves all
/// joints, or each has its own.
pub(crate) fn of_joint(grams: &[NormalEquations], joint: usize) -> (&NormalEquations, usize) {
    if let [all] = grams { (all, joint) } else { (&grams[joint], 0) }
}
