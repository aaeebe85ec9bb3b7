//! Moments Σₜ wave(θₜ)·x(t)^α, from which the Gram matrix of any library follows (E3).

use crate::atom::{Monomial, Numbering};
use crate::design::Design;
use crate::error::SparseError;
use crate::products::add_product;
use crate::samples::{Phasors, Samples, WaveTree, monomial_values, multiply};
use faer::Mat;
use std::collections::BTreeMap;
use std::ops::Range;

/// Which moments a design needs, and where each stands in the table.
#[derive(Clone, Debug)]
pub struct MomentPlan {
    design: Design,
    /// The waves of the design, then what else is in products of two of them.
    waves: WaveTree,
    /// The monomials of the design, then what else is a product of two of them.
    monomials: Vec<Monomial>,
    /// Which monomials are made of which two of the design.
    products: BTreeMap<usize, (usize, usize)>,
    /// ½·sign and row of the two waves of each product of waves, a ≤ b, packed.
    wave_pairs: Vec<[(f64, usize); 2]>,
    /// Column of each product of two monomials.
    monomial_pairs: Vec<usize>,
}

impl MomentPlan {
    /// Lists the products that the Gram matrix of a design is made of.
    pub fn new(design: &Design) -> Self {
        let (mut waves, mut monomials) = (Numbering::new(), Numbering::new());
        design.waves.iter().for_each(|wave| _ = waves.place(wave));
        design.monomials.iter().for_each(|monomial| _ = monomials.place(monomial));
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
        let mut products = BTreeMap::new();
        for (i, a) in design.monomials.iter().enumerate() {
            for (j, b) in design.monomials.iter().enumerate() {
                let place = monomials.place(&a.product(b));
                monomial_pairs.push(place);
                if place >= design.monomials.len() {
                    products.entry(place).or_insert((i, j));
                }
            }
        }
        Self {
            design: design.clone(),
            waves: WaveTree::new(&waves.into_values()),
            monomials: monomials.into_values(),
            products,
            wave_pairs,
            monomial_pairs,
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
        (4 * self.waves.n_nodes()
            + self.waves.n_waves() * self.monomials.len()
            + w * a * n_responses) as f64
    }

    /// Entries of the moment table, 8 bytes each.
    pub fn size(&self, n_responses: usize) -> usize {
        let (w, a) = (self.design.waves.len(), self.design.monomials.len());
        self.waves.n_waves() * self.monomials.len() + w * a * n_responses
    }

    /// An empty table.
    pub(crate) fn start(&self, n_responses: usize) -> Moments {
        let (w, a) = (self.design.waves.len(), self.design.monomials.len());
        Moments {
            table: Mat::zeros(self.monomials.len(), self.waves.n_waves()),
            cross: Mat::zeros(w, a * n_responses),
            energy: vec![0.0; n_responses],
            rows: 0,
        }
    }

    /// Memory to accumulate with, for any number of blocks.
    pub(crate) fn strip(&self, n_responses: usize) -> Strip {
        let zeros = |columns| Mat::zeros(STRIP_ROWS, columns);
        Strip {
            phasors: self.waves.phasors(STRIP_ROWS),
            waves: zeros(self.waves.n_waves()),
            monomials: zeros(self.monomials.len()),
            weighted: zeros(self.design.monomials.len() * n_responses),
        }
    }

    /// Adds a block of rows to a table, in memory of [`Self::strip`].
    pub(crate) fn accumulate(
        &self,
        strip: &mut Strip,
        moments: &mut Moments,
        samples: &Samples,
    ) -> Result<(), SparseError> {
        samples.check(&self.design)?;
        let (found, expected) = (samples.responses.ncols(), moments.energy.len());
        if found != expected {
            return Err(SparseError::Shape { what: "the responses of a block", found, expected });
        }
        let m = samples.n_rows();
        for first in (0..m).step_by(STRIP_ROWS) {
            self.add_strip(strip, moments, samples, &(first..m.min(first + STRIP_ROWS)));
        }
        for (energy, y) in moments.energy.iter_mut().zip(samples.responses.col_iter()) {
            *energy += y.squared_norm_l2();
        }
        moments.rows += m;
        Ok(())
    }

    fn add_strip(
        &self,
        strip: &mut Strip,
        moments: &mut Moments,
        samples: &Samples,
        rows: &Range<usize>,
    ) {
        let Strip { phasors, waves, monomials, weighted } = strip;
        self.waves.evaluate(&samples.angles, rows, phasors, waves);
        let Self { monomials: all, products, .. } = self;
        monomial_values(all, products, &samples.variables, rows, monomials);
        weigh(weighted, monomials, &samples.responses, rows);

        let m = rows.len();
        let waves = waves.subrows(0, m);
        let own = waves.subcols(0, self.design.waves.len());
        add_product(&mut moments.table, monomials.subrows(0, m), waves);
        add_product(&mut moments.cross, own, weighted.subrows(0, m));
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

/// Rows worked on at once: few enough to stay in a cache, many enough for a product of matrices.
const STRIP_ROWS: usize = 256;

/// What a design and its products are at a strip of rows, in memory that is taken once.
pub(crate) struct Strip {
    phasors: Phasors,
    /// Rows × waves.
    waves: Mat<f64>,
    /// Rows × monomials.
    monomials: Mat<f64>,
    /// Rows × (response, monomial of the design).
    weighted: Mat<f64>,
}

/// Writes each response times each monomial of a design, which are the first of all monomials.
fn weigh(weighted: &mut Mat<f64>, monomials: &Mat<f64>, responses: &Mat<f64>, rows: &Range<usize>) {
    let own = weighted.ncols() / responses.ncols().max(1);
    for j in 0..weighted.ncols() {
        let response = &responses.col_as_slice(j / own)[rows.clone()];
        multiply(weighted.col_as_slice_mut(j), monomials.col_as_slice(j % own), response);
    }
}

/// Sums over rows.
#[derive(Clone, Debug)]
pub(crate) struct Moments {
    /// Monomials × waves.
    pub(crate) table: Mat<f64>,
    /// Waves × (response, monomial).
    pub(crate) cross: Mat<f64>,
    pub(crate) energy: Vec<f64>,
    pub(crate) rows: usize,
}
