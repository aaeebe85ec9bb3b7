//! The parts of a recording: those that tell most about the coefficients.

use crate::excite::information::Information;
use crate::excite::library::{Library, Stage};
use crate::excite::recording::REST;
use crate::excite::segment::glide_seconds;
use crate::excite::torques::{Torques, route};
use crate::{Bounds, Part, Result, Sweep, between};
use faer::Mat;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use std::f64::consts::TAU;
use torquewise_motion::median;

pub(crate) struct Task<'a> {
    pub(crate) stage: Stage,
    pub(crate) library: &'a Library,
    pub(crate) limits: &'a [Bounds],
    pub(crate) home: &'a [f64],
    pub(crate) torques: Option<&'a Torques>,
    /// Time \[s\] of the whole recording at most.
    pub(crate) seconds: f64,
    /// Parts to choose from, each time.
    pub(crate) tries: usize,
    /// How often each part is looked at again.
    pub(crate) rounds: usize,
}

#[derive(Clone)]
struct Chosen {
    part: Part,
    rows: Mat<f64>,
}

/// What no column is worth less than, as a share of what it is worth over the limits.
const RIDGE: f64 = 1e-9;
/// Parts that may be drawn in vain, for each that is tried.
const VAIN: usize = 20;
/// And so many times as often where the torque is limited.
const HARDER: usize = 10;
/// Share of the time after which joints no longer sweep alone, if each did so once.
const ALONE: f64 = 0.5;
/// Longest sweep of several joints as a share of the recording.
const LONGEST_SWEEP: f64 = 0.1;
/// Period of sines \[s\] at least and at most, and as a share of the longest that is useful.
const PERIOD: [f64; 2] = [2.0, 30.0];
const PERIOD_SHARE: [f64; 2] = [0.5, 1.0];

