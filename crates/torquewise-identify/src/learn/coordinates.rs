//! Joints that the log counts otherwise than the file their axes are from: turned round, or from
//! another zero.

use super::gravity::AS_GIVEN;
use super::{ChainLearner, TRIAL_ROWS, left, searching};
use crate::{ChainSpec, record_worth, trial};
use rayon::prelude::*;
use std::collections::BTreeSet;
use std::f64::consts::FRAC_PI_2;
use torquewise_model::Choice;
use torquewise_motion::Motion;
use torquewise_rigid::{Chain, refine};
use torquewise_stepwise::{IdentifyError, thinned};

/// As the model file has it.
pub(super) const COORDINATES: &str = "coordinates";
/// Rows that all ways are tried on.
const ROWS: usize = 300;
/// Each joint counted otherwise must leave this part of what is left before, RMS.
const PROMISING: f64 = 0.8;
/// So many of the best are gone on with: of two joints, the right way of one may not be the best alone.
const KEPT: usize = 8;
/// What is left is alike within this factor.
const ALIKE: f64 = 1.05;
/// Read as given, held-out rows must be missed by more than this part above what all leave: a right
/// file must never be doubted.
const WORTH: f64 = 0.5;

/// A joint as it may be counted: turned round or not, and from a zero some quarters of a turn away.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Counted {
    joint: usize,
    is_turned: bool,
    quarters: u8,
}

impl Counted {
    /// Every other way to count a joint.
    fn ways(joint: usize, turns: bool) -> impl Iterator<Item = Self> {
        let all =
            [false, true].into_iter().flat_map(|is_turned| (0..4).map(move |own| (is_turned, own)));
        let others = all.filter(|way| *way != (false, 0));
        let others = others.filter(move |(_, quarters)| turns || *quarters == 0);
        others.map(move |(is_turned, quarters)| Self { joint, is_turned, quarters })
    }

    /// How many turns and zeros are others.
    fn oddity(all: &[Self]) -> usize {
        all.iter().map(|own| usize::from(own.is_turned) + usize::from(own.quarters > 0)).sum()
    }

    /// The same motion, with the joint counted so.
    fn read(self, motion: Motion) -> Result<Motion, IdentifyError> {
        let Self { joint, is_turned, quarters } = self;
        let sign = if is_turned { -1.0 } else { 1.0 };
        let mut signals = motion.into_signals();
        let turned = [&mut signals.q, &mut signals.dq, &mut signals.ddq].into_iter();
        for x in turned.chain(&mut signals.tau) {
            x.col_mut(joint).iter_mut().for_each(|x| *x *= sign);
        }
        signals.q.col_mut(joint).iter_mut().for_each(|q| *q += f64::from(quarters) * FRAC_PI_2);
        Ok(Motion::new(signals)?)
    }

    /// `joint3 as -q + 90°`.
    fn told(&self, name: &str) -> String {
        let sign = if self.is_turned { "-" } else { "" };
        let zero = ["", " + 90°", " + 180°", " - 90°"][usize::from(self.quarters)];
        format!("{name} as {sign}q{zero}")
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
        let read = |counted: &[Counted], motion: &Motion| {
            let read = counted.iter().try_fold(motion.clone(), |motion, own| own.read(motion))?;
            let learner =
                ChainLearner { laws: self.laws.clone(), ..ChainLearner::new(&read, self.watch) };
            learner.rows(spec, read.n_rows())
        };
        let (few, all) = (thinned(self.motion, ROWS), thinned(self.motion, TRIAL_ROWS));
        let fitted = |counted: &[Counted]| -> Result<Chain, IdentifyError> {
            Ok(refine(&read(counted, &few)?, chain, &spec.free, &spec.search, &watch)?)
        };
        let as_given = fitted(&[])?;
        let (mut best, mut kept) = ((Vec::new(), as_given.clone()), vec![Vec::new()]);
        // Where the first begins is where gravity pulls.
        let turns = |joint: usize| joint > 0 && chain.geometry.kinds().of(joint).turns();
        let joints = 0..self.motion.n_joints();
        let other: Vec<Counted> =
            joints.flat_map(|joint| Counted::ways(joint, turns(joint))).collect();
        loop {
            let mut ways = BTreeSet::new();
            for counted in &kept {
                let is_other =
                    |own: &&Counted| counted.iter().all(|known: &Counted| known.joint != own.joint);
                for own in other.iter().filter(is_other) {
                    let mut counted = [&counted[..], &[*own]].concat();
                    counted.sort_unstable();
                    ways.insert(counted);
                }
            }
            let ways: Vec<Vec<Counted>> = ways.into_iter().collect();
            let tried = ways.into_par_iter().filter_map(|counted| {
                let chain = fitted(&counted).ok()?;
                Some((counted, chain))
            });
            let mut tried: Vec<(Vec<Counted>, Chain)> = tried.collect();
            // Half a turn more is often the same to all torques: the plainest of those alike.
            let least = tried.iter().map(|(_, own)| left(own)).fold(f64::INFINITY, f64::min);
            let alike = tried.iter().filter(|(_, own)| left(own) <= ALIKE * least);
            let plainest = alike.min_by_key(|(counted, _)| Counted::oddity(counted)).cloned();
            match plainest.filter(|(_, own)| left(own) <= PROMISING * left(&best.1)) {
                Some(plainest) => best = plainest,
                None => break,
            }
            tried.sort_by(|a, b| left(&a.1).total_cmp(&left(&b.1)));
            kept = tried.into_iter().take(KEPT).map(|(counted, _)| counted).collect();
        }
        let (found, best) = best;
        if found.is_empty() {
            return Ok(());
        }
        let told = found.iter().map(|own| own.told(&self.motion.joints()[own.joint]));
        let label = told.collect::<Vec<_>>().join(", ");
        let trials = [
            trial(AS_GIVEN.to_owned(), spec, &read(&[], &all)?, &as_given, &watch)?,
            trial(label, spec, &read(&found, &all)?, &best, &watch)?,
        ];
        record_worth(COORDINATES, &trials, WORTH, choices);
        Ok(())
    }
}
