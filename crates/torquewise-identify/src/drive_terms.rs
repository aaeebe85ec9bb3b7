//! Columns of the drive terms: friction, rotors, springs.

use crate::States;
use crate::states::along;
use faer::Mat;
use serde::{Deserialize, Serialize};
use torquewise_model::{
    Direction, EnergyTerm, FrictionLaw, FrictionTerm, JointKind, Place, Term, Trig,
};
use torquewise_motion::Motion;
use torquewise_rigid::{Chain, ChainRows, Functions, Kinematics};
use torquewise_stepwise::IdentifyError;
use torquewise_stepwise::friction::FrictionLibrary;

/// A joint slower than so many half widths of the reversal of its friction is at rest: its friction
/// may be anything.
pub(crate) const AT_REST: f64 = 3.0;
/// What an equation of a joint at rest is multiplied by: only its gravity is informative (E8).
pub(crate) const WEIGHT_AT_REST: f64 = 0.1;
/// What its square counts where the arm is known and friction, or a payload, is fitted alone.
pub(crate) const SHARE_AT_REST: f64 = 0.1;

/// Something that loads joints in proportion to one coefficient.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) enum DriveTerm {
    /// Friction of a shaft (17).
    Friction(#[serde(with = "WholeFriction")] FrictionTerm),
    /// Inertia of a rotor on a shaft that turns with Σ shaft\[j\]·q̇ⱼ: T = ½ (Σ shaft\[j\]·q̇ⱼ)².
    Rotor(Vec<f64>),
    /// A term of V or M that no chain of rigid bodies has, such as a spring's.
    Energy(EnergyTerm),
}

impl DriveTerm {
    pub(crate) fn friction(terms: Vec<FrictionTerm>) -> impl Iterator<Item = Self> {
        terms.into_iter().map(Self::Friction)
    }

    /// Rotors of all joints, each on its own shaft.
    pub(crate) fn rotors(n_joints: usize) -> Vec<Self> {
        let unit = |joint| (0..n_joints).map(|j| f64::from(u8::from(j == joint))).collect();
        (0..n_joints).map(|joint| Self::Rotor(unit(joint))).collect()
    }

    /// Rotors, and dry and viscous friction, of all joints.
    pub(crate) fn usual(laws: &FrictionLibrary) -> Vec<Self> {
        let rotors = Self::rotors(laws.peak.len()).into_iter();
        rotors.chain(Self::friction(laws.linear())).collect()
    }

    /// A shaft that two joints turn together, as in a coupled wrist: its rotor and its friction.
    pub(crate) fn shared_shaft(shaft: &[f64], width: f64) -> Vec<Self> {
        let friction = |law| {
            let direction = Direction::Both;
            Self::Friction(FrictionTerm { shaft: shaft.to_vec(), law, direction, load: false })
        };
        vec![
            friction(FrictionLaw::Viscous),
            friction(FrictionLaw::Coulomb { width }),
            Self::Rotor(shaft.to_vec()),
        ]
    }

    /// A counterbalance of a joint: what a spring adds to V(q) that no mass does, since the masses
    /// that weigh are those that resist. Of a slide: a constant force and a spring.
    pub(crate) fn counterbalance(n_joints: usize, joint: usize, kind: JointKind) -> Vec<Self> {
        let functions = match kind.functions {
            Functions::Harmonics => {
                vec![(Trig::Cos, 1, 1), (Trig::Sin, 1, 1), (Trig::Cos, 2, 1), (Trig::Sin, 2, 1)]
            }
            Functions::Powers => vec![(Trig::Position, 1, 1), (Trig::Position, 1, 2)],
        };
        let spring = |(trig, multiple, power)| {
            let function = Term::one(n_joints).times(trig, joint, multiple, power);
            Self::Energy(EnergyTerm { place: Place::Potential, function })
        };
        functions.into_iter().map(spring).collect()
    }

    pub(crate) fn law(&self) -> Option<&FrictionTerm> {
        if let Self::Friction(term) = self { Some(term) } else { None }
    }

    /// The shaft that it brakes, if it is friction that is none at rest.
    pub(crate) fn resists(&self) -> Option<&[f64]> {
        self.law().filter(|term| term.law != FrictionLaw::Offset).map(|term| term.shaft.as_slice())
    }

    /// Whether it is friction that depends on the load of a gear.
    pub(crate) fn is_load_dependent(&self) -> bool {
        self.law().is_some_and(|term| term.load)
    }