impl Task<'_> {
    /// Chooses parts one by one, each the one that adds most to the information per second, until
    /// no further one fits; then tries to replace each by a better one.
    ///
    /// The information is the determinant of the Gram matrix (D-optimality). `known`: rows of
    /// earlier recordings. `progress`: told the share of the work that is done.
    pub(crate) fn design(
        &self,
        known: &[Mat<f64>],
        rng: &mut ChaCha8Rng,
        progress: &mut dyn FnMut(f64),
    ) -> Result<Vec<Part>> {
        let n = self.limits.len() as f64;
        let mut information =
            Information::new(self.library.n_columns(), RIDGE * n * self.seconds, known);
        let mut chosen: Vec<Chosen> = Vec::new();
        // The second half of the work is to look again.
        let half = if self.rounds > 0 { 0.5 } else { 1.0 };
        while let Some(next) = self.next(&information, &chosen, rng)? {
            information.add(next.rows.as_ref(), 1.0);
            chosen.push(next);
            progress(half * self.seconds_with(&chosen, None) / self.seconds);
        }
        let total = self.rounds * chosen.len();
        for step in 0..total {
            let place = step % chosen.len();
            let old = chosen[place].clone();
            let kind = old.part.sweep.unwrap_or(Sweep::Together);
            let mut drawn = Vec::new();
            for k in 0..self.tries {
                let varied =
                    if k % 4 == 3 { self.draw(kind, rng) } else { old.part.vary(self.limits, rng) };
                let fits = |part: &Part| {
                    self.seconds_with(&chosen, Some((place, part))) <= self.seconds
                        && self.keeps(&chosen, place, part)
                };
                drawn.extend(varied.filter(fits).map(|part| (part, 1.0)));
            }
            let mut without = information.clone();
            without.add(old.rows.as_ref(), -1.0);
            let kept = without.gain(old.rows.as_ref());
            if let Some((better, gain)) = self.best(&without, drawn)?
                && gain > kept
            {
                without.add(better.rows.as_ref(), 1.0);
                information = without;
                chosen[place] = better;
            }
            progress(0.5 + 0.5 * (step + 1) as f64 / total as f64);
        }
        Ok(chosen.into_iter().map(|chosen| chosen.part).collect())
    }

    /// The best of some parts that fit at the end, if any does.
    fn next(
        &self,
        information: &Information,
        chosen: &[Chosen],
        rng: &mut ChaCha8Rng,
    ) -> Result<Option<Chosen>> {
        let before = self.seconds_with(chosen, None);
        let kind = self.kind(chosen.len(), before);
        let mut drawn = Vec::new();
        // Limits of the torque refuse most parts that are drawn.
        let vain = if self.torques.is_some() { HARDER * VAIN } else { VAIN };
        for _ in 0..vain * self.tries {
            if drawn.len() == self.tries {
                break;
            }
            let Some(part) = self.draw(kind, rng) else { continue };
            let seconds = self.seconds_with(chosen, Some((chosen.len(), &part)));
            if seconds <= self.seconds && self.keeps(chosen, chosen.len(), &part) {
                drawn.push((part, (seconds - before).max(f64::MIN_POSITIVE)));
            }
        }
        Ok(self.best(information, drawn)?.map(|(chosen, _)| chosen))
    }

    /// The part that tells most per unit of its cost, the first of equals, and what it tells.
    fn best(
        &self,
        information: &Information,
        drawn: Vec<(Part, f64)>,
    ) -> Result<Option<(Chosen, f64)>> {
        // Each is judged in one thread and the best is looked for in order: same bits. Columns are
        // made twice for the best, so that those of all need not be kept.
        let worths = drawn.par_iter().map(|(part, cost)| {
            let rows = self.library.rows(&part.states(1))?;
            // What is not a number is worth nothing.
            Ok((information.gain(rows.as_ref()) / cost).max(f64::NEG_INFINITY))
        });
        let worths: Vec<f64> = worths.collect::<Result<_>>()?;
        let judged = drawn.into_iter().zip(worths);
        let best = judged.reduce(|best, next| if next.1 > best.1 { next } else { best });
        let Some(((part, _), worth)) = best else { return Ok(None) };
        let rows = self.library.rows(&part.states(1))?;
        Ok(Some((Chosen { part, rows }, worth)))
    }

    /// Time \[s\] of the recording with a part put in a place, at the end or instead of another.
    fn seconds_with(&self, chosen: &[Chosen], put: Option<(usize, &Part)>) -> f64 {
        let mut parts: Vec<&Part> = chosen.iter().map(|chosen| &chosen.part).collect();
        match put {
            Some((place, part)) if place < parts.len() => parts[place] = part,
            Some((_, part)) => parts.push(part),
            None => {}
        }
        // With the glides between them.
        let (mut seconds, mut at) = (2.0 * REST, self.home.to_vec());
        for part in parts {
            let next = part.anchor();
            seconds += glide_seconds(&at, &next, self.limits) + part.seconds();
            at = next;
        }
        seconds + glide_seconds(&at, self.home, self.limits)
    }

    /// Whether a part in a place, with the ways to it and on, keeps to the torques.
    fn keeps(&self, chosen: &[Chosen], place: usize, part: &Part) -> bool {
        let anchor = |place: Option<usize>| {
            let there = place.and_then(|place| chosen.get(place));
            there.map_or_else(|| self.home.to_vec(), |chosen| chosen.part.anchor())
        };
        self.torques.is_none_or(|torques| {
            let [from, to] = [place.checked_sub(1), place.checked_add(1)].map(anchor);
            torques.keep(&route(&from, part, &to, self.limits))
        })
    }

    /// What a sweep in a place moves: each joint alone, fast, then slow while there is time, then
    /// several together.
    fn kind(&self, place: usize, before: f64) -> Sweep {
        let n = self.limits.len();
        if place < n {
            Sweep::Fast(place)
        } else if place < 2 * n && before < ALONE * self.seconds {
            Sweep::Slow(place - n)
        } else {
            Sweep::Together
        }
    }

    /// A part of the recording; `None` if what was drawn makes no sense.
    fn draw(&self, kind: Sweep, rng: &mut ChaCha8Rng) -> Option<Part> {
        let (limits, n) = (self.limits, self.limits.len());
        match self.stage {
            Stage::Standstill { dwell, creep: false } => Some(Part::pose(dwell, limits, rng)),
            Stage::Standstill { dwell, creep: true } => Part::creep(dwell, limits, rng),
            Stage::Uniform => {
                let most = match kind {
                    Sweep::Together => LONGEST_SWEEP * self.seconds,
                    _ => ALONE * self.seconds / (2 * n) as f64,
                };
                Part::sweep(kind, most, limits, rng)
            }
            Stage::Variable => {
                // Period [s] in which the joints, half of them at least, can cross their range and return.
                let period = |limits: &Bounds| {
                    TAU * (limits.position[1] - limits.position[0]) / 2.0 / limits.velocity
                };
                let mut periods: Vec<f64> = limits.iter().map(period).collect();
                let room = 0.7 * self.seconds / PERIOD_SHARE[1];
                let longest = median(&mut periods).clamp(PERIOD[0], PERIOD[1]).min(room);
                Some(Part::sines(longest * between(rng, PERIOD_SHARE), limits, rng))
            }
        }
    }
}
