//! The nominal arm of the prior: plain links, positive rotors, dissipative friction (E14).

use super::linearisation::Linearisation;
use crate::DriveTerm;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use torquewise_model::{FrictionLaw, FrictionTerm};
use torquewise_motion::grouped;
use torquewise_motion::path::TRAVELS;
use torquewise_rigid::feasible::{Positive, Prior};
use torquewise_rigid::geometry::GRAVITY;
use torquewise_rigid::inertia::{Inertial, plain_link};
use torquewise_rigid::{JointKinds, PER_BODY};
use torquewise_stepwise::Survey;

/// Mass of a link over the cube of its length \[kg/m³\]: about that of robots of a few kilograms
/// to a few tons.
const DENSITY: f64 = 200.0;
/// Spread of the mass of a link, as a part of its length.
const SPREAD: f64 = 0.3;
/// Radius at which the mass of a link makes a usual rotor, after the gear, as a part of its length.
const ROTOR_RADIUS: f64 = 0.3;
/// Least length of a link \[m\].
const LEAST_LENGTH: f64 = 0.02;
/// Least speed that an arm is taken to reach \[rad/s\].
const LEAST_SPEED: f64 = 0.1;
/// Coefficients of either sign may well be so many times as large as the torque: a counterbalance
/// takes the place of most of it.
const LARGE: f64 = 10.0;
/// Usual friction as a part of the spread of the torque.
const USUAL_FRICTION: f64 = 0.05;
/// Speeds \[rad/s\] and torques \[N·m\] below this are none.
const LEAST_SIZE: f64 = 1e-9;
/// Speeds at which friction must take energy, as parts of the peak: four decades below it, in steps in
/// which no law changes by much, and far beyond.
const DECADES: i32 = 4;
const PER_DECADE: i32 = 20;
const FAST_SPEEDS: [f64; 2] = [1.2, 10.0];
/// What it takes there at least, as a part of what is usual: between two speeds it may be a little
/// less.
const LEAST_FRICTION: f64 = 0.02;

/// Usual sizes of an arm, read off its log.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Sizes {
    /// Standard deviation of the torque of each joint \[N·m\], n.
    pub(crate) torque: Vec<f64>,
    /// Peak speed of each joint \[rad/s\], n.
    pub(crate) speed: Vec<f64>,
}

impl Sizes {
    pub(crate) fn of(survey: &Survey) -> Self {
        Self { torque: survey.torque_std.clone(), speed: survey.dq_peak.clone() }
    }

    /// Length \[m\] and mass \[kg\] of a link of an arm that takes such torques: those that a link
    /// of the usual density makes by its weight, T = m g L with m = density · L³; of an arm that
    /// slides alone, F = m g.
    fn link(&self, kinds: &JointKinds) -> (f64, f64) {
        let n = self.torque.len();
        let turns = (0..n).any(|joint| kinds.of(joint).turns());
        let counted = (0..n).filter(|&joint| kinds.of(joint).turns() == turns);
        let torque = counted.fold(0.0_f64, |most, joint| most.max(self.torque[joint]));
        let power = if turns { 0.25 } else { 1.0 / 3.0 };
        let length = (torque / (DENSITY * GRAVITY)).powf(power).max(LEAST_LENGTH);
        (length, DENSITY * length.powi(3))
    }
}

/// Physical constraints on the parameters of a linearisation, and a feasible start.
pub(crate) fn prior(at: &Linearisation, sizes: &Sizes) -> (Prior, Vec<f64>) {
    let kinds = at.geometry.kinds();
    let (length, mass) = sizes.link(kinds);
    // Plain links between the axes.
    let placements = at.geometry.placements();
    let end = |k: usize| placements.get(k + 1).map_or_else(Vector3::zeros, |next| next.origin);
    let links = (0..placements.len()).map(|k| plain_link(mass, &end(k), SPREAD * length));
    let bodies: Vec<Inertial> = links.collect();
    let (drive, first) = (&at.drive, PER_BODY * bodies.len());
    let mut start = at.parameters();
    start[..first].copy_from_slice(bodies.as_flattened());
    let mut prior = Prior { bodies, ..Prior::default() };
    let rotor_of = |shaft: &[f64]| {
        // A slide feels its motor as a mass.
        let slides = shaft.iter().enumerate().any(|(joint, s)| *s != 0.0 && kinds.slides(joint));
        mass * if slides { 1.0 } else { (ROTOR_RADIUS * length).powi(2) }
    };
    for (k, term) in drive.iter().enumerate() {
        let index = first + k;
        match term {
            DriveTerm::Rotor(shaft) => {
                start[index] = rotor_of(shaft);
                prior.rotors.push((index, start[index]));
            }
            DriveTerm::Friction(term) => {
                let usual = USUAL_FRICTION * torque_of(term, sizes);
                prior.small.push((index, deviation(term, (sizes, kinds))));
                let of_element = usual / TRAVELS.len() as f64;
                if term.element().is_some() || term.load {
                    let (terms, nominal) = (vec![(index, 1.0)], of_element);
                    prior.positive.push(Positive { least: 0.0, terms, nominal, weight: 1.0 });
                }
                start[index] = match term.law {
                    FrictionLaw::Coulomb { .. } if term.direction.is_both() => usual,
                    FrictionLaw::Viscous if term.direction.is_both() => {
                        usual / speed_of(term, (sizes, kinds))
                    }
                    FrictionLaw::Dahl { .. } => of_element,
                    _ => 0.0,
                };
            }
            DriveTerm::Energy(_) => {
                let torque = sizes.torque.iter().fold(0.0_f64, |most, tau| most.max(*tau));
                prior.small.push((index, LARGE * or_one(torque)));
                start[index] = 0.0;
            }
        }
    }
    prior.positive.extend(passive(drive, first, (sizes, kinds)));
    (prior, start)
}

