//! Coefficients, standard errors and inclusion of the kept terms, all fitted together (E6) (E7).

use crate::active_set::ActiveSet;
use crate::rows::cut;
use crate::step::{of_joint, unexplained, weighted_problem};
use crate::{
    Candidates, IdentifyError, LibraryOptions, NoiseFloor, Survey, clear_of_reversals, samples_of,
};
use faer::Mat;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use torquewise_model::Weighted;
use torquewise_motion::{Recording, stats};
use torquewise_regression::elimination::{Equations, Estimate};
use torquewise_regression::{KeptColumns, NormalEquations, Selector, SparseError};

/// A term of a fit, by its column of the library.
pub(crate) type FittedTerm = Weighted<usize>;

pub(crate) struct Refitted {
    pub(crate) terms: Vec<FittedTerm>,
    /// (column, inclusion) of terms that did not stay, where resampled logs were asked.
    pub(crate) dropped: Vec<(usize, f64)>,
    pub(crate) dependent: Vec<usize>,
    /// RMS of the residual of each equation \[N·m\].
    pub(crate) residual_rms: Vec<f64>,
}

pub(crate) struct RefitPlan<'a> {
    pub(crate) survey: &'a Survey,
    pub(crate) options: &'a LibraryOptions,
    /// What is taken out of the normal equations.
    pub(crate) noise: &'a NoiseFloor,
    pub(crate) seed: u64,
}

impl RefitPlan<'_> {
    /// Rows that a row of the sample stands for.
    fn scale(&self) -> f64 {
        self.survey.rows as f64 / self.survey.sample.n_rows().max(1) as f64
    }
}

/// A coefficient whose column adds less than this part of the torque is rounding.
const PRECISION: f64 = 1e-11;
/// Memory of the sums of all parts of a log at most, unless a single one takes more.
const SUM_BYTES: usize = 256 << 20;
/// Parts of a log that are drawn anew.
const PARTS: usize = 32;
/// Fewer parts with rows are too few to draw from.
const LEAST_PARTS: usize = 8;
/// Above this many kept terms, only those of the final model are asked of resampled logs.
const MOST_BAGGED: usize = 150;

/// Where least squares leaves less than this part of the torque, squared, normal equations cannot
/// say how much less: they keep about 13 digits.
const EXPLAINED: f64 = 1e-10;
/// Steps of iterative refinement: each leaves about ε times the condition of the Gram matrix of what
/// was wrong.
const REFINEMENTS: usize = 2;
/// Times that noise is drawn for each row of a sample at most.
const MOST_DRAWS: f64 = 16.0;

