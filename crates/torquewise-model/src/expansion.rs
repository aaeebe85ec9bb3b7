//! M(q) and V(q) of a rigid chain as the sums of harmonics that they are, and of powers of what slides
//! (E4) (E26).

use crate::{Drive, EnergyTerm, JointKind, ModelError, Place, RigidChain, Term, Trig};
use torquewise_rigid::recursion::{Lanes, N_LANES};
use torquewise_rigid::{Functions, Kinematics, Moved};

/// Joints of an arm whose energy can be listed: 5ⁿ⁻¹ states are looked at.
const MOST_JOINTS: usize = 8;
/// Coefficients below this part of the largest of their kind are rounding.
const ROUNDING: f64 = 1e-12;

/// What a function may be of one joint: 1, cos, sin, cos 2, sin 2 … where it turns, up to a harmonic; 1,
/// q, q² where it slides, up to a power, at most 2.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Basis {
    functions: Functions,
    degree: usize,
}

/// Values of a function on a grid: for each joint as many positions as it has functions.
struct Grid {
    bases: Vec<Basis>,
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

impl RigidChain {
    /// All energy terms of the chain with its drives, in the functions of the energy library; equal
    /// ones not yet joined.
    ///
    /// M(q) and V(q) of a chain are sums of products over the joints of 1, cos kq and sin kq, k up to
    /// 2 and 1, and where a coordinate turns several joints up to as many times more; of 1, q and q²,
    /// or 1 and q, of a joint that slides. Their values on a grid give the coefficients exactly.
    ///
    /// # Errors
    /// [`ModelError::TooManyJoints`] above eight joints.
    pub fn energy_terms(&self) -> Result<Vec<(EnergyTerm, f64)>, ModelError> {
        let mut terms = Vec::new();
        for (place, grid) in grids(self, |_| true)? {
            let coefficients = grid.coefficients();
            let largest = coefficients.iter().fold(0.0_f64, |most, c| most.max(c.abs()));
            let all = coefficients.into_iter().enumerate();
            for (at, coefficient) in all.filter(|(_, c)| c.abs() > ROUNDING * largest) {
                let function = grid.function_of(&digits(&grid.bases, at));
                // A constant of V is no torque.
                if place != Place::Potential || !function.factors.is_empty() {
                    terms.push((EnergyTerm { place, function }, coefficient));
                }
            }
        }
        terms.extend(self.drives.iter().flat_map(Drive::energy_terms));
        Ok(terms)
    }

    /// The coefficients that some of these terms have, without listing the others; 0 for a term that
    /// is none of them.
    ///
    /// # Errors
    /// As [`Self::energy_terms`].
    pub fn coefficients_of(&self, terms: &[EnergyTerm]) -> Result<Vec<f64>, ModelError> {
        let mut found = vec![0.0; terms.len()];
        for (place, grid) in grids(self, |place| terms.iter().any(|term| term.place == place))? {
            let coefficients = grid.coefficients();
            for (found, term) in found.iter_mut().zip(terms).filter(|(_, term)| term.place == place)
            {
                *found = grid.position_of(&term.function).map_or(0.0, |at| coefficients[at]);
            }
        }
        for (own, coefficient) in self.drives.iter().flat_map(Drive::energy_terms) {
            let same = found.iter_mut().zip(terms).filter(|(_, term)| **term == own);
            same.for_each(|(found, _)| *found += coefficient);
        }
        Ok(found)
    }
}

/// Values of V(q) and of each entry of M(q) that is asked for.
fn grids(
    chain: &RigidChain,
    wanted: impl Fn(Place) -> bool,
) -> Result<Vec<(Place, Grid)>, ModelError> {
    let (geometry, inertial) = (chain.axes()?, &chain.inertial());
    let n = geometry.n_joints();
    check_joints(n)?;
    let kinematics = Kinematics::new(&geometry);
    let rows: Vec<Vec<i8>> = (0..n).map(|joint| geometry.coupling().row(joint, n)).collect();
    // How often a coordinate turns joints from one on.
    let turns = |first: usize, own: usize| -> usize {
        rows[first..].iter().map(|row| usize::from(row[own].unsigned_abs())).sum()
    };
    // A joint that slides is not coupled: it moves those from one on once or never.
    let bases = |first: usize, degree: usize| -> Vec<Basis> {
        (0..n).map(|own| Basis::new(geometry.kinds().of(own), degree * turns(first, own))).collect()
    };
    let mut grids = Vec::new();
    if wanted(Place::Potential) {
        let bases = bases(0, 1);
        let values = Grid::points(&bases).map(|q| kinematics.potential_energy(&q, inertial));
        grids.push((Place::Potential, Grid { values: values.collect(), bases }));
    }
    let mut moved = Moved::default();
    for i in 0..n {
        let row: Vec<usize> = (i..n).filter(|&j| wanted(Place::Inertia(i, j))).collect();
        if row.is_empty() {
            continue;
        }
        // A joint moves all beyond it as they stand to each other, wherever it is itself.
        let (bases, mut values) = (bases(i + 1, 2), vec![Vec::new(); n]);
        for points in Grid::points(&bases).collect::<Vec<_>>().chunks(N_LANES) {
            let lanes = |joint: usize| {
                let point = |lane: usize| points[lane.min(points.len() - 1)][joint];
                Lanes::from(std::array::from_fn::<f64, N_LANES, _>(point))
            };
            let q: Vec<Lanes> = (0..n).map(lanes).collect();
            let keep = |row, j: usize, value| {
                if row == i {
                    values[j].extend_from_slice(&<[f64; N_LANES]>::from(value)[..points.len()]);
                }
            };
            kinematics.place_into(&q, &mut moved);
            moved.mass_matrix(inertial, keep);
        }
        grids.extend(row.into_iter().map(|j| {
            let values = std::mem::take(&mut values[j]);
            (Place::Inertia(i, j), Grid { bases: bases.clone(), values })
        }));
    }
    Ok(grids)
}

impl Grid {
    /// The positions of every point, the last joint running fastest.
    fn points(bases: &[Basis]) -> impl Iterator<Item = Vec<f64>> {
        let count = bases.iter().map(|basis| basis.size()).product();
        let point = move |place| bases.iter().zip(digits(bases, place)).map(|(b, k)| b.point(k));
        (0..count).map(move |place| point(place).collect())
    }

