//! From chain, rows to torque that is periodic in the angle of a joint: ripple of its gear, cogging
//! of its motor.

use super::ChainLearner;
use super::residual::{FrictionResidual, refuse};
use crate::chain_spec::{ChainSpec, record};
use crate::drive_terms::{DriveTerm, columns};
use std::f64::consts::TAU;
use torquewise_model::model::Choice;
use torquewise_model::{EnergyTerm, Place, Term, Trig};
use torquewise_rigid::Chain;
use torquewise_stepwise::error::IdentifyError;

/// Periods in a turn of a joint that are looked for: below are gravity and counterbalances, beyond
/// what the angle of a term may be multiplied by.
const PERIODS: std::ops::RangeInclusive<i8> = 3..=127;
/// Harmonics of a joint at most.
const MOST: usize = 2;
/// A harmonic must lower the error of its joint on held-out rows to this part: few joints have one.
const GAIN: f64 = 0.85;
/// A joint must turn so many periods of what is found in it.
const LEAST_PERIODS: f64 = 2.0;

impl ChainLearner<'_> {
    /// Looks for ripple of each joint, at the periods that what is left of its torque has most of.
    pub(super) fn ripple(
        &self,
        spec: &mut ChainSpec,
        chain: &Chain,
        choices: &mut Vec<Choice>,
    ) -> Result<(), IdentifyError> {
        let n = self.motion.n_joints();
        let left = FrictionResidual::of(self, spec, chain)?;
        let mut now = self.error(spec, &left)?;
        for joint in 0..n {
            let own = spec.drive.iter().filter(|drive| drive.is_friction_of(joint));
            let mut laws: Vec<DriveTerm> = own.cloned().collect();
            let friction = laws.len();
            let of = |laws: &[DriveTerm]| {
                let columns = columns(laws, &left.motion, spec.gravity.as_ref()).swap_remove(joint);
                let label = format!("{} harmonics", (laws.len() - friction) / 2);
                Some((left.trial(joint, label, &columns)?, columns))
            };
            let Some((trial, mut columns)) = of(&laws) else { continue };
            let mut trials = vec![trial];
            while trials.len() <= MOST {
                let residual = left.residual(joint, &columns);
                let period = residual.and_then(|residual| strongest(&left, joint, &residual));
                let Some(period) = period else { break };
                let with: Vec<DriveTerm> =
                    laws.iter().cloned().chain(harmonic(n, joint, period)).collect();
                let Some((trial, own)) = of(&with) else { break };
                if trials.last().is_some_and(|best| trial.error() > GAIN * best.error()) {
                    break;
                }
                trials.push(trial);
                (laws, columns) = (with, own);
            }
            if trials.len() > 1 {
                let what = format!("ripple of {}", self.motion.joints()[joint]);
                let place = record(&what, &trials, choices);
                let mut with = spec.clone();
                with.drive.extend(laws.drain(friction..friction + 2 * place));
                let agrees = self.agree((spec, &mut now), with, &left)?;
                if let (false, Some(choice)) = (agrees, choices.last_mut()) {
                    refuse(choice, "0 harmonics");
                }
            }
        }
        Ok(())
    }
}

/// Periods in a turn of the harmonic that explains most of a residual.
fn strongest(left: &FrictionResidual, joint: usize, residual: &[(f64, f64)]) -> Option<i8> {
    let q = left.motion.q().col(joint);
    let (low, high) = q.iter().fold((f64::MAX, f64::MIN), |(a, b), q| (a.min(*q), b.max(*q)));
    let power = |period: &i8| -> f64 {
        let sums = q.iter().zip(residual).fold([0.0; 2], |[a, b], (q, (residual, share))| {
            let (sin, cos) = (f64::from(*period) * q).sin_cos();
            [a + share * residual * sin, b + share * residual * cos]
        });
        sums[0].hypot(sums[1])
    };
    let turned = |period: &i8| f64::from(*period) * (high - low) >= LEAST_PERIODS * TAU;
    PERIODS.filter(turned).max_by(|a, b| power(a).total_cmp(&power(b)))
}

/// Torque with so many periods in a turn of a joint, of any phase.
fn harmonic(n_joints: usize, joint: usize, period: i8) -> impl Iterator<Item = DriveTerm> {
    [Trig::Cos, Trig::Sin].into_iter().map(move |trig| {
        let function = Term::one(n_joints).times(trig, joint, period, 1);
        DriveTerm::Energy(EnergyTerm { place: Place::Potential, function })
    })
}