    /// What it loads the joints with, per unit of its coefficient, states×n.
    pub(crate) fn loads(&self, states: &States) -> Mat<f64> {
        let (shaft, values) = match self {
            Self::Energy(term) => return states.loads(term, 1.0),
            Self::Friction(term) => (&term.shaft, states.friction(term)),
            Self::Rotor(shaft) => (shaft, along(shaft, &states.ddq)),
        };
        let mut loads = Mat::zeros(states.len(), shaft.len());
        for (joint, turns) in shaft.iter().enumerate().filter(|(_, turns)| **turns != 0.0) {
            let own = loads.col_as_slice_mut(joint).iter_mut().zip(&values);
            own.for_each(|(load, value)| *load = turns * value);
        }
        loads
    }

    pub(crate) fn n_joints(&self) -> usize {
        match self {
            Self::Friction(term) => term.shaft.len(),
            Self::Rotor(shaft) => shaft.len(),
            Self::Energy(term) => term.function.n_joints(),
        }
    }
}

/// What gravity and springs load the joints with, as far as it is known: gears press harder under
/// it.
#[derive(Clone, Debug)]
pub(crate) struct Gravity {
    kinematics: Kinematics,
    inertial: Vec<f64>,
    springs: Vec<(EnergyTerm, f64)>,
}

impl Gravity {
    /// - `drive`: what stands beside its links, in the order of their coefficients
    pub(crate) fn of(chain: &Chain, drive: &[DriveTerm]) -> Self {
        let springs = drive.iter().zip(&chain.drive).filter_map(|(drive, coefficient)| {
            let DriveTerm::Energy(term) = drive else { return None };
            (term.place == Place::Potential).then(|| (term.clone(), *coefficient))
        });
        Self {
            kinematics: Kinematics::new(&chain.geometry),
            inertial: chain.inertial.clone(),
            springs: springs.collect(),
        }
    }

    /// G(q) \[N·m\] at the rows of a motion, m×n.
    fn over(&self, motion: &Motion, states: &States) -> Mat<f64> {
        let mut gravity = Mat::zeros(motion.n_rows(), motion.n_joints());
        let rest = [Some(motion.q()), None, None];
        self.kinematics.torques(rest, &self.inertial, |row, joint, torque| {
            gravity[(row, joint)] = torque;
        });
        for (spring, coefficient) in &self.springs {
            gravity += states.loads(spring, *coefficient);
        }
        gravity
    }
}

/// Columns of what is beside the links over a motion, (m·n)×e, joint by joint.
///
/// - `gravity`: what friction under load is in proportion to
pub(crate) fn columns(drive: &[DriveTerm], motion: &Motion, gravity: Option<&Gravity>) -> Mat<f64> {
    let mut states = States::of(motion);
    if let (true, Some(gravity)) = (drive.iter().any(DriveTerm::is_load_dependent), gravity) {
        states.gravity = Some(gravity.over(motion, &states));
    }
    let m = motion.n_rows();
    let mut columns = Mat::zeros(m * motion.n_joints(), drive.len());
    for (drive, mut column) in drive.iter().zip(columns.col_iter_mut()) {
        for (joint, loads) in drive.loads(&states).col_iter().enumerate() {
            column.as_mut().subrows_mut(joint * m, m).copy_from(loads);
        }
    }
    columns
}

/// The rows of a motion for a chain.
///
/// - `drive`: columns of what is beside the links, as [`columns`] makes them
pub(crate) fn chain_rows(motion: &Motion, drive: Mat<f64>) -> Result<ChainRows, IdentifyError> {
    let signals = [motion.q(), motion.dq(), motion.ddq(), motion.require_tau()?];
    Ok(ChainRows::new(signals, drive)?)
}

/// A law of friction with all its fields: a model file leaves out the usual direction, which a
/// format without names cannot.
#[derive(Serialize, Deserialize)]
#[serde(remote = "FrictionTerm")]
struct WholeFriction {
    shaft: Vec<f64>,
    law: FrictionLaw,
    direction: Direction,
    load: bool,
}

/// Shafts that several joints turn, as they are with one of them turned round.
pub(crate) fn mirrored(drive: &[DriveTerm]) -> Vec<DriveTerm> {
    let mirror = |shaft: &[f64]| {
        let last = shaft.iter().rposition(|turn| *turn != 0.0)?;
        let mut mirrored = shaft.to_vec();
        mirrored[last] = -mirrored[last];
        (shaft.iter().filter(|turn| **turn != 0.0).count() > 1).then_some(mirrored)
    };
    let turned = |drive: &DriveTerm| match drive {
        DriveTerm::Rotor(shaft) => mirror(shaft).map(DriveTerm::Rotor),
        DriveTerm::Friction(term) => {
            let shaft = mirror(&term.shaft)?;
            Some(DriveTerm::Friction(FrictionTerm { shaft, ..term.clone() }))
        }
        DriveTerm::Energy(_) => None,
    };
    drive.iter().filter_map(turned).collect()
}

#[cfg(test)]
mod tests;
