//! The chain at axes that are given, and where gravity pulls on it.

use super::axes::Judged;
use super::coordinates::COORDINATES;
use super::{ChainLearner, TRIAL_ROWS, left, searching};
use crate::plan::KnownGeometry;
use crate::{ChainSpec, Warning, record_worth, spread, trial};
use rayon::prelude::*;
use torquewise_model::Choice;
use torquewise_rigid::search::FINAL_ROWS;
use torquewise_rigid::{Chain, ChainError, Geometry, JointKinds, PER_BASE, refine};
use torquewise_stepwise::IdentifyError;
use torquewise_stepwise::held_out::CvScore;

/// So much must another direction of gravity lower the held-out error than the one that is said.
const WORTH_OF_TILT: f64 = 0.05;

/// As the model file has it: where gravity was said to pull, tilted, or else along which line.
const LINE_OF_GRAVITY: &str = "direction of gravity";
pub(super) const AS_GIVEN: &str = "as given";
const TILTED: &str = "tilted";

/// What the choices of a fit say against the axes that were given: where gravity pulls, or how joints
/// are counted, whichever explains held-out rows better, and what it leaves of these.
pub(crate) fn against_axes(choices: &[Choice]) -> Option<(Warning, f64)> {
    let told = |what: &str| {
        let choice = choices.iter().find(|choice| choice.what == what)?;
        let chosen = choice.from.iter().find(|own| own.label == choice.chosen)?;
        let is_usual = [AS_GIVEN, TILTED].contains(&&*chosen.label);
        (!is_usual).then(|| (chosen.label.clone(), chosen.error))
    };
    match (told(LINE_OF_GRAVITY), told(COORDINATES)) {
        (Some((line, error)), other) if other.as_ref().is_none_or(|(_, own)| error <= *own) => {
            Some((Warning::Gravity { line }, error))
        }
        (_, other) => other.map(|(joints, error)| (Warning::Coordinates { joints }, error)),
    }
}

impl ChainLearner<'_> {
    /// The chain at a given geometry, and what held-out rows say against it.
    pub(super) fn at_given(
        &self,
        known: &KnownGeometry,
        at: &impl Fn(JointKinds) -> ChainSpec,
        choices: &mut Vec<Choice>,
    ) -> Result<(ChainSpec, Chain), IdentifyError> {
        let (mut spec, chain) = self.at_geometry(known, at, choices)?;
        let rows = self.rows(&spec, FINAL_ROWS)?;
        let chain = self.exact(&mut spec, &rows, chain)?;
        let chain = self.coupled_at(&spec, chain, choices)?;
        self.coordinates(&spec, &chain, choices)?;
        Ok((spec, chain))
    }

    /// The chain at a given geometry, which stays; but a base is never level, and may hang on a wall:
    /// where held-out rows are for it, gravity is tilted, or said to pull elsewhere.
    fn at_geometry(
        &self,
        known: &KnownGeometry,
        at: &impl Fn(JointKinds) -> ChainSpec,
        choices: &mut Vec<Choice>,
    ) -> Result<(ChainSpec, Chain), IdentifyError> {
        let spec = at(known.geometry.kinds().clone());
        let held = ChainSpec { free: Vec::new(), ..spec.clone() };
        let tilted = ChainSpec { free: (0..PER_BASE).collect(), ..spec };
        let (rows, watch) = (self.rows(&held, FINAL_ROWS)?, searching(self.watch));
        let own = &known.geometry;
        let at = |spec: &ChainSpec, geometry: &Geometry| {
            refine(&rows, &Chain::at(geometry.clone()), &spec.free, &spec.search, &watch)
        };
        let (given, [said, others]) = (at(&held, own)?, known.mounted());
        // A base mounted at some other angle is meant to be, and one torque alone tells no direction.
        let tau = self.motion.require_tau()?;
        let told = tau.col_iter().filter(|tau| spread(*tau) > 0.0).count() > 1;
        if said.is_empty() || !told {
            return Ok((held, given));
        }
        let others = others.par_iter().map(|other| at(&tilted, other));
        let others = others.collect::<Result<Vec<Chain>, ChainError>>()?;
        let other = others.into_iter().min_by(|a, b| left(a).total_cmp(&left(b)));
        let few = self.rows(&held, TRIAL_ROWS)?;
        let judged = |label: String, spec: ChainSpec, chain: Chain| {
            Ok::<Judged, IdentifyError>((trial(label, &spec, &few, &chain, &watch)?, spec, chain))
        };
        let mut ways: Vec<Judged> = vec![judged(AS_GIVEN.to_owned(), held, given)?];
        for chain in std::iter::once(at(&tilted, own)?).chain(other) {
            let is_said = known.is_as_said(&chain.geometry);
            let line = (!is_said).then(|| known.line_of_gravity(&chain.geometry));
            let label = line.unwrap_or_else(|| TILTED.to_owned());
            ways.push(judged(label, tilted.clone(), chain)?);
        }
        let trials: Vec<CvScore> = ways.iter().map(|(trial, ..)| trial.clone()).collect();
        let place = record_worth(LINE_OF_GRAVITY, &trials, WORTH_OF_TILT, choices);
        // Which way along a line elsewhere torque hardly tells: that is said, and not taken.
        let is_taken = known.is_as_said(&ways[place].2.geometry);
        let (_, spec, chain) = ways.swap_remove(if is_taken { place } else { 0 });
        Ok((spec, chain))
    }
}