/// Fits the kept terms of all groups: coefficients from the normal equations of all rows, what the
/// noise did to them and how far they scatter from an even sample of rows.
///
/// Where the normal equations leave nothing to be explained, the sample says it all, and steps of
/// iterative refinement say it to full precision.
///
/// - `whole`: normal equations of all rows in the kept columns of each group
pub(crate) fn refit(
    candidates: &Candidates,
    kept: &[ActiveSet<'_>],
    whole: &[Vec<NormalEquations>],
    plan: &RefitPlan<'_>,
) -> Result<Vec<Refitted>, IdentifyError> {
    let RefitPlan { survey, options, noise, seed } = plan;
    // Fewer where a very long model would make the sums large: half of each of three matrices in
    // exact numbers, and all of it in plain ones.
    let bytes: usize = kept.iter().map(|kept| 36 * (kept.columns.len() + 1).pow(2)).sum();
    let n_parts = (SUM_BYTES / bytes.max(1)).clamp(1, PARTS);
    let least_t_squared = match options.selector {
        Selector::Criterion(own) => own.threshold(survey.rows as f64, candidates.n_columns()),
        _ => 0.0,
    };
    // The sample in pieces, of which part k of the log has every `n_parts`-th from the k-th on.
    let (mut pieces, laws) = (Vec::new(), &candidates.friction);
    let read = survey.sample.read(&mut |_, block| {
        let samples = samples_of(&clear_of_reversals(block, laws), laws)?;
        pieces.extend(cut(samples, survey.sample.n_rows() / (2 * n_parts)));
        Ok(())
    });
    read.map_err(IdentifyError::Read)?;
    let draws = stats::whole(plan.scale().ceil().clamp(1.0, MOST_DRAWS));
    (kept.iter().zip(whole))
        .map(|(kept, grams)| {
            let sums_at = |start: &[f64], draws: usize| {
                let of_part = |part: usize| {
                    let own = pieces.iter().skip(part).step_by(n_parts);
                    let sums =
                        kept.normal_sums(start, (*noise, draws), (*seed, part as u64), own)?;
                    Ok(Part {
                        gram: sums.gram(),
                        bias: sums.bias(),
                        spread: sums.scores(),
                        rows: sums.rows() as f64,
                        left: sums.residual_rms().into_iter().map(|rms| rms * rms).collect(),
                    })
                };
                (0..n_parts).into_par_iter().map(of_part).collect::<Result<Vec<_>, SparseError>>()
            };
            let mut fit = GroupRefit::new(kept, grams, least_t_squared, plan)?;
            for _ in 0..if fit.is_explained { REFINEMENTS } else { 0 } {
                fit.parts = sums_at(&fit.coefficients, 0)?;
                fit.refine()?;
            }
            fit.parts = sums_at(&fit.coefficients, draws)?;
            fit.finish()
        })
        .collect()
}

/// Sums of a part of the sample, linearised at the first fit: in \[Y e\].
struct Part {
    gram: Mat<f64>,
    /// What noise adds to it.
    bias: Mat<f64>,
    spread: Mat<f64>,
    rows: f64,
    /// Mean squared residual of each equation.
    left: Vec<f64>,
}

struct GroupRefit<'a> {
    kept: &'a ActiveSet<'a>,
    /// Normal equations of all rows, of each equation.
    grams: &'a [NormalEquations],
    /// \[Y τ\]ᵀ\[Y τ\] of all rows, its equations weighted and added up, (p+1)×(p+1).
    gram: Mat<f64>,
    rows: f64,
    /// Where the refit begins: plain least squares, p.
    coefficients: Vec<f64>,
    /// Columns that depend on others, ascending.
    dependent: Vec<usize>,
    /// Whether the torque is explained but for rounding.
    is_explained: bool,
    parts: Vec<Part>,
    /// Terms of less t² leave.
    least_t_squared: f64,
    plan: &'a RefitPlan<'a>,
}

impl<'a> GroupRefit<'a> {
    fn new(
        kept: &'a ActiveSet<'a>,
        grams: &'a [NormalEquations],
        least_t_squared: f64,
        plan: &'a RefitPlan<'a>,
    ) -> Result<Self, SparseError> {
        let all: Vec<usize> = (0..kept.columns.len()).collect();
        let (joints, none) = (&kept.joints, vec![0.0; all.len()]);
        let equations = weighted_problem(grams, joints, &kept.weights, &none, &all)?;
        let KeptColumns { coefficients, dependent, .. } = equations.refit(&all)?;
        let is_explained = joints.iter().all(|&joint| {
            let (gram, response) = of_joint(grams, joint);
            unexplained(grams, joint, &coefficients) <= EXPLAINED * gram.energy[response]
        });
        Ok(Self {
            kept,
            grams,
            gram: equations.joined(),
            rows: equations.rows,
            coefficients,
            dependent,
            is_explained,
            parts: Vec::new(),
            least_t_squared,
            plan,
        })
    }

    /// A step of iterative refinement: least squares of what the coefficients leave of the sample,
    /// which stands for all rows.
    fn refine(&mut self) -> Result<(), SparseError> {
        let left = faer::Scale(self.plan.scale()) * self.left();
        self.gram = with_response(&left, &self.coefficients);
        let all: Vec<usize> = (0..self.coefficients.len()).collect();
        let change = NormalEquations::of_joined(&left, self.rows)?.refit(&all)?;
        self.dependent = change.dependent;
        let weights = self.coefficients.iter_mut().zip(change.coefficients);
        weights.for_each(|(weight, change)| *weight += change);
        Ok(())
    }

