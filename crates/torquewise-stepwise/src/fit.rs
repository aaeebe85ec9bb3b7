//! What the steps found in the terms of a library, and how.

use crate::candidates::Terms;
use crate::refit::{FittedTerm, Refitted};
use crate::{Candidates, NoiseFloor, Patterns};
use serde::Serialize;
use torquewise_model::{Form, FrictionTerm, Model, Weighted};
use torquewise_motion::Pattern;

/// What the steps found in the terms of a library, and how.
#[derive(Clone, Debug)]
pub struct LibraryFit {
    /// The equations of motion.
    pub model: Model,
    /// The patterns its rows fall into.
    pub patterns: Patterns,
    /// The white noise in its signals, from standstill where there is one.
    pub noise: NoiseFloor,
    /// Candidates in all.
    pub candidates: usize,
    /// The steps taken.
    pub steps: Vec<StepReport>,
    /// Terms that did not stay though resampled logs kept them, the likeliest first.
    pub dropped: Vec<Dropped>,
    /// Patterns that the log does not show, whose terms were fitted with the rows of the next.
    pub missing: Vec<Pattern>,
    /// Candidates that the motion of the log does not excite.
    pub unassigned: usize,
    /// Names of the terms left out of the last fit because they depend linearly on others in this log.
    pub dependent: Vec<String>,
}

/// One step of the reconstruction.
#[derive(Clone, Debug, Serialize)]
pub struct StepReport {
    /// Name of its pattern.
    pub name: &'static str,
    /// Its rows.
    pub rows: usize,
    /// Candidates offered.
    pub candidates: usize,
    /// Terms found so far that act on each joint, n.
    pub active: Vec<usize>,
}

/// A term that did not stay, though some resampled logs kept it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Dropped {
    /// Its name.
    #[serde(rename = "term")]
    pub name: String,
    /// Share of resampled logs in which it stayed.
    pub inclusion: f64,
}

/// Fitted terms, per group, as a model has them: its form and its friction.
pub(crate) fn model_terms(
    candidates: &Candidates,
    found: &[Vec<FittedTerm>],
) -> (Form, Vec<Weighted<FrictionTerm>>) {
    let form = match &candidates.terms {
        Terms::Torque(terms) => {
            Form::Torque(found.iter().map(|group| weigh(group, |j| terms.get(j))).collect())
        }
        Terms::Energy(terms) => {
            Form::Energy(found.iter().flat_map(|group| weigh(group, |j| terms.get(j))).collect())
        }
    };
    let laws = found.iter().flat_map(|group| weigh(group, |column| candidates.law(column)));
    (form, laws.collect())
}

/// The fitted terms of a group that `term` knows.
fn weigh<'a, T: Clone + 'a>(
    group: &[FittedTerm],
    term: impl Fn(usize) -> Option<&'a T>,
) -> Vec<Weighted<T>> {
    let weighted = |fitted: &FittedTerm| {
        let &Weighted { term: column, coefficient, std_error, inclusion } = fitted;
        let term = term(column)?.clone();
        Some(Weighted { term, coefficient, std_error, inclusion })
    };
    group.iter().filter_map(weighted).collect()
}

/// Near-miss terms, by descending inclusion probability.
pub(crate) fn dropped(candidates: &Candidates, refitted: &[Refitted]) -> Vec<Dropped> {
    let dropped = refitted.iter().flat_map(|group| &group.dropped);
    let named = |&(column, inclusion)| Dropped { name: candidates.name(column), inclusion };
    let mut dropped: Vec<Dropped> = dropped.map(named).collect();
    dropped.sort_by(|a, b| b.inclusion.total_cmp(&a.inclusion));
    dropped
}
