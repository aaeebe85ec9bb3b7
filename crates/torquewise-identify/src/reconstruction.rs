//! The result of a fit: what was found, how, and the warnings.

use crate::clipped::clipped;
use crate::excitation::{LEAST_RANGE, commanded_by};
use crate::few_rows::{at_a_glance, left_by_axes, swapped};
use crate::library_errors::held_out_rms;
use crate::residual_shape::shapes;
use crate::rough::doubtful;
use crate::score::JointScore;
use crate::torque_kind::has_gravity;
use crate::torque_sign::SignTest;
use crate::verdict::{grave, unheld};
use crate::{Linearisation, Warning, geometric_mean, score, weightless};
use torquewise_model::{Model, RigidChain, Torque, Training};
use torquewise_stepwise::fit::{Dropped, LibraryFit};
use torquewise_stepwise::{IdentifyError, NoiseFloor, Patterns, Survey, thinned};

pub use torquewise_stepwise::fit::StepReport;
pub use torquewise_stepwise::progress::{Progress, Watch};

/// What was found, and how.
#[derive(Clone, Debug)]
pub struct Reconstruction {
    /// The equations of motion.
    pub model: Model,
    /// Summary of the log: ranges, noise, sample.
    pub survey: Survey,
    /// The patterns its rows fall into.
    pub patterns: Patterns,
    /// The white noise in its signals, from standstill where there is one.
    pub noise: NoiseFloor,
    /// Candidates in all.
    pub candidates: usize,
    /// The steps taken.
    pub steps: Vec<StepReport>,
    /// Terms that did not stay though resampled logs kept them, the likeliest first.
    pub dropped: Vec<Dropped>,
    /// Warnings.
    pub warnings: Vec<Warning>,
}

/// Rows that the inertia of a joint is looked at on.
const INERTIA_ROWS: usize = 100;
/// Part of the spread of a torque.
const MUCH: f64 = 0.2;
/// A torque that is missed by less than this part is not cut off, and what holds it not worth a word.
const LITTLE: f64 = 0.05;
/// Beside a joint whose torque shows no friction of its own, one that is missed by more than this part
/// may be of the wrong sign too; of so many joints at most all signs are tried.
const LOST: f64 = 0.5;
const MOST_IN_DOUBT: usize = 8;
/// Given axes are in doubt where others leave so many times less.
const FAR_LESS: f64 = 2.0;

impl Reconstruction {
    /// Result of the steps on a library, with warnings.
    pub(crate) fn of_library(
        survey: Survey,
        fit: LibraryFit,
        seed: u64,
        watch: Watch<'_>,
    ) -> Result<Self, IdentifyError> {
        let warnings = Warning::of_library(&survey, &fit);
        let LibraryFit { mut model, patterns, noise, candidates, steps, dropped, .. } = fit;
        [model.training.held_out_rms, model.training.held_out_by_region_rms] =
            held_out_rms(&model, &survey.sample)?;
        let mut found =
            Self { model, survey, patterns, noise, candidates, steps, dropped, warnings };
        if !has_gravity(&found.model) {
            let kind = weightless(&found.survey, seed, watch);
            found.warnings.extend(kind);
        }
        found.doubt_torque(seed, watch, |Survey { sample, dq_peak, .. }| {
            Ok(SignTest::at(&at_a_glance((sample, dq_peak), seed, watch)?, false))
        })?;
        Ok(found)
    }

    /// Where a model misses much of a torque, or turns out to be of negative inertia, looks whether
    /// the torque was cut off, or a motor wired the wrong way round.
    ///
    /// - `chain`: of the arm, as far as it is known
    pub(crate) fn doubt_torque(
        &mut self,
        seed: u64,
        watch: Watch<'_>,
        chain: impl FnOnce(&Survey) -> Result<SignTest, IdentifyError>,
    ) -> Result<(), IdentifyError> {
        self.note_rest_and_commands()?;
        let training = &self.model.training;
        let left = training.residual_rms.iter().zip(&training.torque_std).zip(&self.survey.joints);
        let left = left.map(|((rms, std), joint)| unheld(&self.warnings, joint, rms / std));
        let left: Vec<f64> = left.collect();
        let beyond = |part: f64| -> Vec<usize> {
            (0..left.len()).filter(|&joint| left[joint] > part).collect()
        };
        let missed = beyond(MUCH);
        let clipped: Vec<(usize, f64)> = (beyond(LITTLE).into_iter())
            .filter_map(|joint| Some((joint, clipped(&self.survey.sample, joint)?)))
            .collect();
        let is_clipped = clipped.iter().any(|(joint, _)| missed.contains(joint));
        self.warnings.extend(clipped.into_iter().map(|(joint, share)| Warning::Clipped {
            joint: self.survey.joints[joint].clone(),
            share,
        }));
        if is_clipped || missed.is_empty() && !self.has_negative_inertia()? {
            return Ok(());
        }
        // What shows the friction of its own shaft is that joint's torque; of a joint that hardly moves
        // no torque is told.
        let ranges: Vec<f64> =
            (0..self.survey.joints.len()).map(|joint| self.survey.range(joint)).collect();
        let moves = |joint: &usize| ranges[*joint] >= LEAST_RANGE;
        let mut doubtful = doubtful(&self.survey.sample);
        doubtful.retain(moves);
        if let Ok(Some(pair)) = swapped(&self.survey.sample, (&missed, &doubtful), seed, watch) {
            let joints = pair.map(|joint| self.survey.joints[joint].clone());
            self.accuse(Warning::Swapped { joints });
            return Ok(());
        }
        if !doubtful.is_empty() {
            // An arm of which no chain is found, for rows or joints, has nothing to compare with.
            let Ok(chain) = chain(&self.survey) else { return Ok(()) };
            let is_lost = |joint: &usize| moves(joint) && !doubtful.contains(joint);
            let lost = beyond(LOST).into_iter().filter(is_lost);
            let in_doubt: Vec<usize> =
                doubtful.iter().copied().chain(lost).take(MOST_IN_DOUBT).collect();
            let wrong = chain.wrong_signs(&self.survey, &in_doubt, watch)?;
            // Of joints that always move together none is told from the others.
            let is_tied = |own: &Warning| matches!(own, Warning::Together { .. });
            let is_told =
                !self.warnings.iter().any(is_tied) || wrong.len() == self.survey.joints.len();
            if is_told && !wrong.is_empty() {
                let name = |joint: usize| self.survey.joints[joint].clone();
                let joints = wrong.into_iter().map(name).collect();
                self.accuse(Warning::WrongSign { joints });
            }
        }
        let is_doubted = self.warnings.iter().any(|own| matches!(own, Warning::Axes { .. }));
        if !is_doubted && grave(&self.warnings).is_empty() {
            let missed: Vec<usize> = missed.into_iter().filter(moves).collect();
            self.warnings.extend(shapes(&self.model, &self.survey.sample, &missed)?);
        }
        Ok(())
    }