    /// Where the coefficient of a function stands, if it is one of those listed.
    fn position_of(&self, function: &Term) -> Option<usize> {
        let mut digits = vec![0; self.bases.len()];
        for factor in &function.factors {
            let joint = factor.multiples.iter().position(|k| *k > 0)?;
            let multiple = usize::try_from(factor.multiples[joint]).ok()?;
            digits[joint] = match factor.function {
                Trig::Sin => 2 * multiple,
                Trig::Cos => 2 * multiple - 1,
                Trig::Position => factor.power.into(),
            };
        }
        let is_listed = self.function_of(&digits) == *function
            && digits.iter().zip(&self.bases).all(|(digit, basis)| *digit < basis.size());
        let pairs = digits.iter().zip(&self.bases);
        let position = pairs.fold(0, |place, (digit, basis)| place * basis.size() + digit);
        is_listed.then_some(position)
    }

    /// Coefficients of the functions of each joint, the last joint running fastest: a discrete Fourier
    /// transform along each joint that turns, interpolation along one that slides.
    fn coefficients(&self) -> Vec<f64> {
        let mut values = self.values.clone();
        let mut stride = 1;
        for basis in self.bases.iter().rev() {
            let (base, transform) = (basis.size(), basis.transform());
            let mut line = vec![0.0; base];
            for block in values.chunks_mut(base * stride) {
                for start in 0..stride {
                    for (out, x) in line.iter_mut().zip(block[start..].iter().step_by(stride)) {
                        *out = *x;
                    }
                    let places = block[start..].iter_mut().step_by(stride);
                    for (out, row) in places.zip(&transform) {
                        *out = row.iter().zip(&line).map(|(a, x)| a * x).sum();
                    }
                }
            }
            stride *= base;
        }
        values
    }

    /// The product of one function of each joint.
    fn function_of(&self, digits: &[usize]) -> Term {
        let one = Term::one(digits.len());
        let factors = self.bases.iter().zip(digits).enumerate();
        factors.fold(one, |term, (joint, (basis, digit))| basis.factor(term, joint, *digit))
    }
}

/// Which function, or point, of each joint stands at a place of the grid.
fn digits(bases: &[Basis], mut place: usize) -> Vec<usize> {
    let mut digits = vec![0; bases.len()];
    for (digit, basis) in digits.iter_mut().zip(bases).rev() {
        (*digit, place) = (place % basis.size(), place / basis.size());
    }
    digits
}

impl Basis {
    /// The functions of a joint up to a degree.
    pub(crate) fn new(kind: JointKind, degree: usize) -> Self {
        Self { functions: kind.functions, degree }
    }

    /// How many functions it is of, as many as points.
    pub(crate) fn size(self) -> usize {
        if self.functions == Functions::Powers { self.degree + 1 } else { 2 * self.degree + 1 }
    }

    /// A point of the grid: even angles \[rad\], or a place beside 0 \[m\].
    fn point(self, k: usize) -> f64 {
        match self.functions {
            Functions::Harmonics => std::f64::consts::TAU / self.size() as f64 * k as f64,
            Functions::Powers => k as f64 - (self.degree / 2) as f64,
        }
    }

    /// A term times one of the functions.
    pub(crate) fn factor(self, term: Term, joint: usize, digit: usize) -> Term {
        if digit == 0 {
            return term;
        }
        let small = |k: usize| i8::try_from(k).unwrap_or(i8::MAX);
        match self.functions {
            Functions::Harmonics => {
                let trig = if digit % 2 == 1 { Trig::Cos } else { Trig::Sin };
                term.times(trig, joint, small(digit.div_ceil(2)), 1)
            }
            Functions::Powers => term.times(Trig::Position, joint, 1, small(digit).unsigned_abs()),
        }
    }

    /// From values at the points to the coefficients of the functions.
    fn transform(self) -> Vec<Vec<f64>> {
        let rows: &[&[f64]] = match (self.functions, self.degree) {
            (Functions::Harmonics, _) => return fourier(self.size()),
            (Functions::Powers, 0) => &[&[1.0]],
            (Functions::Powers, 1) => &[&[1.0, 0.0], &[-1.0, 1.0]],
            (Functions::Powers, _) => &[&[0.0, 1.0, 0.0], &[-0.5, 0.0, 0.5], &[0.5, -1.0, 0.5]],
        };
        rows.iter().map(|row| row.to_vec()).collect()
    }
}

/// Rows of the real discrete Fourier transform of `base` points: 1, cos, sin, cos 2, sin 2 …
fn fourier(base: usize) -> Vec<Vec<f64>> {
    let step = std::f64::consts::TAU / base as f64;
    let entry = |digit: usize, k: usize| {
        let angle = digit.div_ceil(2) as f64 * step * k as f64;
        let scale = if digit == 0 { 1.0 } else { 2.0 } / base as f64;
        scale * if digit % 2 == 1 || digit == 0 { angle.cos() } else { angle.sin() }
    };
    (0..base).map(|digit| (0..base).map(|k| entry(digit, k)).collect()).collect()
}
