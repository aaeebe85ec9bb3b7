//! How the axes of a chain lie: searched, held at right angles or freed, by held-out rows (E8).

use super::{ChainLearner, FINAL_ROWS, LAST_ROWS, TRIAL_ROWS, searching};
use crate::{ChainSpec, DriveTerm, record_worth, trial};
use rayon::prelude::*;
use torquewise_model::{Choice, GeometryFound, Training};
use torquewise_rigid::search::{Found, SearchWatch, turned};
use torquewise_rigid::{Chain, ChainError, ChainRows, Search, refine, search};
use torquewise_stepwise::IdentifyError;
use torquewise_stepwise::held_out::CvScore;

/// No axis is farther \[rad\] than this from the nearest right angle.
const ANY_ANGLE: f64 = 1.0;
/// Axes farther \[rad\] than this from a right angle may lie anywhere, where that lowers the error on
/// held-out rows by a part that no public arm reaches but an MTM: the others stand at right angles, and
/// seem to gain up to 5 %.
const OBLIQUE: f64 = 0.2;
const WORTH_OF_ANGLES: f64 = 0.1;
/// No axis of an arm that is looked for anywhere is held.
const ANYWHERE: f64 = 0.0;
/// An arm is another than those before only if its error is less by this part.
const CLEARLY: f64 = 0.02;
/// Parallel neighbours must lower the error by this part, with friction that remembers the path or
/// without: a wrist that hardly turns fits either way, and its axes stand across each other.
const WORTH_OF_PARALLEL: f64 = 0.05;
/// Where they lower it by less than this part without, the axis is not resolved.
pub(super) const UNRESOLVED: f64 = 0.3;
/// Two chains whose costs are closer than this are one.
const SAME: f64 = 1e-3;
/// The choice of how axes lie, as the model file has it.
pub(super) const AXES: &str = "axes at right angles";

/// A chain by its error on held-out rows, with what was fitted.
pub(super) type Judged = (CvScore, ChainSpec, Chain);

/// The best arm whose axes nearer \[rad\] than `angle` to a right angle stand there, and how many starts
/// led to it, of how many.
struct Way {
    angle: f64,
    times: [usize; 2],
    arm: Judged,
}

/// Judges a chain, its axes nearer than `angle` to a right angle put there.
fn judged(
    label: &str,
    angle: f64,
    start: &Chain,
    (spec, rows): (&ChainSpec, &ChainRows),
    watch: SearchWatch<'_>,
) -> Result<Judged, IdentifyError> {
    let (geometry, free) = start.geometry.snapped(angle);
    let (spec, start) = (ChainSpec { free, ..spec.clone() }, Chain { geometry, ..start.clone() });
    Ok((trial(label.to_owned(), &spec, rows, &start, watch)?, spec, start))
}

fn best(all: Result<Vec<Judged>, IdentifyError>) -> Result<Judged, IdentifyError> {
    let best = all?.into_iter().min_by(|a, b| a.0.error().total_cmp(&b.0.error()));
    best.ok_or(IdentifyError::Chain(ChainError::Singular))
}