    /// \[Y e\]ᵀ\[Y e\] of all parts.
    fn left(&self) -> Mat<f64> {
        let mut sum = self.parts[0].gram.clone();
        self.parts[1..].iter().for_each(|part| sum += &part.gram);
        sum
    }

    fn finish(self) -> Result<Refitted, IdentifyError> {
        let equations = self.equations(&vec![1.0; self.parts.len()]);
        let mut estimate = self.estimate(&equations, &self.independent(), self.least_t_squared);
        let least_size = self.plan.options.threshold.unwrap_or(0.0);
        let weights = estimate.active.iter().zip(&estimate.coefficients);
        let large = weights.filter(|(_, weight)| weight.abs() > least_size);
        let large: Vec<usize> = large.map(|(&column, _)| column).collect();
        if large.len() < estimate.active.len() {
            estimate = self.estimate(&equations, &large, 0.0);
        }
        let (active, columns) = (&estimate.active, &self.kept.columns);
        let inclusion = self.inclusion(active);
        let exact = self.sharpen(&estimate)?;
        let term = |(place, &j): (usize, &usize)| Weighted {
            term: columns[j],
            coefficient: exact[place],
            std_error: estimate.std_errors[place],
            inclusion: inclusion.as_ref().map(|shares| shares[j]),
        };
        let terms = active.iter().enumerate().map(term).collect();
        let shares = inclusion.iter().flatten().enumerate();
        let dropped = shares.filter(|(j, share)| **share > 0.0 && !active.contains(j));
        let dropped = dropped.map(|(j, &share)| (columns[j], share)).collect();
        let dependent = self.dependent.iter().map(|&j| columns[j]).collect();
        let residual_rms = self.residual_rms(active, &exact);
        Ok(Refitted { terms, dropped, dependent, residual_rms })
    }

    /// Estimating equations of all rows as they would be if the parts of the sample counted as often
    /// as `weights` says.
    ///
    /// What a part more or less changes in sums over m rows is what it changes in sums over the
    /// sample times the square root of how many rows each sampled one stands for.
    fn equations(&self, weights: &[f64]) -> Equations {
        let p = self.coefficients.len();
        let start = &self.coefficients;
        let (mut more, mut bias) = (Mat::<f64>::zeros(p + 1, p + 1), Mat::zeros(p + 1, p + 1));
        let (mut spread, mut sum, mut rows) = (Mat::<f64>::zeros(p, p), vec![0.0; p], 0.0);
        for (part, &weight) in self.parts.iter().zip(weights) {
            let change = self.plan.scale().sqrt() * (weight - 1.0);
            if change != 0.0 {
                more += faer::Scale(change) * &part.gram;
            }
            bias += faer::Scale(self.plan.scale() + change) * &part.bias;
            if weight > 0.0 {
                spread += faer::Scale(weight) * &part.spread;
                sum.iter_mut().enumerate().for_each(|(j, sum)| *sum += weight * part.gram[(p, j)]);
                rows += weight * part.rows;
            }
        }
        let gram = &self.gram + with_response(&more, start);
        let bias = with_response(&bias, start);
        let reference = gram[(p, p)].max(f64::MIN_POSITIVE);
        let information = |i, j| gram[(i, j)] - bias[(i, j)];
        let spread = |i, j| self.plan.scale() * (spread[(i, j)] - sum[i] * sum[j] / rows.max(1.0));
        Equations {
            information: Mat::from_fn(p, p, information),
            right: (0..p).map(|j| information(j, p)).collect(),
            spread: Mat::from_fn(p, p, spread),
            floor: (0..p).map(|j| PRECISION * (reference / gram[(j, j)]).sqrt()).collect(),
        }
    }

    fn independent(&self) -> Vec<usize> {
        (0..self.coefficients.len()).filter(|j| !self.dependent.contains(j)).collect()
    }

