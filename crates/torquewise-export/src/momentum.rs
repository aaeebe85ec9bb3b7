//! Derived from M(q), C(q, q̇)q̇ and G(q): Coriolis matrix, M⁻¹, accelerations, observer.

use crate::derivative::{Along, rates};
use crate::parts::{Parts, products};
use crate::{Function, Graph, Id, Input};

/// C(q, q̇) by Christoffel symbols, row by row, n·n: half the slope of C(q, q̇)q̇ by q̇, which is of
/// second order in q̇; Ṁ − 2C is skew where M is symmetric.
pub(crate) fn coriolis_matrix(graph: &Graph, coriolis: &[Id]) -> Vec<Id> {
    let (n, half) = (coriolis.len(), graph.constant(0.5));
    let mut matrix = vec![half; n * n];
    for column in 0..n {
        let slopes = rates(graph, coriolis, Along::Velocity(column));
        for (row, slope) in slopes.into_iter().enumerate() {
            matrix[row * n + column] = graph.mul(half, slope);
        }
    }
    matrix
}

/// p = M(q) q̇ and Cᵀq̇ − G − F, the part of ṗ that is neither τ nor external (E16); 2n.
pub(crate) fn momentum(graph: &Graph, parts: &Parts, friction: &[Id]) -> Vec<Id> {
    let n = friction.len();
    let product = |row| graph.sum(&products(graph, row, Input::Dq));
    let mut momentum: Vec<Id> = parts.matrix.chunks_exact(n).map(product).collect();
    // Cᵀq̇ = Ṁq̇ − Cq̇.
    let turning = rates(graph, &momentum, Along::Motion);
    let held = turning.into_iter().zip(held(graph, parts, friction));
    momentum.extend(held.map(|(rate, held)| graph.sub(rate, held)));
    momentum
}

/// Cq̇ + G + F, n.
fn held(graph: &Graph, parts: &Parts, friction: &[Id]) -> impl Iterator<Item = Id> {
    let all = parts.coriolis.iter().zip(&parts.gravity).zip(friction);
    all.map(|((&coriolis, &gravity), &friction)| graph.sum(&[coriolis, gravity, friction]))
}

/// M = LU without pivots, which a positive definite M does not need.
pub(crate) struct Factors {
    n: usize,
    /// L below the diagonal, U on it and above, row by row.
    entries: Vec<Id>,
    /// One over the diagonal of U, n.
    pivots: Vec<Id>,
}

impl Factors {
    pub(crate) fn of(graph: &Graph, matrix: &[Id], n: usize) -> Self {
        let mut entries = matrix.to_vec();
        let mut pivots = Vec::with_capacity(n);
        for k in 0..n {
            let pivot = graph.call(Function::Reciprocal, entries[k * n + k]);
            pivots.push(pivot);
            for i in k + 1..n {
                let factor = graph.mul(entries[i * n + k], pivot);
                entries[i * n + k] = factor;
                for j in k + 1..n {
                    entries[i * n + j] =
                        graph.sub(entries[i * n + j], graph.mul(factor, entries[k * n + j]));
                }
            }
        }
        Self { n, entries, pivots }
    }

    /// M⁻¹b, n.
    pub(crate) fn solve(&self, graph: &Graph, b: &[Id]) -> Vec<Id> {
        let (n, mut x) = (self.n, b.to_vec());
        for i in 0..n {
            for j in 0..i {
                x[i] = graph.sub(x[i], graph.mul(self.entries[i * n + j], x[j]));
            }
        }
        for i in (0..n).rev() {
            for j in i + 1..n {
                x[i] = graph.sub(x[i], graph.mul(self.entries[i * n + j], x[j]));
            }
            x[i] = graph.mul(x[i], self.pivots[i]);
        }
        x
    }

    /// M⁻¹ row by row, n·n.
    pub(crate) fn inverse(&self, graph: &Graph) -> Vec<Id> {
        let n = self.n;
        let mut inverse = self.entries.clone();
        for column in 0..n {
            let unit: Vec<Id> =
                (0..n).map(|i| graph.constant(f64::from(u8::from(i == column)))).collect();
            for (row, entry) in self.solve(graph, &unit).into_iter().enumerate() {
                inverse[row * n + column] = entry;
            }
        }
        inverse
    }

    /// q̈ = M⁻¹(τ − Cq̇ − G − F), n.
    pub(crate) fn accelerations(&self, graph: &Graph, parts: &Parts, friction: &[Id]) -> Vec<Id> {
        let free = |(joint, held)| graph.sub(graph.input(Input::Tau(joint)), held);
        let free = held(graph, parts, friction).enumerate().map(free);
        self.solve(graph, &free.collect::<Vec<Id>>())
    }
}
