//! From learned chain to the terms it was not offered, and what each would explain of its residual
//! (E10).

use crate::drive_terms::DriveTerm;
use crate::learn::{Learned, TRIED_ROWS};
use crate::plan::FrictionKind;
use crate::states::States;
use crate::warning::UntriedTerm;
use faer::Mat;
use rayon::prelude::*;
use std::cmp::Ordering;
use std::ops::Range;
use torquewise_model::model::{OmittedTerms, Unused};
use torquewise_model::{EnergyTerm, FrictionTerm, Place, Term, Trig};
use torquewise_regression::screen::{Gain, Screen};
use torquewise_stepwise::candidates::largest_energy_library;
use torquewise_stepwise::error::IdentifyError;
use torquewise_stepwise::held_out::{BLOCKS, mean, split, standard_error};
use torquewise_stepwise::survey::{Survey, thinned};

/// Terms of the energy library at most: all of them up to seven joints.
const MOST_TRIED: usize = 60_000;
/// Terms that are evaluated at once by a thread.
const AT_ONCE: usize = 64;
/// Terms that are reported.
const REPORTED: usize = 5;
/// A term must lower the residual of a joint by this part, RMS, on rows it was not chosen on.
const WORTH: f64 = 0.05;
/// It must explain this part of the spread of the torque as well: less is of no use.
const RELEVANT: f64 = 0.005;

/// A term that was not offered.
#[derive(Clone, Debug, PartialEq)]
enum Candidate {
    Energy(EnergyTerm),
    Friction(FrictionTerm),
}

/// What trying all terms came to.
pub(crate) struct Tried {
    pub(crate) certificate: OmittedTerms,
    /// Of a term that explains what no chain does.
    pub(crate) warning: Option<UntriedTerm>,
    /// The best of those that are terms of an energy and were not refused, if it explains what no
    /// chain does.
    pub(crate) missing: Option<EnergyTerm>,
}

/// Tries every term of the energy library, those of springs and the friction that was not allowed,
/// each on its own; and warns if one explains what no chain does.
///
/// - `refused`: terms with which a fit did no better
pub(crate) fn test_omitted_terms(
    learned: &Learned,
    survey: &Survey,
    friction: FrictionKind,
    refused: &[EnergyTerm],
) -> Result<Tried, IdentifyError> {
    let trials = OmittedTermTests::new(learned, survey)?;
    let candidates = candidates(learned, friction);
    let gains = trials.gains(&candidates)?;
    let all: Vec<usize> = (0..candidates.len()).collect();
    let order = by_share(&gains, &all, |gain| gain.share);
    let best = order.iter().take(REPORTED).filter(|&&place| gains[place].share > 0.0);
    let best = best
        .map(|&place| Ok(trials.unused(&candidates[place], &gains[place])?.0))
        .collect::<Result<Vec<Unused>, IdentifyError>>()?;
    let verdict = trials.verdict(&candidates, &gains, &all)?;
    let certificate = OmittedTerms {
        candidates: candidates.len(),
        rows: learned.rows.len(),
        best,
        held_out: verdict.as_ref().map_or(0.0, |verdict| verdict.held_out),
        held_out_std_error: verdict.as_ref().map_or(0.0, |verdict| verdict.std_error),
    };
    let certain = verdict.filter(|verdict| verdict.is_certain(&trials, survey));
    let warning = certain.as_ref().map(|verdict| {
        let (term, refused) = match &candidates[verdict.place] {
            Candidate::Energy(term) => (term.name(), refused.contains(term)),
            Candidate::Friction(term) => (term.name(), false),
        };
        let friction = matches!(candidates[verdict.place], Candidate::Friction(_));
        let joint = survey.joints[verdict.joint].clone();
        UntriedTerm { term, joint, part: verdict.held_out.min(1.0), friction, refused }
    });
    let energy = |place: &usize| match &candidates[*place] {
        Candidate::Energy(term) if !refused.contains(term) => Some(term.clone()),
        _ => None,
    };
    let missing = match certain {
        // Most logs: nothing is certain, and no lesser term will be.
        None => None,
        Some(verdict) if energy(&verdict.place).is_some() => energy(&verdict.place),
        Some(_) => {
            let others: Vec<usize> =
                all.into_iter().filter(|place| energy(place).is_some()).collect();
            let verdict = trials.verdict(&candidates, &gains, &others)?;
            let certain = verdict.filter(|verdict| verdict.is_certain(&trials, survey));
            certain.and_then(|verdict| energy(&verdict.place))
        }
    };
    Ok(Tried { certificate, warning, missing })
}

/// The best of some terms, and how it does where it was not chosen.
struct Verdict {
    place: usize,
    /// The joint that gains most.
    joint: usize,
    /// By what part the residual of that joint falls on held-out blocks, and its standard error.
    held_out: f64,
    std_error: f64,
}

