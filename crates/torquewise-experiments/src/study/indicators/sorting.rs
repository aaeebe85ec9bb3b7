//! From first fit to weights of every row in every step, in each of the ways compared \[E17\].

use crate::error::ExperimentError;
use crate::study::indicators::clusters::{Informative, by_noise, informative};
use crate::study::indicators::first_fit::FirstFit;
use crate::study::indicators::leverage::leverage;
use crate::study::indicators::steps::WeightedStep;
use crate::study::indicators::variance::{effective_variance, inverse_weights, possible_gain};
use faer::Mat;
use serde::Serialize;
use torquewise_stepwise::step_equations::Step;

/// How rows are sorted and weighted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Sorting {
    /// By activation alone, all rows of a pattern alike: the method as it is.
    Activation,
    /// By activation, each row weighted by one over its effective variance.
    InverseVariance,
    /// By activation, and within each pattern by clusters of (noise, leverage), of which those with
    /// little information are left out.
    WithinPatterns,
    /// By three clusters of (noise, leverage) in place of the patterns, the quietest first.
    InPlaceOfPatterns,
}

/// The rows of one log, sorted and weighted.
pub(super) struct Sorted {
    /// The steps, in the order of the patterns.
    pub(super) steps: Vec<WeightedStep>,
    /// Weights of the last fit, m×n.
    pub(super) refit: Mat<f64>,
}

/// Indicators of the rows of one log: what can be said before anything is fitted anew.
#[derive(Clone, Debug)]
pub(super) struct Indicators {
    /// Steps and their rows.
    parts: Vec<Part>,
    /// All rows under the whole model.
    whole: Part,
    /// Which rows carry information, per step and joint.
    informative: Vec<Vec<Informative>>,
}

/// The indicators of the rows of one step.
#[derive(Clone, Debug)]
pub(super) struct Part {
    step: Step,
    rows: Vec<usize>,
    variance: Mat<f64>,
    leverage: Mat<f64>,
}

impl Sorting {
    /// All ways, the method as it is first.
    pub const ALL: [Self; 4] =
        [Self::Activation, Self::InverseVariance, Self::WithinPatterns, Self::InPlaceOfPatterns];

    /// Its name in tables and figures.
    pub fn name(self) -> &'static str {
        match self {
            Self::Activation => "activation alone",
            Self::InverseVariance => "activation, rows weighted by 1/v",
            Self::WithinPatterns => "activation, informative clusters only",
            Self::InPlaceOfPatterns => "clusters in place of patterns",
        }
    }
}

impl Indicators {
    /// Noise and leverage of every row, step by step and under the whole model.
    pub(super) fn new(first: &FirstFit) -> Result<Self, ExperimentError> {
        let all: Vec<usize> = (0..first.candidates.len()).collect();
        let whole = Step { pattern: None, offered: all.clone(), columns: all };
        let parts = first.steps.iter().map(|step| Part::new(first, step));
        let parts: Vec<Part> = parts.collect::<Result<_, _>>()?;
        let informative = parts.iter().map(Part::informative).collect::<Result<_, _>>()?;
        Ok(Self { parts, whole: Part::new(first, &whole)?, informative })
    }

    /// The name of each step and mean(v) mean(1/v) of its rows, the largest of the joints; last
    /// that of all rows under the whole model.
    pub(super) fn gains(&self) -> Vec<(&'static str, f64)> {
        let parts = self.parts.iter().chain(std::iter::once(&self.whole));
        parts.map(|part| (part.step.name(), part.gain())).collect()
    }

    /// Clusters that the elbow sees in the rows of each step and joint that has terms in it.
    pub(super) fn elbows(&self) -> Vec<usize> {
        let with_terms = |(part, found): (&Part, &Vec<Informative>)| -> Vec<usize> {
            let joints = found.iter().enumerate();
            let joints = joints.filter(|(joint, _)| part.has_terms(*joint));
            joints.map(|(_, found)| found.elbow).collect()
        };
        self.parts.iter().zip(&self.informative).flat_map(with_terms).collect()
    }

