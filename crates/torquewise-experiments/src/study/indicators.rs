//! From settings to what noise and leverage of rows buy as indicators beside activation \[E17\].

mod first_fit;
pub(crate) mod variance;
mod steps;
mod refit;
mod leverage;
pub(crate) mod clusters;
mod sorting;

pub(crate) use sorting::Sorting;

use crate::error::{ExperimentError, within};
use crate::method::Method;
use crate::scenario::{Decibels, Scenario, outside};
use crate::settings::Settings;
use crate::spread::Spread;
use crate::truth::{true_energies, true_torques};
use first_fit::FirstFit;
use rayon::prelude::*;
use refit::refit;
use serde::Serialize;
use sorting::Indicators;
use std::collections::BTreeSet;
use steps::take_steps;
use torquewise_identify::score;
use torquewise_model::{EnergyTerm, Form, Model, Term, Weighted};
use torquewise_motion::Motion;
use torquewise_sim::Arm;

/// Length of the logs at most \[s\]: short ones, in which the choice of rows matters most.
const MOST_SECONDS: f64 = 100.0;
/// Every second level of the noise sweep.
const LEVELS: usize = 2;

/// What noise and leverage of rows buy.
#[derive(Clone, Debug, Serialize)]
pub struct IndicatorResults {
    /// Length of the logs \[s\].
    pub log_length: f64,
    /// One per library, level of noise, sorting and noise correction.
    pub rows: Vec<IndicatorRow>,
    /// How unequal the rows are, one per library, level of noise and step.
    pub gains: Vec<PossibleGain>,
    /// Regressions of a step and a joint, over all logs.
    pub regressions: usize,
    /// Those of them in whose rows the elbow sees more than one cluster of (noise, leverage).
    pub clustered: usize,
}

/// One way to sort the rows, over all seeds.
#[derive(Clone, Debug, Serialize)]
pub struct IndicatorRow {
    /// Which library.
    pub method: Method,
    pub noise: Decibels,
    /// How rows are sorted and weighted.
    pub sorting: Sorting,
    /// Whether the bias of the noise is taken out \[E7\].
    pub noise_correction: bool,
    /// Runs, each with another motion and other noise.
    pub runs: usize,
    pub true_terms: usize,
    /// True terms found.
    pub right: Spread,
    /// Other terms found.
    pub other: Spread,
    /// Error outside the training log \[%\], per joint.
    pub nrmse_percent: Vec<Spread>,
    /// Error of the worst joint over that by activation alone, of the same log.
    pub ratio: Spread,
    /// Runs in which the worst joint is better than by activation alone.
    pub better: usize,
}

/// How unequal the noise of the rows of a step is.
#[derive(Clone, Debug, Serialize)]
pub struct PossibleGain {
    /// Which library.
    pub method: Method,
    pub noise: Decibels,
    /// Name of the step; all rows under the whole model last.
    pub step: &'static str,
    /// mean(v) mean(1/v), the largest of the joints.
    pub gain: Spread,
}

/// One model judged.
#[derive(Clone, Debug)]
struct Judged {
    sorting: Sorting,
    noise_correction: bool,
    right: usize,
    other: usize,
    nrmse_percent: Vec<f64>,
}

