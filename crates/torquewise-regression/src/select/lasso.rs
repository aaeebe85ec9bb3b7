//! LASSO: a path of penalties, the best support, its least squares.

use crate::error::SparseError;
use crate::problem::{Problem, Refit, Selection, Standardised, nonzero, require};
use crate::select::descent::Descent;
use std::collections::HashSet;

/// Which point of the path is taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Choice {
    /// The end of a path that leads to this penalty λ > 0.
    Lambda(f64),
    /// The support whose least-squares refit has the lowest Bayesian information criterion.
    Bic,
}

/// Least absolute shrinkage: min ½/m‖y − X c‖² + λ Σ sⱼ|cⱼ|.
///
/// Source: paper, eq. 5, with the squared norm. sⱼ is the root mean square of column j, so that λ
/// has the unit of the response, or 1 without standardisation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lasso {
    /// Number of penalties on the path, one or more.
    pub path: usize,
    /// Last penalty of the path over its first, in (0, 1); [`Choice::Lambda`] sets it itself.
    pub ratio: f64,
    /// Duality gap at which a point is done, as a part of ‖y‖²/m; above 0. Below 1e-13 rounding
    /// is all there is, and the sweeps run out.
    pub gap_tolerance: f64,
    /// Bound on the sweeps at each penalty. A point that needs more keeps its larger gap.
    pub max_sweeps: usize,
    /// Which point of the path is taken.
    pub choice: Choice,
    /// LASSO weights |cⱼ| not above this do not count as active; zero or more, the paper has 0.1.
    pub threshold: f64,
    /// Penalise what a term contributes, not its weight, so that units play no part.
    pub standardise: bool,
    /// Refit the active columns by least squares, which takes the shrinkage off.
    pub debias: bool,
}

impl Default for Lasso {
    /// 100 penalties down to 1e-4 of the first, standardised columns, BIC, no threshold, debiased.
    fn default() -> Self {
        Self {
            path: 100,
            ratio: 1e-4,
            gap_tolerance: 1e-9,
            max_sweeps: 2000,
            choice: Choice::Bic,
            threshold: 0.0,
            standardise: true,
            debias: true,
        }
    }
}

/// The LASSO at one penalty.
#[derive(Clone, Debug, PartialEq)]
pub struct PathPoint {
    /// Penalty λ.
    pub lambda: f64,
    /// Weight of every column of the problem as it was given, p.
    pub coefficients: Vec<f64>,
    /// Duality gap: the objective is at most this far above its minimum. Proven for a
    /// semidefinite Gram matrix, an indication for one that a noise correction made indefinite.
    pub gap: f64,
    /// Sweeps over the weights it took to get here from the point before.
    pub sweeps: usize,
}

/// LASSO solutions for falling penalties, each started from the one before.
///
/// The first penalty is the smallest with no active column. The path ends early where ‖y − X c‖²
/// of an indefinite Gram matrix falls below zero; what lies beyond has no meaning.
///
/// Checked against: `tests/lasso.rs`, the optimality conditions on the rows themselves.
///
/// # Errors
/// [`SparseError::Setting`] if a setting is out of its range.
pub fn lasso_path(problem: &Problem, lasso: &Lasso) -> Result<Vec<PathPoint>, SparseError> {
    lasso.check()?;
    let standardised = lasso.standardised(problem);
    let inner = &standardised.problem;
    let steepest = inner.cross().iter().fold(0.0_f64, |most, b| most.max(b.abs()));
    let penalties = lasso.penalties(steepest / inner.rows());
    let tolerance = lasso.gap_tolerance * inner.energy() / inner.rows();

    let mut descent = Descent::new(inner);
    let mut points = Vec::with_capacity(penalties.len());
    for lambda in penalties {
        let reached = descent.run(lambda, tolerance, lasso.max_sweeps);
        if reached.indefinite {
            break;
        }
        points.push(PathPoint {
            lambda,
            coefficients: standardised.unscaled(&descent.weights),
            gap: reached.gap,
            sweeps: reached.sweeps,
        });
    }
    Ok(points)
}

