//! Moments Σₜ wave(θₜ)·x(t)^α, and the normal equations YᵀY and Yᵀy that follow from them without
//! the rows (E3).

use crate::atom::{Monomial, Numbering, Wave};
use crate::products::add_product;
use crate::samples::{monomial_values, wave_cost, wave_values};
use crate::{Design, NormalEquations, Samples, ascending};
use faer::Mat;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::ops::Range;

/// Which moments a design needs, and where each stands in the table.
#[derive(Clone, Debug)]
pub struct MomentPlan {
    pub(crate) design: Design,
    /// The waves of the design, then what else is in products of two of them.
    waves: Vec<Wave>,
    /// The monomials of the design, then what else is a product of two of them.
    monomials: Vec<Monomial>,
    /// Which monomials are made of which two of the design.
    products: BTreeMap<usize, (usize, usize)>,
    /// ½·sign and row of the two waves of each product of waves, a ≤ b, packed.
    wave_pairs: Vec<[(f64, usize); 2]>,
    /// Column of each product of two monomials, all with the first before all with the second.
    monomial_pairs: Vec<usize>,
}

impl MomentPlan {
    /// Lists the products that the Gram matrix of a design is made of.
    pub fn new(design: &Design) -> Self {
        let (mut waves, mut monomials) = (Numbering::default(), Numbering::default());
        design.waves.iter().for_each(|wave| _ = waves.place(wave.clone()));
        design.monomials.iter().for_each(|monomial| _ = monomials.place(monomial.clone()));
        let mut wave_pairs = Vec::with_capacity(packed(0, design.waves.len()));
        for (b, right) in design.waves.iter().enumerate() {
            for left in &design.waves[..=b] {
                let mut pair = |(sign, wave): (f64, Wave)| (0.5 * sign, waves.place(wave));
                wave_pairs.push(left.product(right).map(|term| term.map_or((0.0, 0), &mut pair)));
            }
        }
        let mut monomial_pairs = Vec::with_capacity(design.monomials.len().pow(2));
        let mut products = BTreeMap::new();
        for (i, a) in design.monomials.iter().enumerate() {
            for (j, b) in design.monomials.iter().enumerate() {
                let powers = a.powers.iter().zip(&b.powers).map(|(a, b)| a + b).collect();
                let place = monomials.place(Monomial { powers });
                monomial_pairs.push(place);
                if place >= design.monomials.len() {
                    products.entry(place).or_insert((i, j));
                }
            }
        }
        let (waves, monomials) = (waves.into_values(), monomials.into_values());
        Self { design: design.clone(), waves, monomials, products, wave_pairs, monomial_pairs }
    }

    /// Multiplications per row with `n_responses` responses: harmonics, then two products of
    /// matrices.
    pub fn cost(&self, n_responses: usize) -> f64 {
        (wave_cost(&self.waves) + self.size(n_responses)) as f64
    }

    /// Entries of the moment table, 8 bytes each.
    pub fn size(&self, n_responses: usize) -> usize {
        let (w, a) = (self.design.waves.len(), self.design.monomials.len());
        self.waves.len() * self.monomials.len() + w * a * n_responses
    }

    /// The moments of no rows: monomials × waves; waves × (response, monomial) of the design; the
    /// energy of each response.
    pub(crate) fn zeros(&self, n_responses: usize) -> [Mat<f64>; 3] {
        let (w, a) = (self.design.waves.len(), self.design.monomials.len());
        [
            Mat::zeros(self.monomials.len(), self.waves.len()),
            Mat::zeros(w, a * n_responses),
            Mat::zeros(n_responses, 1),
        ]
    }

