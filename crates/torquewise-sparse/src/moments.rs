//! Samples → moments: Σₜ wave(θₜ)·x(t)^α, from which the Gram matrix of any library follows [E3].

use crate::atom::{Monomial, Numbering, Wave};
use crate::design::Design;
use crate::error::SparseError;
use crate::samples::{Samples, WaveTree, monomial_values};
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, Par};

/// Which moments a design needs, and where each stands in the table.
#[derive(Clone, Debug)]
pub struct MomentPlan {
    design: Design,
    /// All waves in products of two waves of the design.
    closure: WaveTree,
    /// The waves of the design themselves.
    own: WaveTree,
    products: Vec<Monomial>,
    /// ½·sign and row of the two waves of each product of waves, a ≤ b, packed.
    wave_pairs: Vec<[(f64, usize); 2]>,
    /// Column of each product of two monomials.
    monomial_pairs: Vec<usize>,
    n_closure: usize,
}

impl MomentPlan {
    /// Lists the products that the Gram matrix of a design is made of.
    pub fn new(design: &Design) -> Self {
        let (mut waves, mut monomials) = (Numbering::new(), Numbering::new());
        let mut wave_pairs = Vec::with_capacity(packed(0, design.waves.len()));
        for (b, right) in design.waves.iter().enumerate() {
            for left in &design.waves[..=b] {
                wave_pairs.push(left.product(right).map(|term| match term {
                    Some((sign, wave)) => (0.5 * sign, waves.place(&wave)),
                    None => (0.0, 0),
                }));
            }
        }
        let mut monomial_pairs = Vec::with_capacity(design.monomials.len().pow(2));
        for a in &design.monomials {
            monomial_pairs.extend(design.monomials.iter().map(|b| monomials.place(&a.product(b))));
        }
        let waves: Vec<Wave> = waves.into_values();
        Self {
            design: design.clone(),
            closure: WaveTree::new(&waves),
            own: WaveTree::new(&design.waves),
            products: monomials.into_values(),
            wave_pairs,
            monomial_pairs,
            n_closure: waves.len(),
        }
    }

    /// The design these moments serve.
    pub fn design(&self) -> &Design {
        &self.design
    }

    /// Multiplications per row with `n_responses` responses: harmonics, then two products of
    /// matrices.
    pub fn cost(&self, n_responses: usize) -> f64 {
        let (w, a) = (self.design.waves.len(), self.design.monomials.len());
        (4 * (self.closure.n_nodes() + self.own.n_nodes())
            + self.n_closure * self.products.len()
            + w * a * n_responses) as f64
    }

    /// Entries of the moment table, 8 bytes each.
    pub fn size(&self, n_responses: usize) -> usize {
        let (w, a) = (self.design.waves.len(), self.design.monomials.len());
        self.n_closure * self.products.len() + w * a * n_responses
    }

    /// An empty table.
    pub fn start(&self, n_responses: usize) -> Moments {
        let (w, a) = (self.design.waves.len(), self.design.monomials.len());
        Moments {
            table: Mat::zeros(self.products.len(), self.n_closure),
            cross: Mat::zeros(w, a * n_responses),
            energy: vec![0.0; n_responses],
            rows: 0,
        }
    }

    /// Adds a block of rows to a table.
    ///
    /// # Errors
    /// [`SparseError::Shape`] if the block does not fit.
    pub fn accumulate(&self, moments: &mut Moments, samples: &Samples) -> Result<(), SparseError> {
        samples.check(&self.design)?;
        moments.check_responses(samples.responses.ncols())?;
        let waves = self.closure.evaluate(samples.angles.as_ref());
        let products = monomial_values(&self.products, samples.variables.as_ref());
        add_product(&mut moments.table, &products, &waves);

        let own = self.own.evaluate(samples.angles.as_ref());
        let monomials = monomial_values(&self.design.monomials, samples.variables.as_ref());
        let n_monomials = monomials.ncols();
        let weighted = Mat::from_fn(
            samples.n_rows(),
            n_monomials * samples.responses.ncols(),
            |row, j| monomials[(row, j % n_monomials)] * samples.responses[(row, j / n_monomials)],
        );
        add_product(&mut moments.cross, &own, &weighted);

        for (energy, y) in moments.energy.iter_mut().zip(samples.responses.col_iter()) {
            *energy += y.squared_norm_l2();
        }
        moments.rows += samples.n_rows();
        Ok(())
    }

    /// The two waves that the product of waves a and b is the weighted sum of, by their place in
    /// the table.
    pub(crate) fn wave_pair(&self, a: usize, b: usize) -> [(f64, usize); 2] {
        self.wave_pairs[packed(a.min(b), a.max(b))]
    }

    /// Places of the products of monomial i with each monomial.
    pub(crate) fn monomial_pairs(&self, i: usize) -> &[usize] {
        let n = self.design.monomials.len();
        &self.monomial_pairs[i * n..(i + 1) * n]
    }
}

/// Place of the pair a ≤ b in a packed triangle.
fn packed(a: usize, b: usize) -> usize {
    b * (b + 1) / 2 + a
}

/// target += aᵀ b
pub(crate) fn add_product(target: &mut Mat<f64>, a: &Mat<f64>, b: &Mat<f64>) {
    matmul(target.as_mut(), Accum::Add, a.transpose(), b.as_ref(), 1.0, Par::Seq);
}

/// Sums over rows; adding two tables is the same as reading the rows of both.
#[derive(Clone, Debug)]
pub struct Moments {
    /// Monomial products × closure waves.
    pub(crate) table: Mat<f64>,
    /// Waves × (response, monomial).
    pub(crate) cross: Mat<f64>,
    pub(crate) energy: Vec<f64>,
    pub(crate) rows: usize,
}

impl Moments {
    /// Rows summed.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Adds the rows of another table.
    ///
    /// # Errors
    /// [`SparseError::Shape`] if the tables were made for different designs.
    pub fn merge(&mut self, other: &Self) -> Result<(), SparseError> {
        self.check_responses(other.energy.len())?;
        let shapes = [
            (self.table.nrows(), other.table.nrows()),
            (self.table.ncols(), other.table.ncols()),
            (self.cross.ncols(), other.cross.ncols()),
        ];
        if let Some(&(expected, found)) = shapes.iter().find(|(a, b)| a != b) {
            return Err(SparseError::Shape { what: "a moment table", found, expected });
        }
        self.table += &other.table;
        self.cross += &other.cross;
        self.energy.iter_mut().zip(&other.energy).for_each(|(a, b)| *a += b);
        self.rows += other.rows;
        Ok(())
    }

    fn check_responses(&self, found: usize) -> Result<(), SparseError> {
        let expected = self.energy.len();
        if found == expected {
            Ok(())
        } else {
            Err(SparseError::Shape { what: "the responses of a block", found, expected })
        }
    }
}
