//! Values of waves, monomials and columns, one block of rows at a time.

use crate::atom::{Monomial, Phase, Wave};
use crate::design::Design;
use crate::error::{SparseError, expect};
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
        let own = |x: &Mat<f64>| x.subrows(first, count).to_owned();
        Self {
            angles: own(&self.angles),
            variables: own(&self.variables),
            responses: own(&self.responses),
        }
    }

    /// Checks the block against a design.
    ///
    /// # Errors
    /// [`SparseError::Shape`] if the rows, angles or variables differ.
    pub fn check(&self, design: &Design) -> Result<(), SparseError> {
        expect("the angles of a block", self.angles.ncols(), design.n_angles)?;
        expect("the variables of a block", self.variables.ncols(), design.n_variables)?;
        expect("the rows of the variables", self.variables.nrows(), self.n_rows())?;
        expect("the rows of the responses", self.responses.nrows(), self.n_rows())
    }
}

/// How to evaluate a list of waves with one complex product each: e^{ik·θ} from the k without its
/// last angle, times a power of e^{iθⱼ}.
#[derive(Clone, Debug)]
pub(crate) struct WaveTree {
    /// (parent, angle, multiple) of each node; node 0 is k = 0.
    pub(crate) nodes: Vec<(usize, usize, i8)>,
    /// Place of the cosine and of the sine of each node among the waves asked for.
    places: Vec<[Option<usize>; 2]>,
    largest: Vec<i8>,
    /// Waves asked for.
    pub(crate) n_waves: usize,
}

impl WaveTree {
    /// Plans the evaluation of waves that are all different.
    pub(crate) fn new(waves: &[Wave]) -> Self {
        let n_angles = waves.first().map_or(0, |wave| wave.multiples().len());
        let mut known = BTreeMap::from([(vec![0; n_angles], 0)]);
        let (mut nodes, mut places) = (vec![(0, 0, 0)], vec![[None; 2]]);
        let mut largest = vec![0; n_angles];
        for (place, wave) in waves.iter().enumerate() {
            let (mut prefix, mut node) = (vec![0; n_angles], 0);
            for (angle, &k) in wave.multiples().iter().enumerate().filter(|&(_, &k)| k != 0) {
                prefix[angle] = k;
                largest[angle] = k.abs().max(largest[angle]);
                node = *known.entry(prefix.clone()).or_insert_with(|| {
                    nodes.push((node, angle, k));
                    places.push([None; 2]);
                    nodes.len() - 1
                });
            }
            places[node][usize::from(wave.phase() == Phase::Sin)] = Some(place);
        }
        Self { nodes, places, largest, n_waves: waves.len() }
    }

    /// Memory to evaluate up to `rows` rows at once.
    pub(crate) fn phasors(&self, rows: usize) -> Phasors {
        let many = |count: usize| vec![Phasor::one(rows); count];
        Phasors {
            powers: self.largest.iter().map(|&k| many(usize::from(k.unsigned_abs()))).collect(),
            nodes: many(self.nodes.len()),
        }
    }

    /// Writes the waves at some rows into the first rows of `out`, rows × waves.
    pub(crate) fn evaluate(
        &self,
        angles: &Mat<f64>,
        rows: &Range<usize>,
        phasors: &mut Phasors,
        out: &mut Mat<f64>,
    ) {
        let m = rows.len();
        for (angle, powers) in phasors.powers.iter_mut().enumerate() {
            raise(powers, &angles.col_as_slice(angle)[rows.clone()]);
        }
        for (node, &(parent, angle, k)) in self.nodes.iter().enumerate() {
            let (before, rest) = phasors.nodes.split_at_mut(node);
            if k != 0 {
                let turn = &phasors.powers[angle][usize::from(k.unsigned_abs()) - 1];
                rest[0].set_product(&before[parent], turn, f64::from(k.signum()));
            }
            for (place, values) in self.places[node].iter().zip([&rest[0].cos, &rest[0].sin]) {
                if let &Some(place) = place {
                    out.col_as_slice_mut(place)[..m].copy_from_slice(&values[..m]);
                }
            }
        }
    }
}

/// Memory of a [`WaveTree`], written over by each evaluation.
pub(crate) struct Phasors {
    /// e^{ikθⱼ} for k = 1, 2, … of each angle.
    powers: Vec<Vec<Phasor>>,
    nodes: Vec<Phasor>,
}

/// e^{iφ} at each row.
#[derive(Clone)]
struct Phasor {
    cos: Vec<f64>,
    sin: Vec<f64>,
}

/// e^{ikθ} for k = 1, 2, …: each the product of its two halves, so that roundings grow with log k.
fn raise(powers: &mut [Phasor], angle: &[f64]) {
    for place in 0..powers.len() {
        let (before, rest) = powers.split_at_mut(place);
        let half = place.div_ceil(2);
        if place == 0 {
            rest[0].set_turn(angle);
        } else {
            rest[0].set_product(&before[half - 1], &before[place - half], 1.0);
        }
    }
}

impl Phasor {
    fn one(rows: usize) -> Self {
        Self { cos: vec![1.0; rows], sin: vec![0.0; rows] }
    }

    /// e^{iθ}
    fn set_turn(&mut self, angle: &[f64]) {
        for ((cos, sin), &angle) in self.cos.iter_mut().zip(&mut self.sin).zip(angle) {
            (*sin, *cos) = angle.sin_cos();
        }
    }

    /// One phasor turned by another, or by its conjugate if `sign` is −1.
    fn set_product(&mut self, one: &Self, turn: &Self, sign: f64) {
        // As wide as this machine's registers; no sum is fused, so that bits are the same on all.
        Arch::new().dispatch(
            #[inline(always)]
            || {
                let parts = one.cos.iter().zip(&one.sin).zip(turn.cos.iter().zip(&turn.sin));
                let targets = self.cos.iter_mut().zip(&mut self.sin);
                for ((cos, sin), ((a, b), (c, s))) in targets.zip(parts) {
                    *cos = a * c - sign * b * s;
                    *sin = sign * a * s + b * c;
                }
            },
        );
    }
}

/// Writes the products of two columns.
pub(crate) fn multiply(out: &mut [f64], left: &[f64], right: &[f64]) {
    Arch::new().dispatch(
        #[inline(always)]
        || out.iter_mut().zip(left.iter().zip(right)).for_each(|(out, (a, b))| *out = a * b),
    );
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
            let (before, mut rest) = out.as_mut().split_at_col_mut(j);
            let known = |k: usize| before.as_ref().col(k).try_as_col_major();
            let column = rest.as_mut().col_mut(0).try_as_col_major_mut();
            if let (Some(column), Some(a), Some(b)) = (column, known(a), known(b)) {
                let m = rows.len();
                multiply(&mut column.as_slice_mut()[..m], &a.as_slice()[..m], &b.as_slice()[..m]);
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
        let rows = 0..samples.n_rows();
        let mut waves = Mat::zeros(rows.len(), self.tree.n_waves);
        self.tree.evaluate(&samples.angles, &rows, &mut self.tree.phasors(rows.len()), &mut waves);
        let mut monomials = Mat::zeros(rows.len(), self.design.monomials.len());
        let none = BTreeMap::new();
        monomial_values(&self.design.monomials, &none, &samples.variables, &rows, &mut monomials);
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
        (4 * self.tree.nodes.len() + self.design.monomials.len() + 2 * entries) as f64
    }
}
