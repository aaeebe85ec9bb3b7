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
    joints: usize,
    /// Highest harmonic; 2·harmonics + 1 angles a joint.
    harmonics: usize,
    /// The last joint runs fastest.
    values: Vec<f64>,
}

/// All energy terms of a chain with their coefficients, in the functions of the energy library.
///
/// M(q) and V(q) of a chain are sums of products over the joints of 1, cos kq and sin kq, k up to 2
/// and 1; their values on an even grid of angles give the coefficients exactly.
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
    if n > MOST_JOINTS {
        return Err(ModelError::TooManyJoints { joints: n, most: MOST_JOINTS });
    }
    let kinematics = Kinematics::new(geometry);
    let mut terms = potential_terms(&kinematics, inertial);
    terms.extend(inertia_terms(&kinematics, inertial));
    Ok(terms)
}

fn potential_terms(kinematics: &Kinematics, inertial: &[f64]) -> Vec<(EnergyTerm, f64)> {
    let n = kinematics.n_joints();
    let grid = Grid::of(n, 1, |q| kinematics.potential_energy(q, inertial));
    let mut terms = Vec::new();
    listed(&grid.coefficients(), n, n, 1, |function, coefficient| {
        // A constant of V is no torque.
        if !function.factors.is_empty() {
            terms.push((EnergyTerm { place: Place::Potential, function }, coefficient));
        }
    });
    terms
}

fn inertia_terms(kinematics: &Kinematics, inertial: &[f64]) -> Vec<(EnergyTerm, f64)> {
    // The first angle turns the whole arm: M does not depend on it.
    let n = kinematics.n_joints();
    let mut moved = Moved::default();
    let mut columns: Vec<Vec<f64>> = vec![Vec::new(); n * n];
    for angles in Grid::points(n - 1, 2) {
        let q: Vec<f64> = std::iter::once(0.0).chain(angles).collect();
        kinematics.mass_matrix(&q, inertial, &mut moved, |i, j, value| {
            columns[i * n + j].push(value);
        });
    }
    let mut terms = Vec::new();
    for i in 0..n {
        for j in i..n {
            let values = std::mem::take(&mut columns[i * n + j]);
            let grid = Grid { joints: n - 1, harmonics: 2, values };
            listed(&grid.coefficients(), n - 1, n, 2, |function, coefficient| {
                let place = Place::Inertia(i, j);
                terms.push((EnergyTerm { place, function }, coefficient));
            });
        }
    }
    terms
}

/// Hands over each coefficient that is more than rounding, with its function of the last `inner` of
/// `n` joints.
fn listed(
    coefficients: &[f64],
    inner: usize,
    n: usize,
    harmonics: usize,
    mut put: impl FnMut(Term, f64),
) {
    let base = 2 * harmonics + 1;
    let largest = coefficients.iter().fold(0.0_f64, |most, c| most.max(c.abs()));
    for (place, &coefficient) in coefficients.iter().enumerate() {
        if coefficient.abs() <= ROUNDING * largest {
            continue;
        }
        let mut function = Term::one(n);
        let mut rest = place;
        let mut digits = vec![0; inner];
        for digit in digits.iter_mut().rev() {
            (*digit, rest) = (rest % base, rest / base);
        }
        for (joint, digit) in digits.into_iter().enumerate().filter(|(_, digit)| *digit > 0) {
            let trig = if digit % 2 == 1 { Trig::Cos } else { Trig::Sin };
            let multiple = if digit <= 2 { 1 } else { 2 };
            function = function.times(trig, n - inner + joint, multiple, 1);
        }
        put(function, coefficient);
    }
}

impl Grid {
    fn of(joints: usize, harmonics: usize, value: impl Fn(&[f64]) -> f64) -> Self {
        let values = Self::points(joints, harmonics).map(|q| value(&q)).collect();
        Self { joints, harmonics, values }
    }

    /// The angles of every point, the last joint running fastest.
    fn points(joints: usize, harmonics: usize) -> impl Iterator<Item = Vec<f64>> {
        let base = 2 * harmonics + 1;
        let step = std::f64::consts::TAU / base as f64;
        let count = (0..joints).fold(1, |count, _| count * base);
        (0..count).map(move |place| {
            let mut rest = place;
            let mut q = vec![0.0; joints];
            for angle in q.iter_mut().rev() {
                *angle = step * (rest % base) as f64;
                rest /= base;
            }
            q
        })
    }

    /// Coefficients of 1, cos, sin, cos 2, sin 2 … of each joint, the last joint running fastest: a
    /// discrete Fourier transform along each joint.
    fn coefficients(&self) -> Vec<f64> {
        let base = 2 * self.harmonics + 1;
        let transform = transform(base);
        let mut values = self.values.clone();
        let mut stride = 1;
        let mut line = vec![0.0; base];
        for _ in 0..self.joints {
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
