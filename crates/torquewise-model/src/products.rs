//! Sums of terms as products ready to evaluate, each sine and cosine once.

use crate::term::{Factor, Kind, Sum};
use std::collections::BTreeMap;

/// M(q) on its own: the functions it needs, and what each term adds to an entry.
#[derive(Clone, Debug)]
pub(crate) struct Mass {
    pub(crate) factors: Vec<Factor>,
    pub(crate) entries: Vec<Entry>,
}

/// A term of M(q): `coefficient` times its functions, at (row, column).
#[derive(Clone, Debug)]
pub(crate) struct Entry {
    pub(crate) place: (usize, usize),
    pub(crate) coefficient: f64,
    pub(crate) factors: Vec<usize>,
}

/// One term with its functions looked up by place.
#[derive(Clone, Debug)]
pub(crate) struct Product {
    pub(crate) coefficient: f64,
    pub(crate) kind: Kind,
    pub(crate) factors: Vec<usize>,
    /// Places in \[q̇ q̈\], each as often as its power.
    pub(crate) rates: Vec<usize>,
}

impl Mass {
    /// The terms of torque equations that a unit acceleration of one joint leaves at rest.
    pub(crate) fn of(mut equations: Vec<Sum>, n_joints: usize) -> Self {
        for equation in &mut equations {
            equation.retain(|(_, term)| term.kind() == Kind::Inertia);
        }
        let (factors, joints) = numbered(&equations);
        let mut entries = Vec::new();
        for (row, products) in joints.into_iter().enumerate() {
            for Product { coefficient, factors, rates, .. } in products {
                let alone = rates.windows(2).all(|pair| pair[0] == pair[1]);
                let column = rates.first().and_then(|place| place.checked_sub(n_joints));
                if let (true, Some(column)) = (alone, column) {
                    entries.push(Entry { place: (row, column), coefficient, factors });
                }
            }
        }
        Self { factors, entries }
    }
}

/// The functions of all terms, each once, and the terms of each joint that look them up.
pub(crate) fn numbered(equations: &[Sum]) -> (Vec<Factor>, Vec<Vec<Product>>) {
    let mut places: BTreeMap<Factor, usize> = BTreeMap::new();
    let mut joints = Vec::with_capacity(equations.len());
    for equation in equations {
        let mut products = Vec::with_capacity(equation.len());
        for (coefficient, term) in equation {
            let mut factors = Vec::with_capacity(term.factors.len());
            for factor in &term.factors {
                let next = places.len();
                factors.push(*places.entry(factor.clone()).or_insert(next));
            }
            let powers = term.dq.iter().chain(&term.ddq);
            let rates = powers
                .enumerate()
                .flat_map(|(place, &power)| std::iter::repeat_n(place, power.into()))
                .collect();
            let kind = term.kind();
            products.push(Product { coefficient: *coefficient, kind, factors, rates });
        }
        joints.push(products);
    }
    let mut by_place: Vec<(Factor, usize)> = places.into_iter().collect();
    by_place.sort_by_key(|(_, place)| *place);
    let factors = by_place.into_iter().map(|(factor, _)| factor).collect();
    (factors, joints)
}
