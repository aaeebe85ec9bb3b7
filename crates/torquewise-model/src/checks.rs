//! Physical checks: M(q) positive definite, Ṁ − 2C skew, friction takes power.

use crate::{FrictionLaw, FrictionTerm, Model, ModelError, Torque, Weighted, number};
use faer::{Mat, Side};
use std::fmt;
use torquewise_motion::grouped;

/// What the checks found, the worst over the states looked at.
#[derive(Clone, Debug, PartialEq)]
pub struct Checks {
    /// States looked at.
    pub states: usize,
    /// Smallest eigenvalue of the symmetric part of M(q) \[kg·m²\]; positive for a real arm.
    pub smallest_eigenvalue: f64,
    /// Joint angles q \[rad\] of that eigenvalue, n; empty where no state was looked at.
    pub weakest_q: Vec<f64>,
    /// Largest ‖M − Mᵀ‖ / ‖M‖; zero for a real arm.
    pub asymmetry: f64,
    /// Largest |q̇ᵀ(Ṁq̇ − 2c)| / (‖q̇‖‖Ṁq̇‖ + 2‖q̇‖‖c‖), which is zero where Ṁ − 2C is skew: the
    /// power of the Coriolis torque is the change of kinetic energy that M accounts for.
    pub skew_defect: f64,
    /// Friction that drives its shaft, whatever the state; none for a real arm.
    pub driving: Option<DrivingFriction>,
}

/// Friction that drives its shaft at some speed, where any real one takes power.
#[derive(Clone, Debug, PartialEq)]
pub struct DrivingFriction {
    /// The shaft, as speed per speed of each joint, n.
    pub shaft: Vec<f64>,
    /// Its speed v \[rad/s\] where it is driven hardest.
    pub speed: f64,
    /// The power f(v)·v \[W\] that friction takes there, below zero.
    pub power: f64,
}

impl Checks {
    /// Relative asymmetry and defect from which on they are more than rounding.
    pub const TOLERANCE: f64 = 1e-6;

    /// Whether M is symmetric and positive definite and Ṁ − 2C skew at all states looked at.
    pub fn is_arm(&self) -> bool {
        self.smallest_eigenvalue > 0.0 && self.asymmetry.max(self.skew_defect) < Self::TOLERANCE
    }

    /// The same, and whether friction takes power.
    pub fn passed(&self) -> bool {
        self.is_arm() && self.driving.is_none()
    }
}

/// `friction of the shaft of joint 2 drives it with 0.3 W at −0.1 rad/s`.
impl fmt::Display for DrivingFriction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { shaft, speed, power } = self;
        let joints = shaft.iter().enumerate().filter(|(_, share)| **share != 0.0);
        let joints: Vec<String> = joints.map(|(joint, _)| format!("{}", joint + 1)).collect();
        let (joints, power) = (joints.join(" and "), number(-power));
        write!(
            f,
            "friction of the shaft of joint {joints} drives it with {power} W at {speed:.3} rad/s"
        )
    }
}

/// Step of the central difference for Ṁ: its error is h² ≈ 1e-10 beside ε/h ≈ 2e-11.
const STEP: f64 = 1e-5;

/// Checks a model at states (q \[rad\], dq \[rad/s\]), n each.
///
/// # Errors
/// [`ModelError::Shape`] if a state has another length than the model has joints.
pub fn check(model: &Model, states: &[(Vec<f64>, Vec<f64>)]) -> Result<Checks, ModelError> {
    let torque = Torque::new(model);
    let (smallest_eigenvalue, weakest_q) = weakest_state(model, states.iter().map(|(q, _)| q))?;
    let (mut asymmetry, mut defect) = (0.0_f64, 0.0_f64);
    for (q, dq) in states {
        let mass = torque.mass_matrix(q)?;
        let scale = mass.norm_l2().max(f64::MIN_POSITIVE);
        asymmetry = asymmetry.max((&mass - mass.transpose()).norm_l2() / scale);
        defect = defect.max(skew_defect(&torque, q, dq)?);
    }
    Ok(Checks {
        states: states.len(),
        smallest_eigenvalue,
        weakest_q,
        asymmetry,
        skew_defect: defect,
        driving: driving_friction(model),
    })
}

/// The smallest eigenvalue of M(q) \[kg·m²\] over states, and the q \[rad\] that has it: infinite
/// and empty where no state is given.
///
/// - `states`: joint angles q \[rad\], n each
///
/// # Errors
/// [`ModelError::Shape`] if a state has another length than the model has joints.
pub fn weakest_state<'q>(
    model: &Model,
    states: impl IntoIterator<Item = &'q Vec<f64>>,
) -> Result<(f64, Vec<f64>), ModelError> {
    let (torque, mut weakest) = (Torque::new(model), (f64::INFINITY, Vec::new()));
    for q in states {
        let eigenvalue = smallest_eigenvalue(&torque.mass_matrix(q)?);
        if eigenvalue < weakest.0 {
            weakest = (eigenvalue, q.clone());
        }
    }
    Ok(weakest)
}

