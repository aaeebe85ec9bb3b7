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
    let mut terms = Vec::new();
    for (place, grid) in grids(geometry, inertial, |_| true)? {
        grid.list(|function, coefficient| {
            // A constant of V is no torque.
            if place != Place::Potential || !function.factors.is_empty() {
                terms.push((EnergyTerm { place, function }, coefficient));
            }
        });
    }
    Ok(terms)
}

/// What coefficients some of these terms have, 0 for a term that is none of them.
///
/// # Errors
/// As [`energy_terms`].
pub fn coefficients_of(
    wanted: &[EnergyTerm],
    geometry: &Geometry,
    inertial: &[f64],
) -> Result<Vec<f64>, ModelError> {
    let mut found = vec![0.0; wanted.len()];
    let places = |place: Place| wanted.iter().any(|term| term.place == place);
    for (place, grid) in grids(geometry, inertial, places)? {
        let coefficients = grid.coefficients();
        for (found, term) in found.iter_mut().zip(wanted).filter(|(_, term)| term.place == place) {
            *found = grid.position_of(&term.function).map_or(0.0, |at| coefficients[at]);
        }
    }
    Ok(found)
}

/// Values of V(q) and of each entry of M(q) that is asked for.
fn grids(
    geometry: &Geometry,
    inertial: &[f64],
    wanted: impl Fn(Place) -> bool,
) -> Result<Vec<(Place, Grid)>, ModelError> {
    let n = geometry.n_joints();
    check_joints(n)?;
    let kinematics = Kinematics::new(geometry);
    let turns: Vec<usize> = (0..n).map(|joint| geometry.coupling().multiples_of(joint)).collect();
    let mut grids = Vec::new();
    if wanted(Place::Potential) {
        let value = |q: &[f64]| kinematics.potential_energy(q, inertial);
        grids.push((Place::Potential, Grid::of(turns.clone(), value)));
    }
    // The first angle of a chain turns the whole arm: M does not depend on it.
    let own = |joint: usize| usize::from(joint > 0);
    let harmonics: Vec<usize> =
        turns.iter().enumerate().map(|(joint, turns)| 2 * (turns - 1 + own(joint))).collect();
    let first = grids.len();
    let mut places = vec![None; n * n];
    for (i, j) in (0..n).flat_map(|i| (i..n).map(move |j| (i, j))) {
        if wanted(Place::Inertia(i, j)) {
            places[i * n + j] = Some(grids.len());
            let grid = Grid { harmonics: harmonics.clone(), values: Vec::new() };
            grids.push((Place::Inertia(i, j), grid));
        }
    }
    if grids.len() > first {
        let mut moved = Moved::default();
        for q in Grid::points(&harmonics) {
            kinematics.mass_matrix(&q, inertial, &mut moved, |i, j, value| {
                if let Some(grid) = places[i * n + j] {
                    grids[grid].1.values.push(value);
                }
            });
        }
    }
    Ok(grids)
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
            put(function_of(&digits), coefficient);
        }
    }

    /// Where the coefficient of a function stands, if it is one of those listed.
    fn position_of(&self, function: &Term) -> Option<usize> {
        let mut digits = vec![0; self.harmonics.len()];
        for factor in &function.factors {
            let joint = factor.multiples.iter().position(|k| *k > 0)?;
            let multiple = usize::try_from(factor.multiples[joint]).ok()?;
            digits[joint] = 2 * multiple - usize::from(factor.function == Trig::Cos);
        }
        let is_listed = function_of(&digits) == *function
            && digits.iter().zip(&self.harmonics).all(|(digit, most)| *digit <= 2 * most);
        let bases = self.harmonics.iter().map(|most| 2 * most + 1);
        let position =
            digits.iter().zip(bases).fold(0, |place, (digit, base)| place * base + digit);
        is_listed.then_some(position)
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

/// The product of 1, cos, sin, cos 2, sin 2 … of each joint.
fn function_of(digits: &[usize]) -> Term {
    let mut function = Term::one(digits.len());
    for (joint, digit) in digits.iter().enumerate().filter(|(_, digit)| **digit > 0) {
        let trig = if digit % 2 == 1 { Trig::Cos } else { Trig::Sin };
        let multiple = i8::try_from(digit.div_ceil(2)).unwrap_or(i8::MAX);
        function = function.times(trig, joint, multiple, 1);
    }
    function
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