    /// Notes what friction may hold at rest, and doubts torques that are commands.
    fn note_rest_and_commands(&mut self) -> Result<(), IdentifyError> {
        let joints = score(&self.model, &self.survey.sample)?.joints.into_iter();
        let missed = joints.filter(|joint| joint.rmse > LITTLE * joint.std);
        let part = |joint: JointScore| joint.held_rms().map(|held| (joint.name, held / joint.std));
        let held: Vec<(String, f64)> = missed.filter_map(part).collect();
        self.warnings.extend((!held.is_empty()).then_some(Warning::Held { joints: held }));
        let is_commanded = |own: &Warning| matches!(own, Warning::Commanded { .. });
        if !self.warnings.iter().any(is_commanded) {
            self.warnings.extend(commanded_by(&self.survey, &self.model)?);
        }
        if self.warnings.iter().any(is_commanded) {
            // What is but gravity is not without it.
            self.warnings.retain(|own| *own != Warning::Weightless);
        }
        Ok(())
    }

    /// An arm that is looked for, where it leaves far less of the torque than the axes that were given,
    /// however gravity and coordinates are read: what was said of these is then taken back.
    ///
    /// - `read`: what such a reading leaves of held-out torque, where one is better than none
    pub(crate) fn doubt_axes(
        &mut self,
        read: Option<f64>,
        seed: u64,
        watch: Watch<'_>,
    ) -> Option<Linearisation> {
        let Training { residual_rms, torque_std, .. } = &self.model.training;
        let parts = |rms: &[f64]| -> Vec<f64> {
            let parts = rms.iter().zip(torque_std).filter(|(_, std)| **std > 0.0);
            parts.map(|(rms, std)| rms / std).collect()
        };
        let is_simple = |chain: &&RigidChain| chain.kinds.all_turn() && chain.coupling.is_none();
        let chain = self.model.chain.as_ref().filter(is_simple)?;
        let is_missed = parts(residual_rms).iter().any(|part| *part > MUCH);
        if !is_missed || !grave(&self.warnings).is_empty() {
            return None;
        }
        let Survey { sample, dq_peak, .. } = &self.survey;
        let given = left_by_axes((sample, dq_peak), &chain.axes().ok()?, watch).ok()?;
        let at = at_a_glance((sample, dq_peak), seed, watch).ok()?;
        let found: Vec<f64> = at.weights.iter().map(|weight| 1.0 / weight).collect();
        let [given, found] = [given, found].map(|rms| geometric_mean(&parts(&rms)));
        let ratio = read.map_or(given, |read| read.min(given)) / found;
        if ratio <= FAR_LESS {
            return None;
        }
        let is_of_urdf =
            |own: &Warning| matches!(own, Warning::Gravity { .. } | Warning::Coordinates { .. });
        self.warnings.retain(|own| !is_of_urdf(own));
        self.warnings.push(Warning::Axes { ratio });
        Some(at)
    }

    /// Names torques that are not those of their joints: what they seemed to be worth is no gain, and
    /// axes that explain them are not the arm's.
    fn accuse(&mut self, torques: Warning) {
        self.warnings.retain(|own| !matches!(own, Warning::Gains { .. } | Warning::Axes { .. }));
        self.warnings.push(torques);
    }

    /// Whether a joint of the model has negative inertia on the mean of its motion.
    fn has_negative_inertia(&self) -> Result<bool, IdentifyError> {
        let motion = thinned(&self.survey.sample, INERTIA_ROWS);
        let torque = Torque::new(&self.model);
        let mut inertia = vec![0.0; motion.n_joints()];
        for row in 0..motion.n_rows() {
            let q: Vec<f64> = motion.q().row(row).iter().copied().collect();
            let mass = torque.mass_matrix(&q)?;
            inertia.iter_mut().enumerate().for_each(|(joint, sum)| *sum += mass[(joint, joint)]);
        }
        Ok(inertia.iter().any(|sum| *sum < 0.0))
    }
}
