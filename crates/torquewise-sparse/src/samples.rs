//! Rows → wave, monomial and column values: evaluating a design, one block of rows at a time.

use crate::atom::{Monomial, Phase, Wave};
use crate::design::Design;
use crate::error::SparseError;
use faer::{Mat, MatRef};
use std::collections::BTreeMap;

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

    /// Checks the block against a design.
    ///
    /// # Errors
    /// [`SparseError::Shape`] if the rows, angles or variables differ.
    pub fn check(&self, design: &Design) -> Result<(), SparseError> {
        let found = [
            ("the angles of a block", self.angles.ncols(), design.n_angles()),
            ("the variables of a block", self.variables.ncols(), design.n_variables()),
            ("the rows of the variables", self.variables.nrows(), self.n_rows()),
            ("the rows of the responses", self.responses.nrows(), self.n_rows()),
        ];
        match found.into_iter().find(|(_, found, expected)| found != expected) {
            Some((what, found, expected)) => Err(SparseError::Shape { what, found, expected }),
            None => Ok(()),
        }
    }
}

/// How to evaluate a list of waves with one complex product each: e^{ik·θ} from the k without its
/// last angle, times a power of e^{iθⱼ}.
#[derive(Clone, Debug)]
pub(crate) struct WaveTree {
    /// (parent, angle, multiple) of each node; node 0 is k = 0.
    nodes: Vec<(usize, usize, i8)>,
    /// (node, phase) of each wave asked for.
    waves: Vec<(usize, Phase)>,
    largest: Vec<i8>,
}

impl WaveTree {
    pub(crate) fn new(waves: &[Wave]) -> Self {
        let n_angles = waves.first().map_or(0, |wave| wave.multiples().len());
        let mut places = BTreeMap::from([(vec![0; n_angles], 0)]);
        let mut nodes = vec![(0, 0, 0)];
        let mut largest = vec![0; n_angles];
        let mut ends = Vec::with_capacity(waves.len());
        for wave in waves {
            let (mut prefix, mut node) = (vec![0; n_angles], 0);
            for (angle, &k) in wave.multiples().iter().enumerate().filter(|&(_, &k)| k != 0) {
                prefix[angle] = k;
                largest[angle] = k.abs().max(largest[angle]);
                node = *places.entry(prefix.clone()).or_insert_with(|| {
                    nodes.push((node, angle, k));
                    nodes.len() - 1
                });
            }
            ends.push((node, wave.phase()));
        }
        Self { nodes, waves: ends, largest }
    }

    /// Number of complex products per row.
    pub(crate) fn n_nodes(&self) -> usize {
        self.nodes.len()
    }

    /// The waves at each row, m × waves.
    pub(crate) fn evaluate(&self, angles: MatRef<'_, f64>) -> Mat<f64> {
        let m = angles.nrows();
        let powers: Vec<Vec<Phasor>> = (0..angles.ncols().min(self.largest.len()))
            .map(|j| (1..=self.largest[j]).map(|k| Phasor::turn(angles, j, k)).collect())
            .collect();
        let mut phasors = vec![Phasor { cos: vec![1.0; m], sin: vec![0.0; m] }];
        for &(parent, angle, k) in &self.nodes[1..] {
            let turn = &powers[angle][usize::from(k.unsigned_abs()) - 1];
            phasors.push(phasors[parent].times(turn, f64::from(k.signum())));
        }
        let mut out = Mat::zeros(m, self.waves.len());
        for (j, &(node, phase)) in self.waves.iter().enumerate() {
            let Phasor { cos, sin } = &phasors[node];
            out.col_as_slice_mut(j).copy_from_slice(if phase == Phase::Cos { cos } else { sin });
        }
        out
    }
}

/// e^{iφ} at each row.
struct Phasor {
    cos: Vec<f64>,
    sin: Vec<f64>,
}

impl Phasor {
    /// e^{ikθⱼ}
    fn turn(angles: MatRef<'_, f64>, j: usize, k: i8) -> Self {
        let (sin, cos) =
            (0..angles.nrows()).map(|row| (f64::from(k) * angles[(row, j)]).sin_cos()).unzip();
        Self { cos, sin }
    }

    /// This phasor turned by another, or by its conjugate if `sign` is −1.
    fn times(&self, turn: &Self, sign: f64) -> Self {
        let parts = || self.cos.iter().zip(&self.sin).zip(turn.cos.iter().zip(&turn.sin));
        Self {
            cos: parts().map(|((a, b), (c, s))| a * c - sign * b * s).collect(),
            sin: parts().map(|((a, b), (c, s))| sign * a * s + b * c).collect(),
        }
    }
}

/// x^α at each row, m × monomials.
pub(crate) fn monomial_values(monomials: &[Monomial], variables: MatRef<'_, f64>) -> Mat<f64> {
    let mut out = Mat::<f64>::ones(variables.nrows(), monomials.len());
    for (j, monomial) in monomials.iter().enumerate() {
        let column = out.col_as_slice_mut(j);
        for (variable, &power) in monomial.powers().iter().enumerate() {
            for _ in 0..power {
                multiply(column, variables, variable);
            }
        }
    }
    out
}

fn multiply(column: &mut [f64], variables: MatRef<'_, f64>, variable: usize) {
    for (row, value) in column.iter_mut().enumerate() {
        *value *= variables[(row, variable)];
    }
}

/// Evaluates the columns of a design on blocks of rows.
#[derive(Clone, Debug)]
pub struct Evaluator {
    design: Design,
    tree: WaveTree,
}

impl Evaluator {
    /// Prepares the evaluation of a design.
    pub fn new(design: Design) -> Self {
        let tree = WaveTree::new(&design.waves);
        Self { design, tree }
    }

    /// The design evaluated.
    pub fn design(&self) -> &Design {
        &self.design
    }

    /// The columns of each equation at the rows of a block: one m×p matrix per equation.
    ///
    /// # Errors
    /// [`SparseError::Shape`] if the block does not fit the design.
    pub fn columns(&self, samples: &Samples) -> Result<Vec<Mat<f64>>, SparseError> {
        samples.check(&self.design)?;
        let waves = self.tree.evaluate(samples.angles.as_ref());
        let monomials = monomial_values(&self.design.monomials, samples.variables.as_ref());
        let mut matrices = Vec::with_capacity(self.design.n_equations());
        for columns in &self.design.equations {
            let mut values = Mat::zeros(samples.n_rows(), columns.len());
            for (j, entries) in columns.iter().enumerate() {
                let out = values.col_as_slice_mut(j);
                for &(atom, weight) in entries {
                    let (wave, monomial) = self.design.atoms[atom];
                    let factors =
                        waves.col_as_slice(wave).iter().zip(monomials.col_as_slice(monomial));
                    for (out, (a, b)) in out.iter_mut().zip(factors) {
                        *out += weight * a * b;
                    }
                }
            }
            matrices.push(values);
        }
        Ok(matrices)
    }

    /// Multiplications per row that [`Evaluator::columns`] makes.
    pub fn cost(&self) -> f64 {
        let entries: usize = self.design.equations.iter().flatten().map(Vec::len).sum();
        (4 * self.tree.n_nodes() + self.design.monomials.len() + 2 * entries) as f64
    }
}