/// All of one log.
#[derive(Clone, Debug)]
struct Run {
    judged: Vec<Judged>,
    gains: Vec<(&'static str, f64)>,
    elbows: Vec<usize>,
}

/// The terms of the true arm, as both libraries have them.
struct Truth {
    energies: BTreeSet<EnergyTerm>,
    products: Vec<BTreeSet<Term>>,
}

/// Does every sorting on every log.
pub(crate) fn study_indicators(settings: &Settings) -> Result<IndicatorResults, ExperimentError> {
    let seconds = settings.seconds.min(MOST_SECONDS);
    let truth = Truth::of(&Arm::builtin(settings.arm)?);
    let test = outside(settings.arm, settings.seed)?;
    let mut plans = Vec::new();
    for method in [Method::Energy, Method::Product] {
        for &noise in settings.noise_levels.iter().step_by(LEVELS) {
            plans.extend(
                settings
                    .seeds()
                    .map(|seed| (method, Scenario { arm: settings.arm, seconds, noise, seed })),
            );
        }
    }
    let runs: Vec<Run> = plans
        .par_iter()
        .map(|(method, scenario)| run(*method, scenario, &truth, &test))
        .collect::<Result<_, _>>()?;
    let elbows: Vec<usize> = runs.iter().flat_map(|run| run.elbows.iter().copied()).collect();
    let mut results = IndicatorResults {
        log_length: seconds,
        rows: Vec::new(),
        gains: Vec::new(),
        regressions: elbows.len(),
        clustered: elbows.iter().filter(|&&clusters| clusters > 1).count(),
    };
    let seeds = settings.seeds().count().max(1);
    for (plans, runs) in plans.chunks(seeds).zip(runs.chunks(seeds)) {
        let Some((method, scenario)) = plans.first() else { continue };
        let level = (*method, scenario.noise);
        results.rows.extend(rows(level, truth.count(*method), runs));
        results.gains.extend(gains(level, runs));
    }
    Ok(results)
}

/// Sorts the rows of one log in every way and judges what is found.
fn run(
    method: Method,
    scenario: &Scenario,
    truth: &Truth,
    test: &Motion,
) -> Result<Run, ExperimentError> {
    let first = FirstFit::new(scenario, method)?;
    let indicators = Indicators::new(&first)?;
    let mut judged = Vec::new();
    for sorting in Sorting::ALL {
        let sorted = indicators.sort(sorting)?;
        let selected = take_steps(&first, &sorted.steps)?;
        let fits = refit(&first, &selected, &sorted.refit)?;
        for (noise_correction, found) in [true, false].into_iter().zip(fits) {
            let model = first.model_with(&found);
            let (right, other) = truth.judge(&model);
            let scores = score(&model, test).map_err(within("indicators"))?;
            let nrmse_percent = scores.joints.iter().map(|joint| joint.nrmse_percent).collect();
            judged.push(Judged { sorting, noise_correction, right, other, nrmse_percent });
        }
    }
    Ok(Run { judged, gains: indicators.gains(), elbows: indicators.elbows() })
}

fn worst(nrmse_percent: &[f64]) -> f64 {
    nrmse_percent.iter().copied().fold(0.0, f64::max)
}

fn rows((method, noise): (Method, Decibels), true_terms: usize, runs: &[Run]) -> Vec<IndicatorRow> {
    let kinds = runs.first().map_or(&[][..], |run| &run.judged);
    kinds
        .iter()
        .enumerate()
        .map(|(place, kind)| {
            let own: Vec<&Judged> = runs.iter().map(|run| &run.judged[place]).collect();
            let ratios: Vec<f64> = runs
                .iter()
                .zip(&own)
                .filter_map(|(run, own)| {
                    let usual = run.judged.iter().find(|other| {
                        other.sorting == Sorting::Activation
                            && other.noise_correction == own.noise_correction
                    })?;
                    Some(worst(&own.nrmse_percent) / worst(&usual.nrmse_percent))
                })
                .collect();
            IndicatorRow {
                method,
                noise,
                sorting: kind.sorting,
                noise_correction: kind.noise_correction,
                runs: own.len(),
                true_terms,
                right: Spread::of(own.iter().map(|judged| judged.right as f64)),
                other: Spread::of(own.iter().map(|judged| judged.other as f64)),
                nrmse_percent: Spread::of_columns(own.iter().map(|j| j.nrmse_percent.as_slice())),
                better: ratios.iter().filter(|ratio| **ratio < 1.0).count(),
                ratio: Spread::of(ratios),
            }
        })
        .collect()
}

fn gains((method, noise): (Method, Decibels), runs: &[Run]) -> Vec<PossibleGain> {
    let names = runs.first().map_or(&[][..], |run| &run.gains);
    names
        .iter()
        .map(|&(step, _)| {
            let of =
                |run: &Run| run.gains.iter().find(|(name, _)| *name == step).map(|gain| gain.1);
            PossibleGain { method, noise, step, gain: Spread::of(runs.iter().filter_map(of)) }
        })
        .collect()
}

impl Truth {
    fn of(arm: &Arm) -> Self {
        let energies = true_energies(arm);
        let torques = true_torques(&energies, arm.n_joints());
        let products = torques.into_iter().map(|sum| sum.into_iter().map(|(_, t)| t).collect());
        Self { products: products.collect(), energies: energies.into_keys().collect() }
    }

    fn count(&self, method: Method) -> usize {
        match method {
            Method::Energy => self.energies.len(),
            _ => self.products.iter().map(BTreeSet::len).sum(),
        }
    }

    /// True terms and other terms among those of a model.
    fn judge(&self, model: &Model) -> (usize, usize) {
        let (right, all) = match &model.form {
            Form::Energy(terms) => {
                let right = terms.iter().filter(|w| self.energies.contains(&w.term)).count();
                (right, terms.len())
            }
            Form::Torque(joints) => {
                let right = |(terms, truth): (&Vec<Weighted<Term>>, &BTreeSet<Term>)| {
                    terms.iter().filter(|w| truth.contains(&w.term)).count()
                };
                let all = joints.iter().map(Vec::len).sum();
                (joints.iter().zip(&self.products).map(right).sum(), all)
            }
        };
        (right, all - right)
    }
}

#[cfg(test)]
mod tests;