/// Speeds looked at in each direction of a shaft, from near rest to its peak.
const SPEEDS: u32 = 2_000;
/// Peak of a joint \[rad/s\] whose training is not known.
const USUAL_PEAK: f64 = 1.0;

/// The friction that drives its shaft hardest, if any does: Σ f(v)·v < 0 over the laws of a shaft,
/// at a speed up to what the joints reached in training, in either direction; without load, and
/// what a load of 1 N·m adds.
///
/// Constant offsets are left aside: they are of the sensor or of a load, and drive one way.
pub fn driving_friction(model: &Model) -> Option<DrivingFriction> {
    let hardest = laws_of_shafts(model).into_iter().filter_map(|(places, peak)| {
        let laws: Vec<_> = places.into_iter().map(|place| &model.friction[place]).collect();
        let part = |k: u32| peak * f64::from(k) / f64::from(SPEEDS);
        let speeds = (1..=SPEEDS).flat_map(|k| [part(k), -part(k)]);
        let powers = speeds.map(|v| (v, power(&laws, v)));
        let (speed, power) = powers.min_by(|a, b| a.1.total_cmp(&b.1))?;
        let shaft = laws[0].term.shaft.clone();
        (power < 0.0).then_some(DrivingFriction { shaft, speed, power })
    });
    hardest.min_by(|a, b| a.power.total_cmp(&b.power))
}

/// What brakes each shaft, without load and under it: the places of its laws in the model, constant
/// offsets left aside, and the speed that it reached in training \[rad/s\].
pub fn laws_of_shafts(model: &Model) -> Vec<(Vec<usize>, f64)> {
    let alike = |a: &FrictionTerm, b: &FrictionTerm| (&a.shaft, a.load) == (&b.shaft, b.load);
    let term = |place: usize| &model.friction[place].term;
    let places = (0..model.friction.len()).filter(|&k| term(k).law != FrictionLaw::Offset);
    let shafts = grouped(places, |a, b| alike(term(*a), term(*b)));
    let peak = |shaft: &[f64]| -> f64 {
        let peaks = &model.training.dq_peak;
        let of = |(joint, share): (usize, &f64)| {
            share.abs() * peaks.get(joint).copied().unwrap_or(USUAL_PEAK)
        };
        shaft.iter().enumerate().map(of).sum()
    };
    let with_peak = |laws: Vec<usize>| {
        let peak = peak(&term(laws[0]).shaft);
        (laws, peak)
    };
    shafts.into_iter().map(with_peak).collect()
}

/// f(v)·v \[W\] of the laws of one shaft.
fn power(laws: &[&Weighted<FrictionTerm>], speed: f64) -> f64 {
    let loads = laws.iter().map(|law| law.coefficient * law.term.at_speed(speed));
    loads.sum::<f64>() * speed
}

/// Smallest eigenvalue of the symmetric part; −∞ where none can be computed.
fn smallest_eigenvalue(mass: &Mat<f64>) -> f64 {
    let symmetric = faer::Scale(0.5) * (mass + mass.transpose());
    symmetric
        .self_adjoint_eigenvalues(Side::Lower)
        .map_or(f64::NEG_INFINITY, |values| values.into_iter().fold(f64::INFINITY, f64::min))
}

fn skew_defect(torque: &Torque, q: &[f64], dq: &[f64]) -> Result<f64, ModelError> {
    let n = q.len();
    let moved = |h: f64| -> Vec<f64> { q.iter().zip(dq).map(|(q, dq)| q + h * dq).collect() };
    let (ahead, behind) = (torque.mass_matrix(&moved(STEP))?, torque.mass_matrix(&moved(-STEP))?);
    let coriolis = torque.coriolis(q, dq)?;

    let dot = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
    let m_dot_dq: Vec<f64> = (0..n)
        .map(|i| (0..n).map(|j| (ahead[(i, j)] - behind[(i, j)]) / (2.0 * STEP) * dq[j]).sum())
        .collect();
    let norm = |a: &[f64]| dot(a, a).sqrt();
    let scale = norm(dq) * (norm(&m_dot_dq) + 2.0 * norm(&coriolis));
    let power = (dot(dq, &m_dot_dq) - 2.0 * dot(dq, &coriolis)).abs();
    // Where M hardly changes, the rounding of its central difference is all there is of Ṁ.
    let rounding = 8.0 * f64::EPSILON / STEP * ahead.norm_l2() * dot(dq, dq);
    // An arm whose M is constant has no Coriolis torque: rounding must not be divided by rounding.
    Ok(if scale > 1e-9 { (power - rounding).max(0.0) / scale } else { 0.0 })
}