    /// Eliminates among some columns; where the corrected equations cannot be solved, the plain fit
    /// stands.
    fn estimate(&self, equations: &Equations, columns: &[usize], least: f64) -> Estimate {
        equations.eliminate(columns, least).unwrap_or_else(|| Estimate {
            active: columns.to_vec(),
            coefficients: columns.iter().map(|&j| self.coefficients[j]).collect(),
            std_errors: vec![0.0; columns.len()],
        })
    }

    /// Share of resampled logs in which each kept term stays: as many parts are drawn, with
    /// replacement, as there are, and the elimination is run again.
    fn inclusion(&self, active: &[usize]) -> Option<Vec<f64>> {
        let (p, bags) = (self.coefficients.len(), self.plan.options.bags);
        let filled: Vec<usize> =
            (0..self.parts.len()).filter(|&part| self.parts[part].rows > 0.0).collect();
        if bags == 0 || filled.len() < LEAST_PARTS {
            return None;
        }
        let all = self.independent();
        let columns = if p > MOST_BAGGED { active } else { &all };
        let rounds: Vec<Vec<usize>> = (0..bags)
            .into_par_iter()
            .map(|round| {
                let mut random = ChaCha8Rng::seed_from_u64(self.plan.seed);
                random.set_stream(BAGS + round as u64);
                let mut weights = vec![0.0; self.parts.len()];
                for _ in 0..filled.len() {
                    weights[filled[random.random_range(0..filled.len())]] += 1.0;
                }
                self.estimate(&self.equations(&weights), columns, self.least_t_squared).active
            })
            .collect();
        let mut counts = vec![0_usize; p];
        for j in rounds.into_iter().flatten() {
            counts[j] += 1;
        }
        Some(counts.into_iter().map(|count| count as f64 / bags as f64).collect())
    }

    /// RMS of what the final coefficients leave of each joint \[N·m\].
    fn residual_rms(&self, active: &[usize], coefficients: &[f64]) -> Vec<f64> {
        let mut all = vec![0.0; self.coefficients.len()];
        active.iter().zip(coefficients).for_each(|(&j, c)| all[j] = *c);
        let rows: f64 = self.parts.iter().map(|part| part.rows).sum();
        let of_joint = |(place, &joint): (usize, &usize)| {
            let mean = if self.is_explained {
                // Normal equations keep too few digits to say how little is left: the sample does.
                let squares = self.parts.iter().map(|part| part.rows * part.left[place]);
                squares.sum::<f64>() / rows.max(1.0)
            } else {
                let rows = of_joint(self.grams, joint).0.rows;
                unexplained(self.grams, joint, &all) / rows.max(1.0)
            };
            mean.sqrt()
        };
        self.kept.joints.iter().enumerate().map(of_joint).collect()
    }

    /// The coefficients of an estimate to full precision where all is explained and no noise was
    /// taken out: by a step of iterative refinement on the columns that stay.
    fn sharpen(&self, estimate: &Estimate) -> Result<Vec<f64>, SparseError> {
        if !self.is_explained || !self.plan.noise.is_none() {
            return Ok(estimate.coefficients.clone());
        }
        let (active, start) = (&estimate.active, &self.coefficients);
        let mut gone = start.clone();
        for &j in active {
            gone[j] = 0.0;
        }
        // The weights of columns that left are among what is left to be explained.
        let left = with_response(&self.left(), &gone);
        let equations = NormalEquations::of_joined(&left, 1.0)?.restricted(active);
        let change = equations.refit(&(0..active.len()).collect::<Vec<_>>())?.coefficients;
        Ok(active.iter().zip(change).map(|(&j, change)| start[j] + change).collect())
    }
}

/// Streams of random numbers from here on are for resampling, those before for noise.
const BAGS: u64 = 1 << 32;

/// Sums in \[Y e\], e = τ − Yβ, as they are in \[Y τ\].
fn with_response(sums: &Mat<f64>, coefficients: &[f64]) -> Mat<f64> {
    let p = coefficients.len();
    let mut change = Mat::<f64>::identity(p + 1, p + 1);
    coefficients.iter().enumerate().for_each(|(j, c)| change[(j, p)] = *c);
    change.transpose() * (sums * &change)
}
