//! Candidates, fitted terms → the form of a model, and the terms that nearly made it.

use crate::candidates::{Candidates, Terms};
use crate::refit::{FittedTerm, Refitted};
use torquewise_model::{Form, Weighted};

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
            Form::Torque(found.iter().map(|group| weigh(group, terms)).collect())
        }
        Terms::Energy(terms) => {
            Form::Energy(found.iter().flat_map(|group| weigh(group, terms)).collect())
        }
    }
}

fn weigh<T: Clone>(group: &[FittedTerm], terms: &[T]) -> Vec<Weighted<T>> {
    let weighted = |fitted: &FittedTerm| Weighted {
        term: terms[fitted.column].clone(),
        coefficient: fitted.coefficient,
        std_error: fitted.std_error,
        inclusion: fitted.inclusion,
    };
    group.iter().map(weighted).collect()
}

/// The terms that nearly made it, the likeliest first.
pub(crate) fn dropped(candidates: &Candidates, refitted: &[Refitted]) -> Vec<Dropped> {
    let mut dropped: Vec<Dropped> = refitted
        .iter()
        .flat_map(|group| &group.dropped)
        .map(|&(column, inclusion)| Dropped { name: candidates.terms.name(column), inclusion })
        .collect();
    dropped.sort_by(|a, b| b.inclusion.total_cmp(&a.inclusion));
    dropped
}
