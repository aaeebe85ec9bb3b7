//! M(q) and V(q) of a rigid chain as the sums of harmonics that they are (E4).

use crate::energy::{EnergyTerm, Place};
use crate::error::ModelError;
use crate::term::{Term, Trig};
use torquewise_rigid::{Geometry, Kinematics, Moved};

/// Joints of an arm whose energy can be listed: 5ⁿ⁻¹ states are looked at.
const MOST_JOINTS: usize = 8;
/// Coefficients below this part of the largest of their kind are rounding.
const ROUNDING: f64 = 1e-12;

/// Values of a function on a grid: the same number of evenly spaced angles for each joint.
struct Grid {
    /// Highest harmonic of each joint; 2·harmonics + 1 angles.
    harmonics: Vec<usize>,
    /// The last joint runs fastest.
    values: Vec<f64>,
}

/// Whether the energy of a chain of n joints can be listed, before work is done.
///
/// # Errors
/// [`ModelError::TooManyJoints`] above eight joints.
pub fn check_joints(n: usize) -> Result<(), ModelError> {
    let most = MOST_JOINTS;
    if n > most { Err(ModelError::TooManyJoints { joints: n, most }) } else { Ok(()) }
}

/// All energy terms of a chain with their coefficients, in the functions of the energy library.
///
/// M(q) and V(q) of a chain are sums of products over the joints of 1, cos kq and sin kq, k up to 2
/// and 1, and where a coordinate turns several joints up to as many times more; their values on an
/// even grid of angles give the coefficients exactly.
///
/// - `inertial`: inertial parameters of the bodies, 10 each
///
/// # Errors
/// [`ModelError::TooManyJoints`] above eight joints.
pub fn energy_terms(
    geometry: &Geometry,
    inertial: &[f64],
) -> Result<Vec<(EnergyTerm, f64)>, ModelError> {
    let n = geometry.n_joints();
    check_joints(n)?;
    let kinematics = Kinematics::new(geometry);
    let turns: Vec<usize> = (0..n).map(|joint| geometry.coupling().multiples_of(joint)).collect();
    let mut terms = potential_terms(&kinematics, inertial, turns.clone());
    terms.extend(inertia_terms(&kinematics, inertial, &turns));
    Ok(terms)
}

fn potential_terms(
    kinematics: &Kinematics,
    inertial: &[f64],
    harmonics: Vec<usize>,
) -> Vec<(EnergyTerm, f64)> {
    let grid = Grid::of(harmonics, |q| kinematics.potential_energy(q, inertial));
    let mut terms = Vec::new();
    grid.list(|function, coefficient| {
        // A constant of V is no torque.
        if !function.factors.is_empty() {
            terms.push((EnergyTerm { place: Place::Potential, function }, coefficient));
        }
    });
    terms
}

fn inertia_terms(
    kinematics: &Kinematics,
    inertial: &[f64],
    turns: &[usize],
) -> Vec<(EnergyTerm, f64)> {
    let n = kinematics.n_joints();
    // The first angle of a chain turns the whole arm: M does not depend on it.
    let own = |joint: usize| usize::from(joint > 0);
    let harmonics: Vec<usize> =
        turns.iter().enumerate().map(|(joint, turns)| 2 * (turns - 1 + own(joint))).collect();
    let mut moved = Moved::default();
    let mut columns: Vec<Vec<f64>> = vec![Vec::new(); n * n];
    for q in Grid::points(&harmonics) {
        kinematics.mass_matrix(&q, inertial, &mut moved, |i, j, value| {
            columns[i * n + j].push(value);
        });
    }
    let mut terms = Vec::new();
    for i in 0..n {
        for j in i..n {
            let values = std::mem::take(&mut columns[i * n + j]);
            let grid = Grid { harmonics: harmonics.clone(), values };
            grid.list(|function, coefficient| {
                let place = Place::Inertia(i, j);
                terms.push((EnergyTerm { place, function }, coefficient));
            });
        }
    }
    terms
}

impl Grid {
    fn of(harmonics: Vec<usize>, value: impl Fn(&[f64]) -> f64) -> Self {
        let values = Self::points(&harmonics).map(|q| value(&q)).collect();
        Self { harmonics, values }
    }

    /// The angles of every point, the last joint running fastest.
    fn points(harmonics: &[usize]) -> impl Iterator<Item = Vec<f64>> {
        let bases: Vec<usize> = harmonics.iter().map(|most| 2 * most + 1).collect();
        let count = bases.iter().product();
        (0..count).map(move |place| {
            let mut rest = place;
            let mut q = vec![0.0; bases.len()];
            for (angle, base) in q.iter_mut().zip(&bases).rev() {
                *angle = std::f64::consts::TAU / *base as f64 * (rest % base) as f64;
                rest /= base;
            }
            q
        })
    }

    /// Hands over each coefficient that is more than rounding, with its function.
    fn list(&self, mut put: impl FnMut(Term, f64)) {
        let coefficients = self.coefficients();
        let largest = coefficients.iter().fold(0.0_f64, |most, c| most.max(c.abs()));
        for (place, &coefficient) in coefficients.iter().enumerate() {
            if coefficient.abs() <= ROUNDING * largest {
                continue;
            }
            let mut rest = place;
            let mut digits = vec![0; self.harmonics.len()];
            for (digit, most) in digits.iter_mut().zip(&self.harmonics).rev() {
                let base = 2 * most + 1;
                (*digit, rest) = (rest % base, rest / base);
            }
            let mut function = Term::one(digits.len());
            for (joint, digit) in digits.into_iter().enumerate().filter(|(_, digit)| *digit > 0) {
                let trig = if digit % 2 == 1 { Trig::Cos } else { Trig::Sin };
                let multiple = i8::try_from(digit.div_ceil(2)).unwrap_or(i8::MAX);
                function = function.times(trig, joint, multiple, 1);
            }
            put(function, coefficient);
        }
    }

    /// Coefficients of 1, cos, sin, cos 2, sin 2 … of each joint, the last joint running fastest: a
    /// discrete Fourier transform along each joint.
    fn coefficients(&self) -> Vec<f64> {
        let mut values = self.values.clone();
        let mut stride = 1;
        for most in self.harmonics.iter().rev() {
            let base = 2 * most + 1;
            let transform = transform(base);
            let mut line = vec![0.0; base];
            for start in (0..values.len()).filter(|place| (place / stride) % base == 0) {
                for (k, out) in line.iter_mut().enumerate() {
                    *out = values[start + k * stride];
                }
                for (digit, row) in transform.iter().enumerate() {
                    values[start + digit * stride] =
                        row.iter().zip(&line).map(|(a, x)| a * x).sum();
                }
            }
            stride *= base;
        }
        values
    }
}

/// Rows of the real discrete Fourier transform of `base` points: 1, cos, sin, cos 2, sin 2 …
fn transform(base: usize) -> Vec<Vec<f64>> {
    let step = std::f64::consts::TAU / base as f64;
    (0..base)
        .map(|digit| {
            let harmonic = digit.div_ceil(2) as f64;
            (0..base)
                .map(|k| {
                    let angle = harmonic * step * k as f64;
                    let scale = if digit == 0 { 1.0 } else { 2.0 } / base as f64;
                    scale * if digit % 2 == 1 || digit == 0 { angle.cos() } else { angle.sin() }
                })
                .collect()
        })
        .collect()
}
