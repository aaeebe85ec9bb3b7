//! Sums of terms as products ready to evaluate, each sine and cosine once.

use crate::term::{Factor, Kind, Sum};
use std::collections::BTreeMap;

/// One term with its functions looked up by place.
#[derive(Clone, Debug)]
pub(crate) struct Product {
    pub(crate) coefficient: f64,
    pub(crate) kind: Kind,
    pub(crate) factors: Vec<usize>,
    /// Places in \[q̇ q̈\], each as often as its power.
    pub(crate) rates: Vec<usize>,
    /// The joint whose unit acceleration alone leaves the functions: the column of M(q).
    pub(crate) column: Option<usize>,
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
            let rates: Vec<usize> = powers
                .enumerate()
                .flat_map(|(place, &power)| std::iter::repeat_n(place, power.into()))
                .collect();
            let alone = rates.first().filter(|first| rates.iter().all(|place| place == *first));
            let column = alone.and_then(|place| place.checked_sub(term.n_joints()));
            let (coefficient, kind) = (*coefficient, term.kind());
            products.push(Product { coefficient, kind, factors, rates, column });
        }
        joints.push(products);
    }
    let mut factors: Vec<Factor> = places.keys().cloned().collect();
    factors.sort_by_key(|factor| places[factor]);
    (factors, joints)
}
