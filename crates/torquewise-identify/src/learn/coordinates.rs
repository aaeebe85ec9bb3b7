//! Joints that the log counts otherwise than the file their axes are from: turned round, or from
//! another zero.

use super::gravity::AS_GIVEN;
use super::{ChainLearner, TRIAL_ROWS, left, searching};
use crate::chain_spec::{ChainSpec, record_worth, trial};
use rayon::prelude::*;
use std::f64::consts::FRAC_PI_2;
use torquewise_model::model::Choice;
use torquewise_motion::Motion;
use torquewise_rigid::{Chain, refine};
use torquewise_stepwise::error::IdentifyError;
use torquewise_stepwise::survey::thinned;

/// As the model file has it.
pub(super) const COORDINATES: &str = "coordinates";
/// Rows that all ways are tried on.
const ROWS: usize = 300;
/// Each joint counted otherwise must leave this part of what is left before, RMS.
const PROMISING: f64 = 0.8;
/// Read as given, held-out rows must be missed by more than this part above what all leave: a right
/// file must never be doubted.
const WORTH: f64 = 0.5;

/// A joint as it may be counted: its position times a sign, and quarters of a turn.
#[derive(Clone, Copy, Debug)]
struct Counted {
    joint: usize,
    sign: f64,
    quarters: u8,
}

impl Counted {
    /// Every other way to count a joint.
    fn ways(joint: usize, turns: bool) -> impl Iterator<Item = Self> {
        let all = [1.0, -1.0].into_iter().flat_map(|sign| (0..4).map(move |own| (sign, own)));
        let others = all.filter(|way| *way != (1.0, 0));
        let others = others.filter(move |(_, quarters)| turns || *quarters == 0);
        others.map(move |(sign, quarters)| Self { joint, sign, quarters })
    }

    /// The same motion, with the joint counted so.
    fn read(self, motion: Motion) -> Result<Motion, IdentifyError> {
        let Self { joint, sign, quarters } = self;
        let mut signals = motion.into_signals();
        let turned = [&mut signals.q, &mut signals.dq, &mut signals.ddq].into_iter();
        for x in turned.chain(&mut signals.tau) {
            x.col_mut(joint).iter_mut().for_each(|x| *x *= sign);
        }
        signals.q.col_mut(joint).iter_mut().for_each(|q| *q += f64::from(quarters) * FRAC_PI_2);
        Ok(Motion::new(signals)?)
    }

    /// `joint3 as 90° - q`.
    fn told(&self, name: &str) -> String {
        let zero = ["", "90° ", "180° ", "-90° "][usize::from(self.quarters)];
        let sign = match (self.sign < 0.0, zero.is_empty()) {
            (true, true) => "-",
            (true, false) => "- ",
            (false, _) => "+ ",
        };
        format!("{name} as {zero}{sign}q")
    }
}

impl ChainLearner<'_> {
    /// Looks for joints whose torque a chain at given axes explains far better where the log is read
    /// otherwise; nothing is changed.
    pub(super) fn coordinates(
        &self,
        spec: &ChainSpec,
        chain: &Chain,
        choices: &mut Vec<Choice>,
    ) -> Result<(), IdentifyError> {
        let watch = searching(self.watch);
        let read = |counted: &[Counted], count: usize| {
            let motion = thinned(self.motion, count);
            let motion = counted.iter().try_fold(motion, |motion, own| own.read(motion))?;
            let learner =
                ChainLearner { laws: self.laws.clone(), ..ChainLearner::new(&motion, self.watch) };
            learner.rows(spec, count)
        };
        let fitted = |counted: &[Counted]| -> Result<Chain, IdentifyError> {
            Ok(refine(&read(counted, ROWS)?, chain, &spec.free, &spec.search, &watch)?)
        };
        let (mut found, as_given) = (Vec::<Counted>::new(), fitted(&[])?);
        let mut best = as_given.clone();
        loop {
            let others = (0..self.motion.n_joints())
                .filter(|joint| found.iter().all(|own| own.joint != *joint));
            // Where the first begins is where gravity pulls.
            let turns = |joint: usize| joint > 0 && chain.geometry.kinds().of(joint).turns();
            let ways = others.flat_map(|joint| Counted::ways(joint, turns(joint)));
            let ways: Vec<Vec<Counted>> = ways.map(|own| [&found[..], &[own]].concat()).collect();
            let tried = ways.par_iter().map(|counted| fitted(counted));
            let tried = tried.collect::<Result<Vec<Chain>, IdentifyError>>()?;
            let least =
                ways.into_iter().zip(tried).min_by(|a, b| left(&a.1).total_cmp(&left(&b.1)));
            let Some(least) = least.filter(|(_, own)| left(own) <= PROMISING * left(&best)) else {
                break;
            };
            (found, best) = least;
        }
        if found.is_empty() {
            return Ok(());
        }
        let told = found.iter().map(|own| own.told(&self.motion.joints()[own.joint]));
        let label = told.collect::<Vec<_>>().join(", ");
        let trials = [
            trial(AS_GIVEN.to_owned(), spec, &read(&[], TRIAL_ROWS)?, &as_given, &watch)?,
            trial(label, spec, &read(&found, TRIAL_ROWS)?, &best, &watch)?,
        ];
        record_worth(COORDINATES, &trials, WORTH, choices);
        Ok(())
    }
}
