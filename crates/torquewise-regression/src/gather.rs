//! Normal equations YᵀY and Yᵀy of a design from its moments, without its rows (E3).

use crate::accumulate::responses_of;
use crate::atom::Numbering;
use crate::design::Design;
use crate::moments::{MomentPlan, Moments};
use crate::normal_equations::NormalEquations;
use faer::{Mat, MatMut};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// The normal equations of each equation of the plan's design in some of its columns, gathered from
/// moments.
pub(crate) fn gather(
    plan: &MomentPlan,
    moments: &Moments,
    wanted: &[usize],
) -> Vec<NormalEquations> {
    let design = plan.design();
    let n_equations = design.n_equations();
    (0..n_equations)
        .map(|equation| {
            let own = responses_of(equation, n_equations, moments.energy.len());
            let all = &design.equations[equation];
            let columns: Vec<Entries> = wanted.iter().map(|&column| all[column].clone()).collect();
            NormalEquations {
                gram: gather_gram(plan, moments, &columns),
                cross: gather_cross(design, moments, &columns, own.clone()),
                energy: moments.energy[own].to_vec(),
                rows: moments.rows as f64,
            }
        })
        .collect()
}

/// (atom, weight) of a column.
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

/// The Gram matrix of columns: of their parts first, unless each column is a single one.
fn gather_gram(plan: &MomentPlan, moments: &Moments, columns: &[Entries]) -> Mat<f64> {
    let (functions, columns) = parts_of(plan.design(), columns);
    let singles: Vec<Part> = columns.iter().flatten().copied().collect();
    if columns.iter().all(|parts| parts.len() == 1) {
        return part_gram(plan, moments, &functions, &singles);
    }
    let name = |part: &Part| (part.function, part.monomial);
    let mut names: Vec<(usize, usize)> = singles.iter().map(name).collect();
    names.sort_unstable();
    names.dedup();
    let unit = |&(function, monomial): &(usize, usize)| Part { function, monomial, weight: 1.0 };
    let units: Vec<Part> = names.iter().map(unit).collect();
    let gram = part_gram(plan, moments, &functions, &units);
    let place = |part: &Part| Some((names.binary_search(&name(part)).ok()?, part.weight));
    let sums: Vec<Entries> =
        columns.iter().map(|parts| parts.iter().filter_map(place).collect()).collect();
    combine(&gram, &sums)
}

/// Splits columns into parts, and numbers the functions of the angles in them.
fn parts_of(design: &Design, columns: &[Entries]) -> (Vec<Function>, Vec<Vec<Part>>) {
    let mut functions = Numbering::new();
    let mut split = |entries: &Entries| {
        let mut by_monomial: BTreeMap<usize, BTreeMap<usize, f64>> = BTreeMap::new();
        for &(atom, weight) in entries {
            let (wave, monomial) = design.atoms[atom];
            *by_monomial.entry(monomial).or_default().entry(wave).or_default() += weight;
        }
        by_monomial.retain(|_, waves| {
            waves.retain(|_, weight| *weight != 0.0);
            !waves.is_empty()
        });
        let mut part = |(monomial, waves): (usize, BTreeMap<usize, f64>)| {
            let lead = waves.values().next().copied().unwrap_or(1.0);
            let shape: Vec<(usize, u64)> =
                waves.into_iter().map(|(wave, weight)| (wave, (weight / lead).to_bits())).collect();
            Part { function: functions.place(&shape), monomial, weight: lead }
        };
        by_monomial.into_iter().map(&mut part).collect()
    };
    let columns = columns.iter().map(&mut split).collect();
    let spell = |shape: Vec<(usize, u64)>| {
        shape.into_iter().map(|(wave, bits)| (wave, f64::from_bits(bits))).collect()
    };
    (functions.into_values().into_iter().map(spell).collect(), columns)
}

/// Parts that follow each other and share a function.
struct Run<'a> {
    first: usize,
    parts: &'a [Part],
}

impl Run<'_> {
    fn function(&self) -> usize {
        self.parts[0].function
    }
}

