//! Passes over all rows until the parameters converge (E11).

use super::linearisation::Linearisation;
use super::nominal::Sizes;
use super::pass::add_up;
use super::solve::Solved;
use super::step::{Step, weights};
use crate::{Progress, Watch, geometric_mean};
use serde::{Deserialize, Serialize};
use std::ops::ControlFlow;
use torquewise_motion::Recording;
use torquewise_regression::NormalSums;
use torquewise_stepwise::{IdentifyError, NoiseFloor};

/// Passes over a sample, for each set of weights, at most.
const SAMPLE_PASSES: usize = 20;
/// Times that a sample is refined, each with weights by what is left before: at least, and at most
/// where each leaves much less than the one before, as without noise.
const WEIGHINGS: [usize; 2] = [2, 10];
const MUCH_LESS: f64 = 0.7;
/// Part of a step that is tried where the whole was worse.
const SHORTER: f64 = 0.25;
/// First and longest step of a parameter of the geometry \[rad, m\].
const REACH: [f64; 2] = [0.2, 1.0];
/// A step that gained this part of what it promised may be twice as long the next time.
const AS_PROMISED: f64 = 0.5;

/// Passes over rows, each from where the last one led (E11).
///
/// The best linear parameters follow from the geometry, so a pass is judged by what they leave
/// there. A step of the geometry after which more is left than before was too long: a shorter one
/// is tried.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Passes {
    /// Where the next pass is linearised.
    pub(crate) at: Linearisation,
    /// Rows that the prior counts as, known from the first pass on.
    prior_rows: Option<f64>,
    /// The best parameters so far, what they cost, and how much less the next were to cost.
    best: Option<(Vec<f64>, f64, f64)>,
    /// Longest step of a parameter of the geometry \[rad, m\].
    reach: f64,
    /// Whether the next pass is the last: the geometry stays.
    is_last: bool,
    pub(crate) made: usize,
    most: usize,
    /// Whether parameters of the geometry that the sample held may be released.
    pub(crate) may_release: bool,
}

impl Passes {
    pub(crate) fn over_all(at: Linearisation, most: usize) -> Self {
        let (prior_rows, best, reach) = (None, None, REACH[0]);
        Self { at, prior_rows, best, reach, is_last: false, made: 0, most, may_release: true }
    }

    /// The same from the start with rows taken as they are, `most` passes at most.
    pub(crate) fn without_noise_correction(self, most: usize) -> Self {
        let noise = NoiseFloor::none(self.at.n_joints());
        let at = Linearisation { noise, raw_noise: false, ..self.at };
        Self { may_release: self.may_release, ..Self::over_all(at, most) }
    }

    /// What follows from the sums of the pass that was asked for: another pass, or a break where nothing
    /// moves any more.
    pub(crate) fn take(
        mut self,
        sums: &NormalSums,
        sizes: &Sizes,
    ) -> Result<ControlFlow<Solved, Self>, IdentifyError> {
        self.made += 1;
        let mut step = Step::new(sums, &self.at, sizes);
        step.prior_rows = *self.prior_rows.get_or_insert(step.prior_rows);
        let active = if self.made == 1 && self.may_release {
            step.with_released()?
        } else {
            self.at.active()
        };
        if self.is_last {
            return Ok(ControlFlow::Break(step.solved(&active)?));
        }
        let tolerance = step.tolerance(&active);
        let here = step.cost(&self.at.parameters());
        let linear = step.linear()?;
        let merit = step.cost(&linear);
        let gain = self.best.as_ref().map_or(f64::INFINITY, |(_, least, _)| least - merit);
        if let Some((_, _, promised)) = &self.best {
            let longer = if gain > AS_PROMISED * promised { 2.0 } else { 1.0 };
            self.reach = (longer * self.reach).min(REACH[1]);
        }
        let moved = step.step(&active, self.reach)?;
        let ahead = merit - step.cost(&moved);
        if here - merit <= tolerance && ahead <= tolerance {
            return Ok(ControlFlow::Break(step.solved(&active)?));
        }
        let best = match self.best.take() {
            Some(best) if gain <= 0.0 => {
                self.reach *= SHORTER;
                best
            }
            _ => (step.averaged(&linear, sizes)?, merit, ahead),
        };
        self.is_last = gain.abs() <= tolerance || ahead <= tolerance || self.made + 1 >= self.most;
        let parameters = if self.is_last {
            best.0.clone()
        } else if gain > 0.0 {
            moved
        } else {
            // The step was too long: between two physical arms all are physical.
            let pairs = best.0.iter().zip(self.at.parameters());
            pairs.map(|(from, to)| from + SHORTER * (to - from)).collect()
        };
        let at = self.at.at(&parameters).freed(&active);
        Ok(ControlFlow::Continue(Self { at, best: Some(best), ..self }))
    }
}

/// Passes over a recording until the parameters converge.
///
/// The search leaves inertial parameters that no arm has, and derivatives by the geometry that are
/// those of such an arm: links are made physical before the geometry moves.
///
/// - returns: the chain, and what the search left of each joint over what it leaves, rows at rest
///   counted as they are fitted, n
pub(crate) fn refine(
    recording: &(impl Recording + ?Sized),
    start: &Linearisation,
    sizes: &Sizes,
    watch: Watch<'_>,
) -> Result<(Linearisation, Vec<f64>), IdentifyError> {
    let sums = add_up(recording, start)?;
    let (searched, mut left) = (sums.weighted_rms(), Vec::new());
    let mut at = start.at(&Step::new(&sums, start, sizes).linear()?);
    for weighing in 0..WEIGHINGS[1] {
        let before = geometric_mean(&at.weights);
        at.weights = weights(&add_up(recording, &at)?.weighted_rms(), sizes);
        if weighing >= WEIGHINGS[0] && before > MUCH_LESS * geometric_mean(&at.weights) {
            break;
        }
        let mut passes = Passes { may_release: false, ..Passes::over_all(at, SAMPLE_PASSES) };
        at = loop {
            Progress::Working.tell(watch)?;
            let sums = add_up(recording, &passes.at)?;
            left = sums.weighted_rms();
            match passes.take(&sums, sizes)? {
                ControlFlow::Continue(next) => passes = next,
                ControlFlow::Break(solved) => break solved.at,
            }
        };
    }
    let part = |(searched, left): (&f64, &f64)| if *left > 0.0 { searched / left } else { 1.0 };
    Ok((at, searched.iter().zip(&left).map(part).collect()))
}