    pub(crate) fn add(&self, blocks: &[Samples], [table, cross, energy]: &mut [Mat<f64>; 3]) {
        let zeros = |columns| Mat::zeros(STRIP_ROWS, columns);
        // The waves and monomials of the design are the first of all.
        let [w, a] = [self.design.waves.len(), self.design.monomials.len()];
        let (mut waves, mut monomials) = (zeros(self.waves.len()), zeros(self.monomials.len()));
        let mut weighted = zeros(cross.ncols());
        for Samples { angles, variables, responses } in blocks {
            let m = angles.nrows();
            for first in (0..m).step_by(STRIP_ROWS) {
                let rows = first..m.min(first + STRIP_ROWS);
                wave_values(&self.waves, angles, &rows, &mut waves);
                monomial_values(&self.monomials, &self.products, variables, &rows, &mut monomials);
                for j in 0..weighted.ncols() {
                    let response = &responses.col_as_slice(j / a)[rows.clone()];
                    let factors = monomials.col_as_slice(j % a).iter().zip(response);
                    let products = weighted.col_as_slice_mut(j).iter_mut().zip(factors);
                    products.for_each(|(out, (monomial, y))| *out = monomial * y);
                }
                let waves = waves.subrows(0, rows.len());
                add_product(table, monomials.subrows(0, rows.len()), waves);
                add_product(cross, waves.subcols(0, w), weighted.subrows(0, rows.len()));
            }
            for (r, response) in responses.col_iter().enumerate() {
                energy[(r, 0)] += response.squared_norm_l2();
            }
        }
    }
}

/// Place of the pair a ≤ b in a packed triangle.
fn packed(a: usize, b: usize) -> usize {
    b * (b + 1) / 2 + a
}

/// Rows worked on at once: few enough to stay in a cache, many enough for a product of matrices.
const STRIP_ROWS: usize = 256;

/// (atom or part, weight) of a column.
type Entries = Vec<(usize, f64)>;
/// (wave, weight) of a function of the angles; the first weight is 1.
type Function = Vec<(usize, f64)>;

/// weight × function × monomial: what a column is a sum of.
#[derive(Clone, Copy)]
struct Part {
    function: usize,
    monomial: usize,
    weight: f64,
}

/// The normal equations of each equation of the plan's design in some of its columns, gathered from
/// moments: those of waves with monomials, of waves with responses, and the energy of each response.
pub(crate) fn gather(
    plan: &MomentPlan,
    [table, cross, energy]: &[Mat<f64>; 3],
    rows: usize,
    wanted: &[usize],
) -> Vec<NormalEquations> {
    let (design, energy) = (&plan.design, energy.col_as_slice(0));
    let equations = design.equations.iter().enumerate().map(|(equation, all)| {
        let own = responses_of(equation, design.n_equations(), energy.len());
        let columns: Vec<Entries> = wanted.iter().map(|&column| all[column].clone()).collect();
        let gram = gather_gram(plan, table, &columns);
        let cross = Mat::from_fn(columns.len(), own.len(), |j, r| {
            let of_response = (own.start + r) * design.monomials.len();
            let product = |&(atom, weight): &(usize, f64)| {
                let (wave, monomial) = design.atoms[atom];
                weight * cross[(wave, of_response + monomial)]
            };
            columns[j].iter().map(product).sum()
        });
        NormalEquations { gram, cross, energy: energy[own].to_vec(), rows: rows as f64 }
    });
    equations.collect()
}

/// The responses an equation explains: all of them if there is one equation, else its own.
pub(crate) fn responses_of(equation: usize, count: usize, n_responses: usize) -> Range<usize> {
    if count == 1 { 0..n_responses } else { equation..equation + 1 }
}

/// The Gram matrix of columns: of their parts first, unless each column is a single one.
fn gather_gram(plan: &MomentPlan, table: &Mat<f64>, columns: &[Entries]) -> Mat<f64> {
    let (functions, columns) = parts_of(&plan.design, columns);
    let singles: Vec<Part> = columns.iter().flatten().copied().collect();
    if columns.iter().all(|parts| parts.len() == 1) {
        return part_gram(plan, table, &functions, &singles);
    }
    let name = |part: &Part| (part.function, part.monomial);
    let names = ascending(singles.iter().map(name).collect());
    let unit = |&(function, monomial): &(usize, usize)| Part { function, monomial, weight: 1.0 };
    let units: Vec<Part> = names.iter().map(unit).collect();
    let gram = part_gram(plan, table, &functions, &units);
    let place = |part: &Part| Some((names.binary_search(&name(part)).ok()?, part.weight));
    let sums: Vec<Entries> =
        columns.iter().map(|parts| parts.iter().filter_map(place).collect()).collect();
    // SᵀGS for a sparse S.
    let mut combined = Mat::zeros(sums.len(), sums.len());
    let columns: Vec<_> = combined.col_iter_mut().collect();
    columns.into_par_iter().zip(&sums).for_each(|(out, sum)| {
        let mut half = vec![0.0; gram.nrows()];
        for &(part, weight) in sum {
            add_scaled(&mut half, weight, gram.col_as_slice(part));
        }
        for (out, sum) in out.iter_mut().zip(&sums) {
            *out = sum.iter().map(|&(part, weight)| weight * half[part]).sum();
        }
    });
    combined
}

