//! The cheapest of all ways to compute the functions of a model without friction.
//!
//! A model that holds a rigid chain is that chain, exactly: the recursion or its expanded energies,
//! whichever is cheaper, for each function on its own. Of other models the terms are what they are.

use crate::base_chain::BaseChain;
use crate::harmonics::summed;
use crate::lower::lowered;
use crate::parts::{Grouping, Parts, from_energies, from_equations, sums};
use crate::polynomial::Order;
use crate::recursion::{Motion, Recursion};
use crate::{Cost, Graph, Id, Result};
use std::collections::BTreeMap;
use torquewise_model::{Drive, EnergyTerm, Form, Model, Weighted};

/// Joints up to which a chain is expanded; the terms of more cost many times the recursion.
const MOST_EXPANDED: usize = 4;
const SUMS: usize = 3;

type Choice = fn(&Parts) -> &Vec<Id>;

type Way<'a> = Box<dyn Fn(&Graph) -> Parts + 'a>;

/// The functions of a model, each the cheapest that is known: of a chain by the recursion or by the
/// expansion.
pub(crate) fn frictionless(graph: &Graph, model: &Model) -> Result<Parts> {
    let n = model.n_joints();
    let Some(chain) = &model.chain else {
        return Ok(of_form(graph, &model.form, n, |parts| &parts.torque));
    };
    let base = BaseChain::of(chain)?;
    let drives = joined(chain.drives.iter().flat_map(Drive::energy_terms).collect());
    let energies = match n {
        0..=MOST_EXPANDED => with_sums(joined(chain.energy_terms()?), n),
        _ => Vec::new(),
    };
    let mut ways: Vec<Way<'_>> = vec![Box::new(|graph| {
        let recursion = Recursion::new(graph, &base);
        let [torque, gravity, coriolis] =
            [Motion::Whole, Motion::Rest, Motion::Steady].map(|motion| recursion.torque(motion));
        let matrix = recursion.matrix();
        let beside = from_energies(graph, &drives, n, Order::Products).weighed(graph);
        Parts {
            torque: sums(graph, &torque, &beside.torque),
            gravity: sums(graph, &gravity, &beside.gravity),
            coriolis: sums(graph, &coriolis, &beside.coriolis),
            matrix: sums(graph, &matrix, &beside.matrix),
        }
    })];
    for terms in &energies {
        for order in [Order::Products, Order::Horner] {
            ways.push(Box::new(move |graph| from_energies(graph, terms, n, order).weighed(graph)));
        }
    }
    let choices: [Choice; 4] = [|f| &f.torque, |f| &f.gravity, |f| &f.coriolis, |f| &f.matrix];
    let [torque, gravity, coriolis, matrix] =
        cheapest(&ways, choices).map(|(way, choice)| choice(&ways[way](graph)).clone());
    Ok(Parts { torque, gravity, coriolis, matrix })
}

pub(crate) fn gravity_of(graph: &Graph, form: &Form, n: usize) -> Vec<Id> {
    of_form(graph, form, n, |parts| &parts.gravity).gravity
}

/// For each function the place of the first way that computes it in the fewest operations.
fn cheapest<const N: usize>(ways: &[Way<'_>], choices: [Choice; N]) -> [(usize, Choice); N] {
    let mut best = choices.map(|choice| (usize::MAX, 0, choice));
    for (place, way) in ways.iter().enumerate() {
        let graph = Graph::default();
        let functions = way(&graph);
        for (least, at, choice) in &mut best {
            let (graph, roots) = lowered(&graph, choice(&functions));
            let weight = Cost::of(&graph, &roots).weight();
            if weight < *least {
                (*least, *at) = (weight, place);
            }
        }
    }
    best.map(|(_, place, choice)| (place, choice))
}

fn joined(terms: Vec<(EnergyTerm, f64)>) -> Vec<Weighted<EnergyTerm>> {
    let mut sums: BTreeMap<EnergyTerm, f64> = BTreeMap::new();
    for (term, coefficient) in terms {
        *sums.entry(term).or_insert(0.0) += coefficient;
    }
    sums.into_iter().map(|(term, weight)| Weighted::new(term, weight)).collect()
}

/// The parts that cost least where it matters most, of all ways to compute them.
fn of_form(graph: &Graph, form: &Form, n: usize, which: Choice) -> Parts {
    let equations = form.equations(n);
    let energies = match form {
        Form::Energy(terms) => with_sums(terms.clone(), n),
        Form::Torque(_) => Vec::new(),
    };
    let mut ways: Vec<Way<'_>> = Vec::new();
    for order in [Order::Products, Order::Horner] {
        for terms in &energies {
            ways.push(Box::new(move |graph| from_energies(graph, terms, n, order)));
        }
        for grouping in [Grouping::ByMotion, Grouping::None] {
            let equations = &equations;
            ways.push(Box::new(move |graph| from_equations(graph, equations, order, grouping)));
        }
    }
    let [(best, _)] = cheapest(&ways, [which]);
    ways[best](graph).weighed(graph)
}

/// The energies, and the same with the angles of some neighbouring joints summed where that takes
/// fewer terms.
fn with_sums(terms: Vec<Weighted<EnergyTerm>>, n: usize) -> Vec<Vec<Weighted<EnergyTerm>>> {
    let ranges = (0..n).flat_map(|first| (first + 2..=n).map(move |end| first..end));
    let mut sums: Vec<_> = ranges.filter_map(|joints| summed(&terms, &joints)).collect();
    sums.retain(|sum| sum.len() < terms.len());
    sums.sort_by_key(Vec::len);
    sums.truncate(SUMS);
    sums.insert(0, terms);
    sums
}
