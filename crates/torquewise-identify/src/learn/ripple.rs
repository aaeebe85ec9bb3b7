//! Chain, rows → torque that is periodic in the angle of a joint: ripple of its gear, cogging of
//! its motor.

use super::School;
use super::left_over::{LeftOver, WORTH};
use crate::beside::{Beside, columns};
use crate::trial::{Recipe, record_worth};
use std::f64::consts::TAU;
use torquewise_model::model::Choice;
use torquewise_model::{EnergyTerm, Place, Term, Trig};
use torquewise_rigid::Chain;
use torquewise_survey::error::IdentifyError;

/// Periods in a turn of a joint that are looked for: below are gravity and counterbalances, beyond
/// what the angle of a term may be multiplied by.
const PERIODS: std::ops::RangeInclusive<i8> = 3..=127;
/// Harmonics of a joint at most.
const MOST: usize = 2;
/// A joint must turn so many periods of what is found in it.
const LEAST_PERIODS: f64 = 2.0;

impl School<'_> {
    /// Looks for ripple of each joint, at the periods that what is left of its torque has most of.
    pub(super) fn ripple(
        &self,
        recipe: &mut Recipe,
        chain: &Chain,
        choices: &mut Vec<Choice>,
    ) -> Result<(), IdentifyError> {
        let n = self.motion.n_joints();
        let left = LeftOver::of(self, recipe, chain)?;
        let mut now = self.error(recipe, &left)?;
        for joint in 0..n {
            let own = recipe.beside.iter().filter(|beside| beside.is_friction_of(joint));
            let mut laws: Vec<Beside> = own.cloned().collect();
            let friction = laws.len();
            let mut trials = Vec::new();
            for _ in 0..=MOST {
                let columns = &columns(&laws, &left.motion, recipe.gravity.as_ref())[joint];
                let label = format!("{} harmonics", (laws.len() - friction) / 2);
                let Some(trial) = left.trial(joint, label, columns) else { break };
                trials.push(trial);
                let Some(residual) = left.residual(joint, columns) else { break };
                let Some(period) = strongest(&left, joint, &residual) else { break };
                laws.extend(harmonic(n, joint, period));
            }
            let what = format!("ripple of {}", self.motion.joints()[joint]);
            let place = record_worth(&what, &trials, WORTH, choices);
            if place > 0 {
                let mut with = recipe.clone();
                with.beside.extend(laws.drain(friction..friction + 2 * place));
                self.agree((recipe, &mut now), with, &left)?;
            }
        }
        Ok(())
    }
}

/// Periods in a turn of the harmonic that explains most of a residual.
fn strongest(left: &LeftOver, joint: usize, residual: &[(f64, f64)]) -> Option<i8> {
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
fn harmonic(n_joints: usize, joint: usize, period: i8) -> impl Iterator<Item = Beside> {
    [Trig::Cos, Trig::Sin].into_iter().map(move |trig| {
        let function = Term::one(n_joints).times(trig, joint, period, 1);
        Beside::Energy(EnergyTerm { place: Place::Potential, function })
    })
}
