//! Moments Σₜ wave(θₜ)·x(t)^α, from which the Gram matrix of any library follows (E3).

use crate::atom::{Monomial, Numbering};
use crate::design::Design;
use crate::products::add_product;
use crate::samples::{Phasors, Samples, WaveTree, monomial_values, multiply};
use faer::Mat;
use std::collections::BTreeMap;
use std::ops::Range;

/// Which moments a design needs, and where each stands in the table.
#[derive(Clone, Debug)]
pub struct MomentPlan {
    pub(crate) design: Design,
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
        let (design, waves) = (design.clone(), WaveTree::new(&waves.values));
        let monomials = monomials.values;
        Self { design, waves, monomials, products, wave_pairs, monomial_pairs }
    }

    /// Multiplications per row with `n_responses` responses: harmonics, then two products of
    /// matrices.
    pub fn cost(&self, n_responses: usize) -> f64 {
        (4 * self.waves.nodes.len() + self.size(n_responses)) as f64
    }

    /// Entries of the moment table, 8 bytes each.
    pub fn size(&self, n_responses: usize) -> usize {
        let (w, a) = (self.design.waves.len(), self.design.monomials.len());
        self.waves.n_waves * self.monomials.len() + w * a * n_responses
    }

    /// The moments of no rows: monomials × waves; waves × (response, monomial) of the design; the
    /// energy of each response.
    pub(crate) fn zeros(&self, n_responses: usize) -> [Mat<f64>; 3] {
        let (w, a) = (self.design.waves.len(), self.design.monomials.len());
        [
            Mat::zeros(self.monomials.len(), self.waves.n_waves),
            Mat::zeros(w, a * n_responses),
            Mat::zeros(n_responses, 1),
        ]
    }

    /// Adds blocks of rows to the moments.
    pub(crate) fn add(&self, blocks: &[Samples], [table, cross, energy]: &mut [Mat<f64>; 3]) {
        let zeros = |columns| Mat::zeros(STRIP_ROWS, columns);
        let mut strip = Strip {
            phasors: self.waves.phasors(STRIP_ROWS),
            waves: zeros(self.waves.n_waves),
            monomials: zeros(self.monomials.len()),
            weighted: zeros(cross.ncols()),
        };
        for samples in blocks {
            let m = samples.n_rows();
            for first in (0..m).step_by(STRIP_ROWS) {
                let rows = first..m.min(first + STRIP_ROWS);
                self.evaluate(samples, &rows, &mut strip);
                let waves = strip.waves.subrows(0, rows.len());
                let own = waves.subcols(0, self.design.waves.len());
                add_product(table, strip.monomials.subrows(0, rows.len()), waves);
                add_product(cross, own, strip.weighted.subrows(0, rows.len()));
            }
            for (r, response) in samples.responses.col_iter().enumerate() {
                energy[(r, 0)] += response.squared_norm_l2();
            }
        }
    }

    /// Writes what is summed at some rows into the first rows of a strip.
    fn evaluate(&self, samples: &Samples, rows: &Range<usize>, strip: &mut Strip) {
        let Strip { phasors, waves, monomials, weighted } = strip;
        self.waves.evaluate(&samples.angles, rows, phasors, waves);
        monomial_values(&self.monomials, &self.products, &samples.variables, rows, monomials);
        // The monomials of the design are the first of all.
        let own = self.design.monomials.len();
        for j in 0..weighted.ncols() {
            let response = &samples.responses.col_as_slice(j / own)[rows.clone()];
            multiply(weighted.col_as_slice_mut(j), monomials.col_as_slice(j % own), response);
        }
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
struct Strip {
    phasors: Phasors,
    /// Rows × waves.
    waves: Mat<f64>,
    /// Rows × monomials.
    monomials: Mat<f64>,
    /// Rows × (response, monomial of the design): each response times each monomial.
    weighted: Mat<f64>,
}