impl Verdict {
    /// Whether it holds on rows it was not chosen on, by more than chance, and matters.
    fn is_certain(&self, trials: &OmittedTermTests<'_>, survey: &Survey) -> bool {
        let part = trials.left_of(self.joint) / survey.torque_std[self.joint];
        let stays = 1.0 - self.held_out.min(1.0);
        let removed = part * (1.0 - stays.powi(2)).max(0.0).sqrt();
        self.held_out.min(1.0) - self.std_error >= WORTH && removed >= RELEVANT
    }
}

/// Some places of gains, the largest first, equal ones in their order.
fn by_share(gains: &[Gain], places: &[usize], share: impl Fn(&Gain) -> f64) -> Vec<usize> {
    let mut order = places.to_vec();
    order.sort_by(|&a, &b| {
        let larger = share(&gains[b]).partial_cmp(&share(&gains[a])).unwrap_or(Ordering::Equal);
        larger.then(a.cmp(&b))
    });
    order
}

/// All that is tried. What is fitted already says nothing of its own and gains nothing.
fn candidates(learned: &Learned, friction: FrictionKind) -> Vec<Candidate> {
    let n = learned.rows.n_joints();
    let library = largest_energy_library(n, MOST_TRIED).into_iter();
    // Where it may choose, the learner has judged all laws of friction itself.
    let laws = match friction {
        FrictionKind::None | FrictionKind::Linear => learned.laws.of(FrictionKind::Stribeck),
        FrictionKind::Stribeck | FrictionKind::Auto => Vec::new(),
    };
    let energies = library.chain(springs(n)).map(Candidate::Energy);
    energies.chain(laws.into_iter().map(Candidate::Friction)).collect()
}

/// Terms of V that masses never make, in one angle or two: second harmonics, from springs between
/// links and counterbalances.
fn springs(n: usize) -> impl Iterator<Item = EnergyTerm> {
    let waves = move |joint: usize| {
        [(Trig::Cos, 1), (Trig::Sin, 1), (Trig::Cos, 2), (Trig::Sin, 2)]
            .map(|(trig, multiple)| (joint, trig, multiple))
    };
    let alone = (0..n).flat_map(move |joint| waves(joint).into_iter().map(|wave| vec![wave]));
    let pairs =
        (0..n).flat_map(move |i| (i + 1..n).map(move |j| (i, j))).flat_map(move |(i, j)| {
            waves(i).into_iter().flat_map(move |a| waves(j).into_iter().map(move |b| vec![a, b]))
        });
    let second = |waves: &Vec<(usize, Trig, i8)>| waves.iter().any(|wave| wave.2 == 2);
    alone.chain(pairs).filter(second).map(move |waves| {
        let one = Term::one(n);
        let function = waves.into_iter().fold(one, |term, (j, trig, k)| term.times(trig, j, k, 1));
        EnergyTerm { place: Place::Potential, function }
    })
}

/// Rows of a log in blocks of time, on which terms are tried.
///
/// Equations are in the order block, joint, row.
struct OmittedTermTests<'a> {
    names: &'a [String],
    states: States,
    screen: Screen,
    /// Rows of each block.
    blocks: Vec<Range<usize>>,
    /// What each equation counts, m·n.
    weights: Vec<f64>,
    /// Weighted residual of the chain, m·n.
    residual: Vec<f64>,
    /// One over the noise of each joint \[1/(N·m)\], n.
    noise: Vec<f64>,
}

impl<'a> OmittedTermTests<'a> {
    fn new(learned: &Learned, survey: &'a Survey) -> Result<Self, IdentifyError> {
        let (rows, chain) = (&learned.rows, &learned.chain);
        let (m, n) = (rows.len(), rows.n_joints());
        let noise = chain.weights(rows);
        let held = (0..BLOCKS).map(|block| split(m, block).0);
        let tangents = held
            .map(|held| Ok(chain.tangent(&rows.select(&held), &noise)?))
            .collect::<Result<Vec<_>, IdentifyError>>()?;
        let p = tangents.first().map_or(0, |tangent| tangent.columns.ncols());
        let (mut columns, mut start) = (Mat::zeros(m * n, p), 0);
        for tangent in &tangents {
            let count = tangent.residual.len();
            columns.subrows_mut(start, count).copy_from(&tangent.columns);
            start += count;
        }
        let joined = |part: fn(&torquewise_rigid::Tangent) -> &Vec<f64>| -> Vec<f64> {
            tangents.iter().flat_map(part).copied().collect()
        };
        let (residual, weights) = (joined(|t| &t.residual), joined(|t| &t.weights));
        let sizes: Vec<usize> = tangents.iter().map(|tangent| tangent.residual.len()).collect();
        let mut end = 0;
        let blocks = sizes.iter().map(|size| {
            end += size / n;
            end - size / n..end
        });
        Ok(Self {
            names: &survey.joints,
            states: States::of(&thinned(&survey.sample, TRIED_ROWS)),
            blocks: blocks.collect(),
            weights,
            screen: Screen::new(columns, &residual, &sizes)?,
            residual,
            noise,
        })
    }