/// The Gram matrix of parts: functions f and g share their sum of moments, one entry per monomial,
/// whatever monomials they are multiplied with.
fn part_gram(
    plan: &MomentPlan,
    moments: &Moments,
    functions: &[Function],
    parts: &[Part],
) -> Mat<f64> {
    let mut runs = Vec::new();
    let mut first = 0;
    for parts in parts.chunk_by(|a, b| a.function == b.function) {
        runs.push(Run { first, parts });
        first += parts.len();
    }
    let mut gram = Mat::zeros(parts.len(), parts.len());
    let mut strips = Vec::with_capacity(runs.len());
    let mut rest = gram.as_mut();
    for run in &runs {
        let (strip, after) = rest.split_at_col_mut(run.parts.len());
        strips.push((run, strip));
        rest = after;
    }
    strips.into_par_iter().for_each(|(run, strip)| {
        let half = half_product(plan, moments, &functions[run.function()]);
        fill_columns(plan, &half, functions, &runs, run.parts, strip);
    });
    gram
}

/// Σₜ wave(θₜ) g(θₜ) x(t)^α for each wave of the design and each α, monomials × waves.
fn half_product(plan: &MomentPlan, moments: &Moments, function: &Function) -> Mat<f64> {
    let mut half = Mat::zeros(moments.table.nrows(), plan.design().waves.len());
    for wave in 0..half.ncols() {
        let out = half.col_as_slice_mut(wave);
        for &(other, weight) in function {
            for (share, place) in plan.wave_pair(wave, other) {
                add_scaled(out, weight * share, moments.table.col_as_slice(place));
            }
        }
    }
    half
}

/// out += weight · values
fn add_scaled(out: &mut [f64], weight: f64, values: &[f64]) {
    out.iter_mut().zip(values).for_each(|(out, value)| *out += weight * value);
}

/// Writes the columns of the Gram matrix that belong to parts sharing one function.
fn fill_columns(
    plan: &MomentPlan,
    half: &Mat<f64>,
    functions: &[Function],
    runs: &[Run<'_>],
    columns: &[Part],
    mut strip: MatMut<'_, f64>,
) {
    let mut product = vec![0.0; half.nrows()];
    for run in runs {
        product.fill(0.0);
        for &(wave, weight) in &functions[run.function()] {
            add_scaled(&mut product, weight, half.col_as_slice(wave));
        }
        for (column, out) in columns.iter().zip(strip.as_mut().col_iter_mut()) {
            let Some(out) = out.try_as_col_major_mut() else { continue };
            let places = plan.monomial_pairs(column.monomial);
            let out = &mut out.as_slice_mut()[run.first..][..run.parts.len()];
            for (out, row) in out.iter_mut().zip(run.parts) {
                *out = row.weight * column.weight * product[places[row.monomial]];
            }
        }
    }
}

/// SᵀGS for a sparse S, given by its columns.
fn combine(gram: &Mat<f64>, sums: &[Entries]) -> Mat<f64> {
    let mut combined = Mat::zeros(sums.len(), sums.len());
    let columns: Vec<_> = combined.col_iter_mut().collect();
    columns.into_par_iter().zip(sums).for_each(|(out, sum)| {
        let mut half = vec![0.0; gram.nrows()];
        for &(part, weight) in sum {
            add_scaled(&mut half, weight, gram.col_as_slice(part));
        }
        for (out, sum) in out.iter_mut().zip(sums) {
            *out = sum.iter().map(|&(part, weight)| weight * half[part]).sum();
        }
    });
    combined
}

fn gather_cross(
    design: &Design,
    moments: &Moments,
    columns: &[Entries],
    responses: std::ops::Range<usize>,
) -> Mat<f64> {
    let n_monomials = design.monomials.len();
    Mat::from_fn(columns.len(), responses.len(), |j, r| {
        let place = (responses.start + r) * n_monomials;
        columns[j]
            .iter()
            .map(|&(atom, weight)| {
                let (wave, monomial) = design.atoms[atom];
                weight * moments.cross[(wave, place + monomial)]
            })
            .sum()
    })
}