impl ChainLearner<'_> {
    /// Searches the geometry. Of parallel neighbours it is asked whether they may as well stand across
    /// each other.
    pub(super) fn geometry(
        &mut self,
        spec: &mut ChainSpec,
        known: Option<Chain>,
        choices: &mut Vec<Choice>,
    ) -> Result<Chain, IdentifyError> {
        let (watch, rows) = (searching(self.watch), self.rows(spec, TRIAL_ROWS)?);
        let Way { angle, times: [times, starts], arm } =
            self.axes((spec, &rows), known, choices)?;
        let (mut least, own, mut start) = arm;
        // No axis is to make up for what friction remembers of its path.
        let moves = |joint: &usize| spec.has_friction() && self.laws.peak[*joint] > 0.0;
        let moving = (0..self.motion.n_joints()).filter(moves);
        let elements = moving.flat_map(|joint| self.laws.dahl(joint)).map(DriveTerm::Friction);
        let mut rich = spec.clone();
        rich.drive.extend(elements.filter(|own| !spec.drive.contains(own)));
        let rich_rows = self.rows(&rich, TRIAL_ROWS)?;
        let missed = |chain: &Chain| -> Result<f64, IdentifyError> {
            Ok(judged("", angle, chain, (&rich, &rich_rows), &watch)?.0.error())
        };
        let mut unresolved = Vec::new();
        for joint in 1..self.motion.n_joints() {
            // Those beyond an axis that was turned may have become parallel.
            if angle == ANYWHERE || !start.geometry.is_parallel(joint) {
                continue;
            }
            let across = start.geometry.turned_across(joint).into_par_iter().map(|geometry| {
                let start = Chain { geometry, ..start.clone() };
                judged(&least.label, angle, &start, (spec, &rows), &watch)
            });
            let across = best(across.collect())?;
            if across.0.error() < (1.0 + UNRESOLVED) * least.error() {
                unresolved.push(joint);
            }
            let near = 1.0 + WORTH_OF_PARALLEL;
            if across.0.error() < near * least.error()
                && missed(&across.2)? < near * missed(&start)?
            {
                (least, _, start) = across;
            }
        }
        self.found = Some(GeometryFound { times, starts, unresolved });
        *spec = own;
        let rows = self.rows(spec, FINAL_ROWS)?;
        let chain = refine(&rows, &start, &spec.free, &spec.search, &watch)?;
        let chain = self.falling(spec, &rows, chain)?.upright();
        self.exact(spec, &rows, chain)
    }

    /// Searches arms whose axes stand at right angles, as those of nearly all do, unless held-out rows
    /// are clear: on real logs an axis that may lie anywhere follows what the model lacks. Where freeing
    /// some lowers the error at all, starts lie anywhere too.
    fn axes(
        &self,
        at: (&ChainSpec, &ChainRows),
        known: Option<Chain>,
        choices: &mut Vec<Choice>,
    ) -> Result<Way, IdentifyError> {
        let (watch, many) = (searching(self.watch), self.rows(at.0, LAST_ROWS)?);
        let Found { chains: mut starts, times, starts: made } =
            search(&many, &at.0.search, &watch)?;
        starts.dedup_by(|a, b| (a.cost - b.cost).abs() < SAME * b.cost);
        starts.extend(known);
        let held = starts.par_iter().map(|start| judged("held", ANY_ANGLE, start, at, &watch));
        let held = held.collect::<Result<Vec<Judged>, IdentifyError>>()?;
        let free = starts.par_iter().zip(&held).map(|(start, held)| {
            if start.geometry.snapped(OBLIQUE) != start.geometry.snapped(ANY_ANGLE) {
                return judged("free", OBLIQUE, start, at, &watch);
            }
            let (trial, spec, start) = held.clone();
            Ok((CvScore { label: "free".to_owned(), ..trial }, spec, start))
        });
        let times = [times, made];
        let mut free = Way { angle: OBLIQUE, times, arm: best(free.collect())? };
        let held = Way { angle: ANY_ANGLE, times, arm: best(Ok(held))? };
        if free.arm.0.error() < held.arm.0.error() {
            let offer = |from: &[Chain], times, own: &mut Way| -> Result<(), IdentifyError> {
                let all = from.par_iter().map(|own| judged("free", ANYWHERE, own, at, &watch));
                let arm = best(all.collect())?;
                // An arm that misses more tells no angles.
                if arm.0.error() < Training::POOR.min((1.0 - CLEARLY) * own.arm.0.error()) {
                    *own = Way { angle: ANYWHERE, times, arm };
                }
                Ok(())
            };
            offer(&starts, times, &mut free)?;
            let oblique = Search { is_oblique: true, ..at.0.search.clone() };
            // Where these cannot be fitted, those found so far can; a stop is seen by the next trial.
            if let Ok(found) = search(&many, &oblique, &watch) {
                offer(&found.chains, [found.times, found.starts], &mut free)?;
            }
            if let Ok(turned) = turned(&many, &free.arm.2, &oblique, &watch) {
                offer(&[turned], [1, free.times[1]], &mut free)?;
            }
        }
        let trials = [&held, &free].map(|way| way.arm.0.clone());
        let place = record_worth(AXES, &trials, WORTH_OF_ANGLES, choices);
        Ok(if place == 0 { held } else { free })
    }
}