/// Sums of coefficients that are the friction of each shaft at a speed, times the direction: none
/// may be negative. An offset is a load and no friction. A joint that reverses goes through the dead
/// zone before an element that remembers its path has turned over: there the others are none
/// negative without it, or the arm would speed up by itself.
fn passive(
    drive: &[DriveTerm],
    first: usize,
    (sizes, kinds): (&Sizes, &JointKinds),
) -> Vec<Positive> {
    let laws = drive.iter().enumerate().filter_map(|(k, term)| Some((first + k, term.law()?)));
    let laws = laws.filter(|(_, term)| term.law != FrictionLaw::Offset);
    let shafts = grouped(laws, |(_, a), (_, b)| (&a.shaft, a.load) == (&b.shaft, b.load));
    let mut all = Vec::new();
    for own in shafts {
        let (_, any) = own[0];
        let (peak, usual) = (speed_of(any, (sizes, kinds)), USUAL_FRICTION * torque_of(any, sizes));
        let dead = own.iter().fold(0.0_f64, |most, (_, term)| most.max(term.law.width()));
        let part = |k: i32| 10.0_f64.powf(f64::from(k) / f64::from(PER_DECADE));
        let parts: Vec<f64> = (-DECADES * PER_DECADE..=0).map(part).chain(FAST_SPEEDS).collect();
        let at_speed = |speed: f64| -> Option<Positive> {
            let terms: Vec<(usize, f64)> = (own.iter())
                .filter(|(_, term)| speed.abs() > dead || term.element().is_none())
                .map(|(k, term)| (*k, speed.signum() * term.at_speed(speed)))
                .filter(|(_, weight)| *weight != 0.0)
                .collect();
            let weight = 1.0 / parts.len() as f64;
            // A smooth sign vanishes at rest, and what is usual with it.
            let size = terms.iter().fold(0.0_f64, |most, (_, weight)| most.max(weight.abs()));
            let nominal = usual * size.min(1.0);
            let least = LEAST_FRICTION * nominal;
            (size > 0.0).then_some(Positive { least, terms, nominal, weight })
        };
        for part in &parts {
            // Most laws are the same either way.
            match [part * peak, -part * peak].map(at_speed) {
                [Some(one), Some(other)] if one == other => {
                    all.push(Positive { weight: 2.0 * one.weight, ..one });
                }
                ways => all.extend(ways.into_iter().flatten()),
            }
        }
    }
    all
}

/// A size of the log, or 1 where it has none: a joint that never moves is like any other.
fn or_one(size: f64) -> f64 {
    if size > LEAST_SIZE { size } else { 1.0 }
}

/// Peak speed of the shaft of a term \[rad/s\]. A joint that hardly moves in a log will elsewhere:
/// it is taken to reach half the speed of the fastest of its kind.
fn speed_of(term: &FrictionTerm, (sizes, kinds): (&Sizes, &JointKinds)) -> f64 {
    let own = term.shaft.iter().position(|shaft| *shaft != 0.0).unwrap_or(0);
    let alike = (0..sizes.speed.len()).filter(|&joint| kinds.of(joint) == kinds.of(own));
    let fastest = alike.fold(LEAST_SPEED, |most, joint| most.max(sizes.speed[joint]));
    let parts = term.shaft.iter().zip(&sizes.speed).map(|(shaft, speed)| shaft.abs() * speed);
    or_one(parts.sum::<f64>().max(0.5 * fastest))
}

/// Torque \[N·m\] of a joint of the shaft of a term; under load, 1: coefficients are parts of it.
fn torque_of(term: &FrictionTerm, sizes: &Sizes) -> f64 {
    if term.load {
        return 1.0;
    }
    let turning = term.shaft.iter().zip(&sizes.torque).filter(|(shaft, _)| **shaft != 0.0);
    or_one(turning.fold(0.0_f64, |most, (_, torque)| most.max(*torque)))
}

/// How large a coefficient may well be.
fn deviation(term: &FrictionTerm, (sizes, kinds): (&Sizes, &JointKinds)) -> f64 {
    let torque = LARGE * torque_of(term, sizes);
    if term.law == FrictionLaw::Viscous { torque / speed_of(term, (sizes, kinds)) } else { torque }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn where_a_joint_reverses_what_remembers_its_path_lends_no_friction_to_other_laws() {
        let law = |law| DriveTerm::Friction(FrictionTerm::of_joint(1, 0, law));
        let laws = [FrictionLaw::Coulomb { width: 0.01 }, FrictionLaw::Dahl { travel: 0.01 }];
        let sizes = Sizes { torque: vec![10.0], speed: vec![1.0] };

        let sums = passive(&laws.map(law), 0, (&sizes, &JointKinds::default()));

        let allows = |x: [f64; 2]| {
            let of = |sum: &Positive| sum.terms.iter().map(|&(k, a)| a * x[k]).sum::<f64>();
            sums.iter().all(|sum| of(sum) > sum.least)
        };
        assert!(allows([0.1, 1.0]) && !allows([-0.1, 1.0]) && !allows([1.0, -1.1]));
    }
}
