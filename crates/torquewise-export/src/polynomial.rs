//! Sums of terms as nodes: which factors are drawn out, and in which order.

use crate::{Graph, Id, Input};
use std::collections::BTreeMap;
use torquewise_model::{Term, Trig};

/// How a sum of products is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Order {
    /// Each product once, shared by all sums that hold it.
    Products,
    /// The factor that most products hold is drawn out of them, again and again, as Horner does
    /// with one variable: fewest operations for one sum.
    Horner,
}

#[derive(Clone, Debug)]
pub(crate) struct Monomial {
    pub(crate) weight: Id,
    pub(crate) powers: BTreeMap<Id, u32>,
}

/// The angle functions of a term as powers of nodes.
pub(crate) fn angles(graph: &Graph, term: &Term) -> BTreeMap<Id, u32> {
    let mut powers = BTreeMap::new();
    for factor in &term.factors {
        let multiples: Vec<i32> = factor.multiples.iter().map(|&k| i32::from(k)).collect();
        let angle = match factor.function {
            Trig::Sin => graph.sin(&multiples),
            Trig::Cos => graph.cos(&multiples),
            Trig::Position => graph.multiple_sum(&multiples, Input::Q),
        };
        *powers.entry(angle).or_insert(0) += u32::from(factor.power);
    }
    powers
}

/// The velocities and accelerations of a term as powers of nodes.
pub(crate) fn motions(graph: &Graph, term: &Term) -> BTreeMap<Id, u32> {
    let velocities = term.dq.iter().enumerate().map(|(joint, &p)| (Input::Dq(joint), p));
    let accelerations = term.ddq.iter().enumerate().map(|(joint, &p)| (Input::Ddq(joint), p));
    let powers = velocities.chain(accelerations).filter(|&(_, power)| power > 0);
    powers.map(|(input, power)| (graph.input(input), power.into())).collect()
}

/// Σ weight·Π atom^power as one node.
pub(crate) fn polynomial(graph: &Graph, monomials: Vec<Monomial>, order: Order) -> Id {
    match order {
        Order::Products => sum_of_products(graph, &monomials),
        Order::Horner => horner(graph, monomials),
    }
}

fn sum_of_products(graph: &Graph, monomials: &[Monomial]) -> Id {
    let part = |Monomial { weight, powers }: &Monomial| {
        let powers = powers.iter().map(|(&atom, &power)| graph.power(atom, power));
        graph.mul(*weight, graph.product(&powers.collect::<Vec<Id>>()))
    };
    graph.sum(&monomials.iter().map(part).collect::<Vec<Id>>())
}

/// atom·(those that hold it, without it) + the rest.
fn horner(graph: &Graph, monomials: Vec<Monomial>) -> Id {
    let mut counts: BTreeMap<Id, usize> = BTreeMap::new();
    for atom in monomials.iter().flat_map(|monomial| monomial.powers.keys()) {
        *counts.entry(*atom).or_insert(0) += 1;
    }
    // Of equals the first, so that the same model gives the same code.
    let most = counts.iter().max_by_key(|&(atom, count)| (*count, std::cmp::Reverse(*atom)));
    let Some((&atom, _)) = most.filter(|&(_, &count)| count > 1) else {
        return sum_of_products(graph, &monomials);
    };
    let (mut inside, mut rest) = (Vec::new(), Vec::new());
    for mut monomial in monomials {
        match monomial.powers.remove(&atom) {
            Some(power) => {
                if power > 1 {
                    monomial.powers.insert(atom, power - 1);
                }
                inside.push(monomial);
            }
            None => rest.push(monomial),
        }
    }
    graph.add(graph.mul(atom, horner(graph, inside)), horner(graph, rest))
}
