//! From steps with a weight for every row of every equation to terms selected \[E17\].

use crate::error::ExperimentError;
use crate::study::cost::samples_of;
use crate::study::indicators::first_fit::FirstFit;
use faer::Mat;
use torquewise_regression::problem::{Problem, Selection};
use torquewise_regression::products;
use torquewise_regression::samples::{Evaluator, Samples};
use torquewise_regression::select::Selector;
use torquewise_stepwise::candidates::Group;

/// Rows evaluated at a time.
const BLOCK_ROWS: usize = 2_048;
/// Rounds of weighing the joints by what the round before left unexplained.
const ROUNDS: usize = 2;
/// Normal equations keep about 13 digits.
const ROUNDING: f64 = 1e-13;

/// One regression: the columns it offers, and how much each row counts.
pub(super) struct WeightedStep {
    /// Columns offered, ascending.
    pub(super) offered: Vec<usize>,
    /// Weight of each row in the equation of each joint, m×n; zero for rows that are not asked.
    pub(super) weights: Mat<f64>,
}

/// The terms that steps select.
pub(super) struct Selected {
    /// Weight of each candidate, per group.
    pub(super) coefficients: Vec<Vec<f64>>,
    /// One over the unexplained variance of each equation after the last step, per group.
    pub(super) equation_weights: Vec<Vec<f64>>,
}

/// Takes the steps in turn: each regresses what those before it leave unexplained.
pub(super) fn take_steps(
    first: &FirstFit,
    steps: &[WeightedStep],
) -> Result<Selected, ExperimentError> {
    let p = first.candidates.len();
    let mut selected = Selected {
        coefficients: vec![vec![0.0; p]; first.groups.len()],
        equation_weights: first.groups.iter().map(|g| vec![1.0; g.equations.len()]).collect(),
    };
    for step in steps {
        for known in &mut selected.coefficients {
            for &column in &step.offered {
                known[column] = 0.0;
            }
        }
        let equations = normal_equations(first, step, &selected.coefficients)?;
        for (place, (group, parts)) in first.groups.iter().zip(equations).enumerate() {
            let (found, weights) = select(group, &parts, &Selector::Criterion(first.criterion))?;
            let known = &mut selected.coefficients[place];
            for &j in &found.active {
                known[step.offered[j]] = found.coefficients[j];
            }
            selected.equation_weights[place] = weights;
        }
    }
    Ok(selected)
}

/// Weighted normal equations of one equation: YᵀUY, YᵀUr, rᵀUr and the number of rows.
#[derive(Clone)]
struct NormalEquations {
    gram: Mat<f64>,
    cross: Vec<f64>,
    energy: f64,
    /// What rounding leaves of the torque.
    least: f64,
    rows: f64,
}

impl NormalEquations {
    fn zeros(p: usize) -> Self {
        Self { gram: Mat::zeros(p, p), cross: vec![0.0; p], energy: 0.0, least: 0.0, rows: 0.0 }
    }

    /// One over the mean square that coefficients leave; 1 where nothing is left.
    fn weight(&self, coefficients: &[f64]) -> f64 {
        let mut left = self.energy;
        for (j, &c) in coefficients.iter().enumerate().filter(|(_, c)| **c != 0.0) {
            let fitted: f64 = (0..coefficients.len())
                .map(|i| self.gram[(i.max(j), i.min(j))] * coefficients[i])
                .sum();
            left += c * (fitted - 2.0 * self.cross[j]);
        }
        let left = left.max(self.least);
        if left > 0.0 { self.rows / left } else { 1.0 }
    }
}

/// Selects terms of a group; equations are weighted by what they leave unexplained, first of the
/// torque, then of the first fit.
fn select(
    group: &Group,
    parts: &[NormalEquations],
    selector: &Selector,
) -> Result<(Selection, Vec<f64>), ExperimentError> {
    let p = parts.first().map_or(0, |part| part.cross.len());
    let nothing = Selection {
        coefficients: vec![0.0; p],
        active: Vec::new(),
        dependent: Vec::new(),
        certificate: None,
    };
    let mut found = nothing;
    for _ in 0..if group.equations.len() > 1 { ROUNDS } else { 1 } {
        let (mut gram, mut cross) = (Mat::<f64>::zeros(p, p), vec![0.0; p]);
        let (mut energy, mut rows) = (0.0, 0.0);
        for part in parts {
            let weight = part.weight(&found.coefficients);
            gram += faer::Scale(weight) * &part.gram;
            cross.iter_mut().zip(&part.cross).for_each(|(sum, c)| *sum += weight * c);
            energy += weight * part.energy;
            rows += part.rows;
        }
        found = selector.select(&Problem::new(gram, cross, energy, rows.max(1.0))?)?;
    }
    let weights = parts.iter().map(|part| part.weight(&found.coefficients)).collect();
    Ok((found, weights))
}

