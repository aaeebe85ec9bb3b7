//! Sums of terms as products ready to evaluate, each sine and cosine once.

use crate::{Factor, Kind, Sum, Term};
use torquewise_regression::atom::Numbering;

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
    let mut factors = Numbering::default();
    let mut product = |(coefficient, term): &(f64, Term)| {
        let powers = term.dq.iter().chain(&term.ddq).enumerate();
        let rates: Vec<usize> =
            powers.flat_map(|(place, &power)| std::iter::repeat_n(place, power.into())).collect();
        let alone = rates.first().filter(|first| rates.iter().all(|place| place == *first));
        Product {
            coefficient: *coefficient,
            kind: term.kind(),
            factors: term.factors.iter().map(|own| factors.place(own.clone())).collect(),
            column: alone.and_then(|place| place.checked_sub(term.n_joints())),
            rates,
        }
    };
    let joints = equations.iter().map(|sum| sum.iter().map(&mut product).collect()).collect();
    (factors.into_values(), joints)
}