    /// Sorts and weights the rows.
    pub(super) fn sort(&self, sorting: Sorting) -> Result<Sorted, ExperimentError> {
        let ones = |step: usize| Mat::full(self.parts[step].rows.len(), self.n_joints(), 1.0);
        match sorting {
            Sorting::Activation => Ok(self.spread(ones, None)),
            Sorting::InverseVariance => {
                let last = self.whole.inverse_weights();
                Ok(self.spread(|step| self.parts[step].inverse_weights(), Some(last)))
            }
            Sorting::WithinPatterns => {
                let kept = |step: usize| {
                    let found = &self.informative[step];
                    Mat::from_fn(self.parts[step].rows.len(), found.len(), |row, joint| {
                        f64::from(u8::from(found[joint].kept[row]))
                    })
                };
                Ok(self.spread(kept, None))
            }
            Sorting::InPlaceOfPatterns => self.in_place_of_patterns(),
        }
    }

    fn n_joints(&self) -> usize {
        self.whole.variance.ncols()
    }

    /// Spreads weights of the rows of each step over all rows of the log. The last fit takes those
    /// of all steps together unless it is given its own.
    fn spread(&self, weights: impl Fn(usize) -> Mat<f64>, last: Option<Mat<f64>>) -> Sorted {
        let (m, n) = (self.whole.rows.len(), self.n_joints());
        let mut sum = Mat::<f64>::zeros(m, n);
        let mut steps = Vec::with_capacity(self.parts.len());
        for (step, part) in self.parts.iter().enumerate() {
            let (own, mut all) = (weights(step), Mat::zeros(m, n));
            for joint in 0..n {
                for (place, &row) in part.rows.iter().enumerate() {
                    all[(row, joint)] = own[(place, joint)];
                }
            }
            sum += &all;
            steps.push(WeightedStep { offered: part.step.offered.clone(), weights: all });
        }
        Sorted { steps, refit: last.unwrap_or(sum) }
    }

    fn in_place_of_patterns(&self) -> Result<Sorted, ExperimentError> {
        let (m, n) = (self.whole.rows.len(), self.n_joints());
        let mut steps: Vec<WeightedStep> = self
            .parts
            .iter()
            .map(|part| WeightedStep {
                offered: part.step.offered.clone(),
                weights: Mat::zeros(m, n),
            })
            .collect();
        let last = steps.len().saturating_sub(1);
        for joint in 0..n {
            let [variance, leverage] =
                [&self.whole.variance, &self.whole.leverage].map(|x| x.col_as_slice(joint));
            for (row, cluster) in by_noise(variance, leverage)?.into_iter().enumerate() {
                steps[cluster.min(last)].weights[(row, joint)] = 1.0;
            }
        }
        Ok(Sorted { steps, refit: Mat::full(m, n, 1.0) })
    }
}

impl Part {
    fn new(first: &FirstFit, step: &Step) -> Result<Self, ExperimentError> {
        let rows = first.rows_of(step);
        let log = first.log.select(&rows);
        let variance = effective_variance(&first.model_of(step), &log, &first.noise)?;
        let leverage = leverage(first, step, &rows, &variance)?;
        Ok(Self { step: step.clone(), rows, variance, leverage })
    }

    /// Which rows carry information, joint by joint.
    fn informative(&self) -> Result<Vec<Informative>, ExperimentError> {
        let own = |joint: usize| {
            informative(self.variance.col_as_slice(joint), self.leverage.col_as_slice(joint))
        };
        (0..self.variance.ncols()).map(own).collect()
    }

    /// Whether the regression of the step has terms in the equation of a joint.
    fn has_terms(&self, joint: usize) -> bool {
        self.leverage.col_as_slice(joint).iter().any(|h| *h > 0.0)
    }

    /// Weights 1/v, each joint's with a mean of one, rows×n.
    fn inverse_weights(&self) -> Mat<f64> {
        let joints = 0..self.variance.ncols();
        let weights: Vec<Vec<f64>> =
            joints.map(|joint| inverse_weights(self.variance.col_as_slice(joint))).collect();
        Mat::from_fn(self.rows.len(), weights.len(), |row, joint| weights[joint][row])
    }

    fn gain(&self) -> f64 {
        let joints = 0..self.variance.ncols();
        joints.map(|joint| possible_gain(self.variance.col_as_slice(joint))).fold(1.0, f64::max)
    }
}
