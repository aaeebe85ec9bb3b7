//! The form of a model from fitted terms, and near-miss terms.

use crate::candidates::{Candidates, Terms};
use crate::refit::{FittedTerm, Refitted};
use torquewise_model::{Form, FrictionTerm, Weighted};

/// A term that did not stay, though some resampled logs kept it.
#[derive(Clone, Debug, PartialEq)]
pub struct Dropped {
    /// Its name.
    pub name: String,
    /// Share of resampled logs in which it stayed.
    pub inclusion: f64,
}

/// The model form of fitted terms, per group.
pub(crate) fn form(candidates: &Candidates, found: &[Vec<FittedTerm>]) -> Form {
    match &candidates.terms {
        Terms::Torque(terms) => {
            Form::Torque(found.iter().map(|group| weigh(group, |j| terms.get(j))).collect())
        }
        Terms::Energy(terms) => {
            Form::Energy(found.iter().flat_map(|group| weigh(group, |j| terms.get(j))).collect())
        }
    }
}

/// The friction among fitted terms, per group.
pub(crate) fn friction_of(
    candidates: &Candidates,
    found: &[Vec<FittedTerm>],
) -> Vec<Weighted<FrictionTerm>> {
    found.iter().flat_map(|group| weigh(group, |column| candidates.law(column))).collect()
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
    let mut dropped: Vec<Dropped> = refitted
        .iter()
        .flat_map(|group| &group.dropped)
        .map(|&(column, inclusion)| Dropped { name: candidates.name(column), inclusion })
        .collect();
    dropped.sort_by(|a, b| b.inclusion.total_cmp(&a.inclusion));
    dropped
}

/// Names of linearly dependent terms.
pub(crate) fn dependent(candidates: &Candidates, refitted: &[Refitted]) -> Vec<String> {
    let mut columns: Vec<usize> =
        refitted.iter().flat_map(|group| group.dependent.iter().copied()).collect();
    columns.sort_unstable();
    columns.dedup();
    columns.into_iter().map(|column| candidates.name(column)).collect()
}
