//! Values of waves, monomials and columns, one block of rows at a time.

use crate::atom::{Monomial, Phase, Wave};
use crate::{Design, Result, expect};
use faer::Mat;
use pulp::Arch;
use std::collections::BTreeMap;
use std::ops::Range;

/// A block of rows: θ (m×a), x (m×v) and responses y (m×r).
#[derive(Clone, Debug)]
pub struct Samples {
    /// Angles θ \[rad\], m×a.
    pub angles: Mat<f64>,
    /// Variables x, m×v.
    pub variables: Mat<f64>,
    /// Responses y, m×r.
    pub responses: Mat<f64>,
}

impl Samples {
    /// Number of rows m.
    pub fn n_rows(&self) -> usize {
        self.angles.nrows()
    }

    /// Some rows that follow each other.
    pub fn rows(&self, first: usize, count: usize) -> Self {
        let [angles, variables, responses] = [&self.angles, &self.variables, &self.responses]
            .map(|x| x.subrows(first, count).to_owned());
        Self { angles, variables, responses }
    }

    /// Checks the block against a design.
    ///
    /// # Errors
    /// [`SparseError::Shape`](crate::SparseError::Shape) if the rows, angles or variables differ.
    pub fn check(&self, design: &Design) -> Result<()> {
        expect("the angles of a block", self.angles.ncols(), design.n_angles)?;
        expect("the variables of a block", self.variables.ncols(), design.n_variables)?;
        expect("the rows of the variables", self.variables.nrows(), self.n_rows())?;
        expect("the rows of the responses", self.responses.nrows(), self.n_rows())
    }
}

/// e^{iφ} at each row.
#[derive(Clone)]
struct Phasor {
    cos: Vec<f64>,
    sin: Vec<f64>,
}

impl Phasor {
    fn one(rows: usize) -> Self {
        Self { cos: vec![1.0; rows], sin: vec![0.0; rows] }
    }

    /// e^{ikθ} for k = 1, 2, …, `most`: each the product of its two halves, so that roundings grow
    /// with log k.
    fn powers(angle: &[f64], most: usize) -> Vec<Self> {
        let (sin, cos) = angle.iter().map(|angle| angle.sin_cos()).unzip();
        let mut powers = vec![Self { cos, sin }];
        for place in 1..most {
            let half = place.div_ceil(2);
            let mut power = powers[half - 1].clone();
            power.turn(&powers[place - half], 1.0);
            powers.push(power);
        }
        powers
    }

    /// Turns it by another, or by its conjugate if `sign` is −1.
    fn turn(&mut self, other: &Self, sign: f64) {
        // As wide as this machine's registers; no sum is fused, so that bits are the same on all.
        Arch::new().dispatch(
            #[inline(always)]
            || {
                let targets = self.cos.iter_mut().zip(&mut self.sin);
                for ((cos, sin), (c, s)) in targets.zip(other.cos.iter().zip(&other.sin)) {
                    let (a, b) = (*cos, *sin);
                    *cos = a * c - sign * b * s;
                    *sin = sign * a * s + b * c;
                }
            },
        );
    }
}

/// Writes waves at some rows into the first rows of `out`, rows × waves: each a product of powers of
/// e^{iθⱼ}.
pub(crate) fn wave_values(
    waves: &[Wave],
    angles: &Mat<f64>,
    rows: &Range<usize>,
    out: &mut Mat<f64>,
) {
    let power_of = |angle: usize| {
        let multiples = waves.iter().map(|wave| wave.multiples()[angle].unsigned_abs());
        let most = multiples.max().unwrap_or(0).into();
        Phasor::powers(&angles.col_as_slice(angle)[rows.clone()], most)
    };
    let powers: Vec<Vec<Phasor>> = (0..angles.ncols()).map(power_of).collect();
    let (mut phasor, mut multiples) = (Phasor::one(rows.len()), &[][..]);
    for (j, wave) in waves.iter().enumerate() {
        if wave.multiples() != multiples {
            multiples = wave.multiples();
            phasor = Phasor::one(rows.len());
            for (angle, &k) in multiples.iter().enumerate().filter(|(_, k)| **k != 0) {
                let power = &powers[angle][usize::from(k.unsigned_abs()) - 1];
                phasor.turn(power, f64::from(k.signum()));
            }
        }
        let values = if wave.phase() == Phase::Cos { &phasor.cos } else { &phasor.sin };
        out.col_as_slice_mut(j)[..rows.len()].copy_from_slice(values);
    }
}

/// Multiplications per row that [`wave_values`] makes at most.
pub(crate) fn wave_cost(waves: &[Wave]) -> usize {
    let products = |wave: &Wave| wave.multiples().iter().filter(|k| **k != 0).count();
    4 * waves.iter().map(products).sum::<usize>()
}

/// Writes x^α at some rows into the first rows of `out`, rows × monomials.
///
/// - `products`: the monomials that are products of two earlier ones, and of which
pub(crate) fn monomial_values(
    monomials: &[Monomial],
    products: &BTreeMap<usize, (usize, usize)>,
    variables: &Mat<f64>,
    rows: &Range<usize>,
    out: &mut Mat<f64>,
) {
    for (j, monomial) in monomials.iter().enumerate() {
        if let Some(&(a, b)) = products.get(&j) {
            for row in 0..rows.len() {
                out[(row, j)] = out[(row, a)] * out[(row, b)];
            }
            continue;
        }
        let column = &mut out.col_as_slice_mut(j)[..rows.len()];
        column.fill(1.0);
        for (variable, &power) in monomial.powers.iter().enumerate() {
            let factor = &variables.col_as_slice(variable)[rows.clone()];
            for _ in 0..power {
                column.iter_mut().zip(factor).for_each(|(value, x)| *value *= x);
            }
        }
    }
}

impl Design {
    /// The columns of each equation at the rows of a block: one m×p matrix per equation.
    ///
    /// # Errors
    /// [`SparseError::Shape`](crate::SparseError::Shape) if the block does not fit the design.
    pub fn columns(&self, samples: &Samples) -> Result<Vec<Mat<f64>>> {
        samples.check(self)?;
        let rows = 0..samples.n_rows();
        let mut waves = Mat::zeros(rows.len(), self.waves.len());
        wave_values(&self.waves, &samples.angles, &rows, &mut waves);
        let mut monomials = Mat::zeros(rows.len(), self.monomials.len());
        let none = BTreeMap::new();
        monomial_values(&self.monomials, &none, &samples.variables, &rows, &mut monomials);
        let values_of = |columns: &Vec<Vec<(usize, f64)>>| {
            let mut values = Mat::zeros(rows.len(), columns.len());
            for (j, entries) in columns.iter().enumerate() {
                let out = values.col_as_slice_mut(j);
                for &(atom, weight) in entries {
                    let (wave, monomial) = self.atoms[atom];
                    let monomial = monomials.col_as_slice(monomial);
                    let factors = waves.col_as_slice(wave).iter().zip(monomial);
                    for (out, (a, b)) in out.iter_mut().zip(factors) {
                        *out += weight * a * b;
                    }
                }
            }
            values
        };
        Ok(self.equations.iter().map(values_of).collect())
    }

    /// Multiplications per row that [`Design::columns`] makes.
    pub(crate) fn cost(&self) -> f64 {
        let entries: usize = self.equations.iter().flatten().map(Vec::len).sum();
        (wave_cost(&self.waves) + self.monomials.len() + 2 * entries) as f64
    }
}