    /// What each term would explain, in their order.
    fn gains(&self, candidates: &[Candidate]) -> Result<Vec<Gain>, IdentifyError> {
        let gains: Vec<Vec<Gain>> = candidates
            .par_chunks(AT_ONCE)
            .map(|some| {
                let mut columns = Mat::zeros(self.weights.len(), some.len());
                for (j, candidate) in some.iter().enumerate() {
                    self.fill(candidate, columns.col_as_slice_mut(j));
                }
                self.screen.gains(columns.as_ref())
            })
            .collect::<Result<_, _>>()?;
        Ok(gains.into_iter().flatten().collect())
    }

    /// Writes the weighted torque of a term, m·n.
    fn fill(&self, candidate: &Candidate, out: &mut [f64]) {
        let n = self.states.n_joints();
        let loads = match candidate {
            Candidate::Energy(term) => self.states.loads(term, 1.0),
            Candidate::Friction(term) => DriveTerm::Friction(term.clone()).loads(&self.states),
        };
        let mut next = 0;
        for block in &self.blocks {
            for joint in 0..n {
                let (from, end) = (&loads.col_as_slice(joint)[block.clone()], next + block.len());
                let weights = &self.weights[next..end];
                for (out, (load, weight)) in out[next..end].iter_mut().zip(from.iter().zip(weights))
                {
                    *out = load * weight;
                }
                next = end;
            }
        }
    }

    fn column(&self, candidate: &Candidate) -> Vec<f64> {
        let mut column = vec![0.0; self.weights.len()];
        self.fill(candidate, &mut column);
        column
    }

    /// A term with what it would explain, and the joint that gains most.
    fn unused(&self, candidate: &Candidate, gain: &Gain) -> Result<(Unused, usize), IdentifyError> {
        let [before, after] = self.screen.left(&self.column(candidate), None)?;
        let all: Vec<usize> = (0..BLOCKS).collect();
        let part =
            |joint: usize| fall(self.rms(&before, &all, joint), self.rms(&after, &all, joint));
        let parts: Vec<f64> = (0..self.states.n_joints()).map(part).collect();
        let (joint, of_joint) = (parts.into_iter().enumerate())
            .max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0)))
            .unwrap_or((0, 0.0));
        let term = match candidate {
            Candidate::Energy(term) => term.name(),
            Candidate::Friction(term) => term.name(),
        };
        let unused = Unused { term, share: gain.share, joint: self.names[joint].clone(), of_joint };
        Ok((unused, joint))
    }

    /// Judges the best of some candidates on blocks it was not chosen on; `None` if none gains.
    fn verdict(
        &self,
        candidates: &[Candidate],
        gains: &[Gain],
        places: &[usize],
    ) -> Result<Option<Verdict>, IdentifyError> {
        let best = by_share(gains, places, |gain| gain.share).into_iter().next();
        let Some(place) = best.filter(|&place| gains[place].share > 0.0) else { return Ok(None) };
        let (_, joint) = self.unused(&candidates[place], &gains[place])?;
        let most = |block: usize| by_share(gains, places, |gain| gain.without[block])[0];
        let judge = |block| self.held_out(&candidates[most(block)], block, joint);
        let held_out = (0..BLOCKS).map(judge).collect::<Result<Vec<f64>, IdentifyError>>()?;
        let std_error = standard_error(&held_out);
        Ok(Some(Verdict { place, joint, held_out: mean(&held_out), std_error }))
    }

    /// By what part the residual of a joint falls on a block, term and parameters fitted to the
    /// others.
    fn held_out(
        &self,
        candidate: &Candidate,
        block: usize,
        joint: usize,
    ) -> Result<f64, IdentifyError> {
        let [before, after] = self.screen.left(&self.column(candidate), Some(block))?;
        Ok(fall(self.rms(&before, &[block], joint), self.rms(&after, &[block], joint)))
    }

    /// RMS of what the chain leaves of the torque of a joint \[N·m\].
    fn left_of(&self, joint: usize) -> f64 {
        let all: Vec<usize> = (0..BLOCKS).collect();
        self.rms(&self.residual, &all, joint) / self.noise[joint]
    }

    /// Root of the mean square of a joint's equations in some blocks.
    fn rms(&self, residual: &[f64], blocks: &[usize], joint: usize) -> f64 {
        let n = self.states.n_joints();
        let (mut squares, mut count) = (0.0, 0_usize);
        for block in blocks.iter().map(|&block| &self.blocks[block]) {
            let start = n * block.start + joint * block.len();
            squares += residual[start..start + block.len()].iter().map(|r| r * r).sum::<f64>();
            count += block.len();
        }
        (squares / count.max(1) as f64).sqrt()
    }
}

/// By what part a number falls.
fn fall(before: f64, after: f64) -> f64 {
    if before > 0.0 { 1.0 - after / before } else { 0.0 }
}

#[cfg(test)]
mod tests;
