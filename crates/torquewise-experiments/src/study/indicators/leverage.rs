//! From rows of a step to leverage: how much each alone decides of the coefficients \[E17\].

use crate::error::ExperimentError;
use crate::study::cost::samples_of;
use crate::study::indicators::first_fit::FirstFit;
use crate::study::indicators::steps::add_gram;
use faer::Mat;
use torquewise_regression::problem::Problem;
use torquewise_regression::samples::Evaluator;
use torquewise_stepwise::step_equations::Step;

/// Leverage of rows in the regression of a step, over the offered columns that the first fit kept:
/// hᵢ(t) = wᵢ yᵢ(t) (Σ wᵢ YᵢᵀYᵢ)⁻¹ yᵢ(t)ᵀ, with wᵢ one over the mean of the variance of equation i.
///
/// - `rows`: which rows of the log
/// - `variance`: effective variance of the same rows \[(N·m)²\], rows×n
/// - returns: rows×n; each group of equations sums to its number of columns
pub(super) fn leverage(
    first: &FirstFit,
    step: &Step,
    rows: &[usize],
    variance: &Mat<f64>,
) -> Result<Mat<f64>, ExperimentError> {
    let samples = samples_of(&first.log.select(rows))?;
    let mut leverage = Mat::zeros(rows.len(), first.n_joints());
    for group in &first.groups {
        let mut kept = first.kept_columns(group, step);
        kept.retain(|column| step.offered.binary_search(column).is_ok());
        let columns = Evaluator::new(first.candidates.design.subset(&kept)?).columns(&samples)?;
        let p = kept.len();
        let mut gram = Mat::zeros(p, p);
        let weight = |joint: usize| {
            let mean = variance.col_as_slice(joint).iter().sum::<f64>() / rows.len().max(1) as f64;
            if mean > 0.0 { mean.recip() } else { 1.0 }
        };
        for &(equation, joint) in &group.equations {
            add_gram(&mut gram, &columns[equation], &vec![weight(joint); rows.len()]);
        }
        let problem = Problem::new(gram, vec![0.0; p], 0.0, rows.len().max(1) as f64)?;
        let all: Vec<usize> = (0..p).collect();
        for &(equation, joint) in &group.equations {
            let y = &columns[equation];
            let across = y.transpose().to_owned();
            let solved = problem.refit_each(&all, across.as_ref())?;
            for (t, h) in leverage.col_as_slice_mut(joint).iter_mut().enumerate() {
                let sum: f64 = (0..p).map(|j| y[(t, j)] * solved[(j, t)]).sum();
                *h = weight(joint) * sum;
            }
        }
    }
    Ok(leverage)
}
