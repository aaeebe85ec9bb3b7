//! From scenario to first fit: patterns, noise, settled choices and an estimate to rest on \[E17\].

use crate::error::{ExperimentError, within};
use crate::method::Method;
use crate::scenario::Scenario;
use crate::study::cost::samples_of;
use std::collections::BTreeSet;
use torquewise_identify::{LibraryKind, Plan, reconstruct};
use torquewise_model::model::Choice;
use torquewise_model::{Form, Model, Weighted};
use torquewise_motion::{Motion, Pattern};
use torquewise_regression::samples::Samples;
use torquewise_regression::select::criterion::Criterion;
use torquewise_stepwise::NoiseFloor;
use torquewise_stepwise::candidates::{Candidates, Group, Terms};
use torquewise_stepwise::step_equations::{Step, plan_steps};

/// A log with its stepwise reconstruction, ready to be regressed again with other weights.
pub(super) struct FirstFit {
    /// The log, m rows.
    pub(super) log: Motion,
    /// Its rows in the words of a regression.
    pub(super) samples: Samples,
    /// The library, at the interaction order that was settled on held-out rows.
    pub(super) candidates: Candidates,
    /// Coefficients that are found together.
    pub(super) groups: Vec<Group>,
    /// One step per pattern.
    pub(super) steps: Vec<Step>,
    /// Pattern of each row, m.
    pub(super) labels: Vec<Pattern>,
    /// Which terms stay, at the strictness that was settled on held-out rows.
    pub(super) criterion: Criterion,
    /// Standard deviation of the noise in q, q̇, q̈.
    pub(super) noise: NoiseFloor,
    /// What was found.
    pub(super) model: Model,
}

impl FirstFit {
    /// Records a log and reconstructs it.
    pub(super) fn new(scenario: &Scenario, method: Method) -> Result<Self, ExperimentError> {
        let named = || within(format!("indicators, noise {}", scenario.noise.name()));
        let log = scenario.record(&scenario.simulate()?)?;
        let options = method.plan().options;
        let plan = Plan::from(method.plan());
        let found = reconstruct(&log, &plan, &mut |_| {}).map_err(named())?;
        let (n, choices) = (log.n_joints(), &found.model.choices);
        let library = settled_library(options.library, choices);
        let candidates = Candidates::new(n, library, options.regression).map_err(named())?;
        Ok(Self {
            samples: samples_of(&log)?,
            groups: candidates.groups(),
            steps: plan_steps(&candidates, &found.patterns.present).0,
            labels: found.patterns.label(&log),
            criterion: settled_criterion(choices),
            noise: found.noise,
            model: found.model,
            candidates,
            log,
        })
    }

    /// Number of rows m.
    pub(super) fn n_rows(&self) -> usize {
        self.log.n_rows()
    }

    /// Number of joints n.
    pub(super) fn n_joints(&self) -> usize {
        self.log.n_joints()
    }

    /// Rows of the pattern of a step; all of them for a step without one.
    pub(super) fn rows_of(&self, step: &Step) -> Vec<usize> {
        let shows = |row: &usize| step.pattern.is_none_or(|pattern| self.labels[*row] == pattern);
        (0..self.n_rows()).filter(shows).collect()
    }

    /// The model with those of its terms that a step has found or offers.
    pub(super) fn model_of(&self, step: &Step) -> Model {
        let form = match (&self.model.form, &self.candidates.terms) {
            (Form::Torque(joints), Terms::Torque(terms)) => {
                let kept = joints.iter().map(|joint| limited(joint, terms, &step.columns));
                Form::Torque(kept.collect())
            }
            (Form::Energy(found), Terms::Energy(terms)) => {
                Form::Energy(limited(found, terms, &step.columns))
            }
            (form, _) => form.clone(),
        };
        Model { form, ..self.model.clone() }
    }

    /// Columns of a group that the first fit kept, ascending, of those of a step.
    pub(super) fn kept_columns(&self, group: &Group, step: &Step) -> Vec<usize> {
        fn known<T: Ord>(found: &[Weighted<T>], terms: &[T], columns: &[usize]) -> Vec<usize> {
            let found: BTreeSet<&T> = found.iter().map(|weighted| &weighted.term).collect();
            columns.iter().copied().filter(|&column| found.contains(&terms[column])).collect()
        }
        match (&self.model.form, &self.candidates.terms) {
            (Form::Torque(joints), Terms::Torque(terms)) => {
                let joint = group.equations.first().map_or(0, |&(_, joint)| joint);
                known(&joints[joint], terms, &step.columns)
            }
            (Form::Energy(found), Terms::Energy(terms)) => known(found, terms, &step.columns),
            _ => Vec::new(),
        }
    }

    /// The model that holds other coefficients: (column, coefficient) of each group.
    pub(super) fn model_with(&self, found: &[Vec<(usize, f64)>]) -> Model {
        fn weigh<T: Clone>(group: &[(usize, f64)], terms: &[T]) -> Vec<Weighted<T>> {
            let weighted = |&(column, coefficient): &(usize, f64)| Weighted {
                term: terms[column].clone(),
                coefficient,
                std_error: 0.0,
                inclusion: None,
            };
            group.iter().map(weighted).collect()
        }
        let form = match &self.candidates.terms {
            Terms::Torque(terms) => {
                Form::Torque(found.iter().map(|group| weigh(group, terms)).collect())
            }
            Terms::Energy(terms) => {
                Form::Energy(found.iter().flat_map(|group| weigh(group, terms)).collect())
            }
        };
        Model { form, stages: Vec::new(), ..self.model.clone() }
    }
}

/// The weighted terms that are among some columns of a library.
fn limited<T: Ord + Clone>(
    found: &[Weighted<T>],
    terms: &[T],
    columns: &[usize],
) -> Vec<Weighted<T>> {
    let known: BTreeSet<&T> = columns.iter().map(|&column| &terms[column]).collect();
    found.iter().filter(|weighted| known.contains(&weighted.term)).cloned().collect()
}

/// The number that held-out rows chose.
fn chosen(choices: &[Choice], what: &str) -> Option<f64> {
    choices.iter().find(|choice| choice.what.contains(what))?.chosen.parse().ok()
}

/// A library at the interaction order that was chosen.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a small count")]
fn settled_library(library: LibraryKind, choices: &[Choice]) -> LibraryKind {
    match (library, chosen(choices, "joint angles")) {
        (LibraryKind::Energy { .. }, Some(order)) => {
            LibraryKind::Energy { interaction: Some(order as usize) }
        }
        (library, _) => library,
    }
}

fn settled_criterion(choices: &[Choice]) -> Criterion {
    let usual = Criterion::default();
    Criterion { gamma: chosen(choices, "gamma").unwrap_or(usual.gamma), ..usual }
}