/// Splits columns into parts, and numbers the functions of the angles in them.
fn parts_of(design: &Design, columns: &[Entries]) -> (Vec<Function>, Vec<Vec<Part>>) {
    let mut functions = Numbering::default();
    let mut split = |entries: &Entries| {
        let mut by_monomial: BTreeMap<usize, BTreeMap<usize, f64>> = BTreeMap::new();
        for &(atom, weight) in entries {
            let (wave, monomial) = design.atoms[atom];
            *by_monomial.entry(monomial).or_default().entry(wave).or_default() += weight;
        }
        let mut part = |(monomial, mut waves): (usize, BTreeMap<usize, f64>)| {
            waves.retain(|_, weight| *weight != 0.0);
            let weight = *waves.values().next()?;
            let shape: Vec<(usize, u64)> =
                waves.into_iter().map(|(wave, own)| (wave, (own / weight).to_bits())).collect();
            Some(Part { function: functions.place(shape), monomial, weight })
        };
        by_monomial.into_iter().filter_map(&mut part).collect()
    };
    let columns = columns.iter().map(&mut split).collect();
    let spell = |shape: Vec<(usize, u64)>| {
        shape.into_iter().map(|(wave, bits)| (wave, f64::from_bits(bits))).collect()
    };
    (functions.into_values().into_iter().map(spell).collect(), columns)
}

/// The Gram matrix of parts: functions f and g share their sum of moments, one entry per monomial,
/// whatever monomials they are multiplied with.
fn part_gram(
    plan: &MomentPlan,
    table: &Mat<f64>,
    functions: &[Function],
    parts: &[Part],
) -> Mat<f64> {
    // Parts that follow each other and share a function: their columns.
    let mut gram = Mat::zeros(parts.len(), parts.len());
    let mut strips = Vec::new();
    let mut rest = gram.as_mut();
    for run in parts.chunk_by(|a, b| a.function == b.function) {
        let (strip, after) = rest.split_at_col_mut(run.len());
        strips.push((run, strip));
        rest = after;
    }
    strips.into_par_iter().for_each(|(columns, mut strip)| {
        // Σₜ wave(θₜ) g(θₜ) x(t)^α for each wave of the design and each α, monomials × waves.
        let mut half = Mat::zeros(table.nrows(), plan.design.waves.len());
        for wave in 0..half.ncols() {
            let out = half.col_as_slice_mut(wave);
            for &(other, weight) in &functions[columns[0].function] {
                for (share, place) in plan.wave_pairs[packed(wave.min(other), wave.max(other))] {
                    add_scaled(out, weight * share, table.col_as_slice(place));
                }
            }
        }
        let (mut product, mut first) = (vec![0.0; half.nrows()], 0);
        for rows in parts.chunk_by(|a, b| a.function == b.function) {
            product.fill(0.0);
            for &(wave, weight) in &functions[rows[0].function] {
                add_scaled(&mut product, weight, half.col_as_slice(wave));
            }
            for (column, out) in columns.iter().zip(strip.as_mut().col_iter_mut()) {
                let Some(out) = out.try_as_col_major_mut() else { continue };
                let places = &plan.monomial_pairs[column.monomial * plan.design.monomials.len()..];
                for (out, row) in out.as_slice_mut()[first..].iter_mut().zip(rows) {
                    *out = row.weight * column.weight * product[places[row.monomial]];
                }
            }
            first += rows.len();
        }
    });
    gram
}

fn add_scaled(out: &mut [f64], weight: f64, values: &[f64]) {
    out.iter_mut().zip(values).for_each(|(out, value)| *out += weight * value);
}