impl Lasso {
    /// Active columns of the chosen point of the path, with their weights.
    ///
    /// # Errors
    /// [`SparseError::Setting`] if a setting is out of its range, [`SparseError::Indefinite`] if
    /// the path ends before it reaches the wanted penalty.
    pub fn select(&self, problem: &Problem) -> Result<Selection, SparseError> {
        let path = lasso_path(problem, self)?;
        let (chosen, lambda) = match self.choice {
            Choice::Lambda(end) => (path.last().filter(|point| point.lambda <= end), end),
            Choice::Bic => (self.lowest_bic(problem, &path)?, 0.0),
        };
        let point = chosen.ok_or(SparseError::Indefinite { lambda })?;

        let active = self.support(point);
        if self.debias {
            return Ok(problem.refit(&active)?.into_selection(Some(point.gap)));
        }
        let mut coefficients = vec![0.0; problem.n_columns()];
        for &j in &active {
            coefficients[j] = point.coefficients[j];
        }
        let dependent = Vec::new();
        Ok(Selection { coefficients, active, dependent, certificate: Some(point.gap) })
    }

    /// The point whose support, refitted, has the lowest BIC.
    fn lowest_bic<'a>(
        &self,
        problem: &Problem,
        path: &'a [PathPoint],
    ) -> Result<Option<&'a PathPoint>, SparseError> {
        let mut seen = HashSet::new();
        let mut candidates: Vec<(Vec<usize>, &PathPoint)> = path
            .iter()
            .map(|point| (self.support(point), point))
            .filter(|(support, _)| seen.insert(support.clone()))
            .collect();
        candidates.sort_by_key(|(support, _)| support.len());

        // No support explains more than all of them together, so once the terms alone cost too
        // much, no larger support can win. (Their dependent columns count as terms here.)
        let mut union: Vec<usize> = candidates.iter().flat_map(|(s, _)| s.clone()).collect();
        union.sort_unstable();
        union.dedup();
        let least = problem.refit(&union)?.residual_energy;

        let mut best: Option<(f64, &PathPoint)> = None;
        for (support, point) in candidates {
            let bound = problem.bic(least, support.len());
            if best.is_some_and(|(lowest, _)| bound >= lowest) {
                break;
            }
            let Refit { active, residual_energy, .. } = problem.refit(&support)?;
            let bic = problem.bic(residual_energy, active.len());
            if best.is_none_or(|(lowest, _)| bic < lowest) {
                best = Some((bic, point));
            }
        }
        Ok(best.map(|(_, point)| point))
    }

    /// Columns whose weight at this point counts as active.
    fn support(&self, point: &PathPoint) -> Vec<usize> {
        let mut active = nonzero(&point.coefficients, point.coefficients.len());
        active.retain(|&j| point.coefficients[j].abs() > self.threshold);
        active
    }

    /// The problem in the columns that are penalised alike.
    fn standardised(&self, problem: &Problem) -> Standardised {
        if self.standardise {
            return problem.standardised();
        }
        let usable = |j| f64::from(problem.column_scale(j) > 0.0);
        problem.scaled_by((0..problem.n_columns()).map(usable).collect())
    }

    /// Penalties in equal ratios, from the one above which nothing is active.
    fn penalties(&self, first: f64) -> Vec<f64> {
        let last = match self.choice {
            Choice::Lambda(lambda) => lambda,
            Choice::Bic => first * self.ratio,
        };
        if first <= last || self.path == 1 {
            return vec![if matches!(self.choice, Choice::Bic) { first } else { last }];
        }
        let steps = (self.path - 1) as f64;
        let part = |step: usize| (last / first).powf(step as f64 / steps);
        (0..self.path).map(|k| if k + 1 == self.path { last } else { first * part(k) }).collect()
    }

    fn check(&self) -> Result<(), SparseError> {
        let ratio_fits = self.ratio > 0.0 && self.ratio < 1.0;
        require("path", self.path as f64, self.path > 0, "one or more")?;
        require("ratio", self.ratio, ratio_fits, "between 0 and 1")?;
        require("gap_tolerance", self.gap_tolerance, self.gap_tolerance > 0.0, "above zero")?;
        require("threshold", self.threshold, self.threshold >= 0.0, "zero or more")?;
        if let Choice::Lambda(lambda) = self.choice {
            require("lambda", lambda, lambda > 0.0, "above zero")?;
        }
        Ok(())
    }
}