/// The normal equations of the offered columns for what is unexplained, per group and equation.
fn normal_equations(
    first: &FirstFit,
    step: &WeightedStep,
    known: &[Vec<f64>],
) -> Result<Vec<Vec<NormalEquations>>, ExperimentError> {
    let (n, p) = (first.n_joints(), step.offered.len());
    let mut parts = vec![NormalEquations::zeros(p); n];
    let sources = sources(first, &step.weights);
    let offered = Evaluator::new(first.candidates.design.subset(&step.offered)?);
    let asked = |row: &usize| (0..n).any(|joint| step.weights[(*row, joint)] > 0.0);
    let rows: Vec<usize> = (0..first.n_rows()).filter(asked).collect();
    for rows in rows.chunks(BLOCK_ROWS) {
        let block = samples_of(&first.log.select(rows))?;
        let columns = offered.columns(&block)?;
        for (group, known) in first.groups.iter().zip(known) {
            let residual = unexplained(first, group, known, &block)?;
            for (&(equation, joint), residual) in group.equations.iter().zip(residual) {
                let weights: Vec<f64> =
                    rows.iter().map(|&row| step.weights[(row, joint)]).collect();
                let tau = block.responses.col_as_slice(joint);
                let part = &mut parts[joint];
                part.least += ROUNDING * dot(tau, tau, &weights);
                part.energy += dot(&residual, &residual, &weights);
                part.rows += weights.iter().filter(|w| **w > 0.0).count() as f64;
                for (j, sum) in part.cross.iter_mut().enumerate() {
                    *sum += dot(columns[equation].col_as_slice(j), &residual, &weights);
                }
                if sources[joint] == joint {
                    add_gram(&mut part.gram, &columns[equation], &weights);
                }
            }
        }
    }
    for joint in 0..n {
        if sources[joint] != joint {
            parts[joint].gram = parts[sources[joint]].gram.clone();
        }
    }
    let of = |group: &Group| group.equations.iter().map(|&(_, j)| parts[j].clone()).collect();
    Ok(first.groups.iter().map(of).collect())
}

/// The first joint whose columns and weights are the same as those of each joint, n.
fn sources(first: &FirstFit, weights: &Mat<f64>) -> Vec<usize> {
    let shared = first.candidates.design.n_equations() == 1;
    let same = |a: usize, b: usize| weights.col_as_slice(a) == weights.col_as_slice(b);
    (0..first.n_joints())
        .map(|joint| (0..joint).find(|&other| shared && same(joint, other)).unwrap_or(joint))
        .collect()
}

/// Torque less what is known of it, for each equation of a group.
fn unexplained(
    first: &FirstFit,
    group: &Group,
    known: &[f64],
    block: &Samples,
) -> Result<Vec<Vec<f64>>, ExperimentError> {
    let active: Vec<usize> = (0..known.len()).filter(|&column| known[column] != 0.0).collect();
    let columns = Evaluator::new(first.candidates.design.subset(&active)?).columns(block)?;
    let left = |&(equation, joint): &(usize, usize)| {
        let mut left = block.responses.col_as_slice(joint).to_vec();
        for (j, &column) in active.iter().enumerate() {
            let values = columns[equation].col_as_slice(j);
            left.iter_mut().zip(values).for_each(|(r, y)| *r -= known[column] * y);
        }
        left
    };
    Ok(group.equations.iter().map(left).collect())
}

/// Σ a b w
fn dot(a: &[f64], b: &[f64], weights: &[f64]) -> f64 {
    a.iter().zip(b).zip(weights).map(|((a, b), w)| a * b * w).sum()
}

/// Adds YᵀUY to the lower triangle of `gram`.
pub(super) fn add_gram(gram: &mut Mat<f64>, columns: &Mat<f64>, weights: &[f64]) {
    let mut scaled = columns.clone();
    for j in 0..scaled.ncols() {
        let column = scaled.col_as_slice_mut(j).iter_mut().zip(weights);
        column.for_each(|(y, w)| *y *= w.sqrt());
    }
    products::add_gram(gram, scaled.as_ref(), 1.0);
}
