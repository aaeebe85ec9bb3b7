//! Strength of the prior, chosen on held-out folds (E14).

use super::equations::Equations;
use super::step::{Step, Tuning};
use faer::Mat;
use rayon::prelude::*;
use torquewise_model::model::Choice;
use torquewise_rigid::feasible::minima;
use torquewise_stepwise::error::IdentifyError;
use torquewise_stepwise::held_out::{CvScore, listed, mean};

/// The choice of the prior's strength, as the model file has it.
const STRENGTH: &str = "strength of the physical prior";
/// Strengths of the prior that are tried, the strongest first, in units of what one independent row
/// determines. Weaker ones would leave to noise what the log does not tell, and no held-out row of the
/// same log would object.
const STRENGTHS: [f64; 9] = [1e3, 1e2, 30.0, 10.0, 3.0, 1.0, 0.3, 0.1, 0.03];
/// The strength where a log is too short to choose one.
const USUAL_STRENGTH: f64 = 10.0;
/// Fewer folds with rows are too few to choose by.
const LEAST_FOLDS: usize = 3;

impl Step<'_> {
    /// Chooses how strong the prior is, at the geometry as it is, on held-out folds.
    ///
    /// A weaker prior makes no model longer: the best is taken, not the strongest near it. The prior
    /// of the geometry is that of arms, and counts as one independent row.
    pub(super) fn tuning(&self) -> Result<Tuning, IdentifyError> {
        let prior = self.repeats;
        let strengths = STRENGTHS.map(|strength| strength * prior);
        let linear = self.at.linear_indices();
        let Some(errors) = self.errors(&linear, &strengths, prior)? else {
            return Ok(Tuning { strength: USUAL_STRENGTH * prior, prior, choice: None });
        };
        let means: Vec<f64> = errors.iter().map(|errors| mean(errors)).collect();
        let place = (0..means.len()).min_by(|&a, &b| means[a].total_cmp(&means[b])).unwrap_or(0);
        let trials: Vec<CvScore> = (STRENGTHS.iter().zip(&errors))
            .map(|(strength, errors)| CvScore {
                label: strength.to_string(),
                complexity: linear.len(),
                errors: errors.iter().map(|error| error * self.relative_noise).collect(),
            })
            .collect();
        let choice = Some(Choice {
            what: STRENGTH.into(),
            chosen: trials[place].label.clone(),
            rule: format!("least error, {} regions held out", errors[place].len()),
            from: listed(&trials),
        });
        Ok(Tuning { strength: strengths[place], prior, choice })
    }

    /// What each of some strengths leaves on each held-out fold; nothing if folds are few.
    pub(super) fn errors(
        &self,
        active: &[usize],
        strengths: &[f64],
        prior: f64,
    ) -> Result<Option<Vec<Vec<f64>>>, IdentifyError> {
        let folds = self.sums.folds();
        if folds.len() < LEAST_FOLDS {
            return Ok(None);
        }
        let of_fold = |&fold: &usize| {
            let (held, rest, share) = self.without(fold);
            let start: Vec<f64> = active.iter().map(|&k| self.start[k]).collect();
            let rest = rest.of(active, self.at, (share * prior, 0.0));
            let found = minima(rest.quadratic(), &self.prior, strengths, &start)?;
            let error = |x: &Vec<f64>| self.error(&held, fold, &self.whole(active, x));
            Ok(found.iter().map(error).collect::<Vec<f64>>())
        };
        let by_fold = folds.par_iter().map(of_fold).collect::<Result<Vec<_>, IdentifyError>>()?;
        let of = |k: usize| by_fold.iter().map(|errors| errors[k]).collect();
        Ok(Some((0..strengths.len()).map(of).collect()))
    }

    /// Part of all rows that a fold has.
    pub(super) fn share_of(&self, fold: usize) -> f64 {
        self.sums.rows_of(fold) as f64 / self.sums.rows() as f64
    }

    /// The Gram matrix of a fold, the equations of the others, and their part of all rows.
    pub(super) fn without(&self, fold: usize) -> (Mat<f64>, Equations, f64) {
        let sums = self.sums;
        let held = sums.gram_of(fold);
        let share = 1.0 - self.share_of(fold);
        let (gram, bias) = (&self.gram - &held, faer::Scale(share) * &self.bias);
        let rest = Equations::new(&gram, &bias, self.at);
        (held, rest, share)
    }

    /// RMS of the residual of a fold in units of the noise.
    pub(super) fn error(&self, held: &Mat<f64>, fold: usize, x: &[f64]) -> f64 {
        let equations = self.sums.rows_of(fold) as f64 * self.at.n_joints() as f64;
        (self.squares(held, x) / equations.max(1.0)).sqrt()
    }
}
