//! Terms that explain more than noise: forward, then backward, by t² (E5).

use crate::elimination::Equations;
use crate::normal_equations::require;
use crate::{KeptColumns, NormalEquations, Result};

/// Judges a term by what it explains against the noise.
///
/// A term stays if t² ≥ ln m + 2γ ln p: the extended Bayesian information criterion, with γ = 0 the
/// usual one. Terms enter one by one by what they explain, then the weakest leave one by one.
///
/// Leaving alone, from a fit of all candidates, would be no better: where a short log cannot tell
/// them apart, it leaves a thousand terms that cancel each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Criterion {
    /// γ, zero or more: how much harder it is to be one of many candidates.
    pub gamma: f64,
}

/// At most this many terms enter.
const MOST: usize = 400;

impl Default for Criterion {
    fn default() -> Self {
        Self { gamma: 1.0 }
    }
}

impl Criterion {
    /// The least t² that keeps a term of p candidates in m rows.
    pub fn threshold(&self, rows: f64, n_columns: usize) -> f64 {
        rows.max(1.0).ln() + 2.0 * self.gamma * (n_columns.max(1) as f64).ln()
    }

    /// Selects, and refits what is kept by least squares.
    ///
    /// # Errors
    /// [`SparseError`](crate::SparseError) if a setting is out of range.
    pub fn select(&self, problem: &NormalEquations) -> Result<KeptColumns> {
        require("gamma", self.gamma, self.gamma >= 0.0, "zero or more")?;
        let (inner, scale) = &problem.standardised();
        let usable: Vec<usize> = (0..problem.n_columns()).filter(|&j| scale[j] > 0.0).collect();
        let threshold = self.threshold(problem.rows, usable.len());

        let entered = forward(inner, &usable, threshold);
        // The noise is that of the full fit, lest dropping terms makes others look weak.
        let left = inner.refit(&entered)?.residual_energy.max(inner.resolution());
        let noise = left / (inner.rows - entered.len() as f64).max(1.0);
        let NormalEquations { gram: information, cross, .. } = inner.restricted(&entered);
        let spread = faer::Scale(noise) * &information;
        let (right, floor) = (cross.col_as_slice(0).to_vec(), vec![0.0; entered.len()]);
        let equations = Equations { information, right, spread, floor };
        let all: Vec<usize> = (0..entered.len()).collect();
        let kept = equations.eliminate(&all, threshold).map_or_else(Vec::new, |kept| kept.active);
        problem.refit(&kept.into_iter().map(|place| entered[place]).collect::<Vec<_>>())
    }
}

/// A column whose part unexplained by the others is below this share of it adds nothing but noise.
const DEPENDENT: f64 = 1e-9;

/// Orthogonal forward selection: at each turn the column that explains most of what is left enters,
/// while it explains more than the threshold asks of the noise left.
fn forward(problem: &NormalEquations, usable: &[usize], threshold: f64) -> Vec<usize> {
    let NormalEquations { gram, rows, .. } = problem;
    let mut entered: Vec<usize> = Vec::new();
    let mut factors: Vec<Vec<f64>> = Vec::new();
    let mut own: Vec<f64> = usable.iter().map(|&j| gram[(j, j)]).collect();
    let mut cross: Vec<f64> = usable.iter().map(|&j| problem.right()[j]).collect();
    let mut left = problem.energy[0];
    while entered.len() < MOST.min(usable.len()) {
        let gain = |place: usize| {
            if own[place] > DEPENDENT * rows { cross[place].powi(2) / own[place] } else { 0.0 }
        };
        let (best, gain) = (0..usable.len())
            .map(|place| (place, gain(place)))
            .fold((0, 0.0), |best, next| if next.1 > best.1 { next } else { best });
        let freedom = (rows - entered.len() as f64).max(1.0);
        let noise = (left - gain).max(problem.resolution()) / freedom;
        if gain <= threshold * noise || left <= problem.resolution() {
            break;
        }
        // The next column of the Cholesky factor: what each column shares with the one that enters,
        // beyond what those before explain.
        let mut factor: Vec<f64> = usable.iter().map(|&j| gram[(j, usable[best])]).collect();
        for before in &factors {
            let weight = before[best];
            factor.iter_mut().zip(before).for_each(|(value, l)| *value -= weight * l);
        }
        let pivot = own[best].sqrt();
        let scaled = cross[best] / pivot;
        for (place, l) in factor.iter_mut().enumerate() {
            *l /= pivot;
            own[place] -= *l * *l;
            cross[place] -= *l * scaled;
        }
        own[best] = 0.0;
        left -= gain;
        factors.push(factor);
        entered.push(usable[best]);
    }
    entered.sort_unstable();
    entered
}
