//! The cheapest of all ways to compute the functions of a model without friction.
//!
//! A model that holds a rigid chain is that chain, exactly: the recursion or its expanded energies,
//! whichever is cheaper, for each function on its own. Of other models the terms are what they are.

use crate::base_chain::BaseChain;
use crate::cost::Cost;
use crate::error::Result;
use crate::graph::{Graph, Id};
use crate::harmonics::summed;
use crate::lower::lowered;
use crate::parts::{Grouping, Parts, from_energies, from_equations};
use crate::polynomial::Order;
use crate::recursion::{Motion, Recursion};
use std::collections::BTreeMap;
use torquewise_model::{Drive, EnergyTerm, Form, Model, Weighted};

/// Joints up to which a chain is expanded; the terms of more cost many times the recursion.
const MOST_EXPANDED: usize = 4;
const SUMS: usize = 3;

/// What a model computes but for friction, as nodes.
#[derive(Clone, Debug)]
pub(crate) struct Frictionless {
    /// M(q)q̈ + C(q, q̇)q̇ + G(q), n.
    pub(crate) torque: Vec<Id>,
    pub(crate) gravity: Vec<Id>,
    /// C(q, q̇)q̇, n.
    pub(crate) coriolis: Vec<Id>,
    /// M(q) row by row, n·n.
    pub(crate) matrix: Vec<Id>,
}

type Choice = fn(&Frictionless) -> &Vec<Id>;

type Way<'a, T> = Box<dyn Fn(&Graph) -> T + 'a>;

/// The functions of a model, each the cheapest that is known: of a chain by the recursion or by the
/// expansion.
pub(crate) fn frictionless(graph: &Graph, model: &Model) -> Result<Frictionless> {
    let n = model.n_joints();
    let Some(chain) = &model.chain else {
        return Ok(of_form(graph, &model.form, n, |parts| &parts.motion));
    };
    let base = BaseChain::of(chain)?;
    let drives = joined(chain.drives.iter().flat_map(Drive::energy_terms).collect());
    let energies = match n {
        0..=MOST_EXPANDED => with_sums(joined(chain.energy_terms()?), n),
        _ => Vec::new(),
    };
    let mut ways: Vec<Way<'_, Frictionless>> = vec![Box::new(|graph| {
        let recursion = Recursion::new(graph, &base);
        let links = Frictionless {
            torque: recursion.torque(Motion::Whole),
            gravity: recursion.torque(Motion::Rest),
            coriolis: recursion.torque(Motion::Steady),
            matrix: recursion.matrix(),
        };
        let beside = from_energies(graph, &drives, n, Order::Products);
        links.plus(graph, &Frictionless::of(graph, beside))
    })];
    for terms in &energies {
        for order in [Order::Products, Order::Horner] {
            ways.push(Box::new(move |graph| {
                Frictionless::of(graph, from_energies(graph, terms, n, order))
            }));
        }
    }
    let choices: [Choice; 4] = [|f| &f.torque, |f| &f.gravity, |f| &f.coriolis, |f| &f.matrix];
    let [torque, gravity, coriolis, matrix] =
        cheapest(&ways, choices).map(|(way, choice)| choice(&ways[way](graph)).clone());
    Ok(Frictionless { torque, gravity, coriolis, matrix })
}

pub(crate) fn gravity_of(graph: &Graph, form: &Form, n: usize) -> Vec<Id> {
    of_form(graph, form, n, |parts| &parts.gravity).gravity
}

impl Frictionless {
    fn of(graph: &Graph, parts: Parts) -> Self {
        let Parts { motion, gravity, coriolis, matrix } = parts;
        Self { torque: sums(graph, &motion, &gravity), gravity, coriolis, matrix }
    }

    fn plus(&self, graph: &Graph, other: &Self) -> Self {
        Self {
            torque: sums(graph, &self.torque, &other.torque),
            gravity: sums(graph, &self.gravity, &other.gravity),
            coriolis: sums(graph, &self.coriolis, &other.coriolis),
            matrix: sums(graph, &self.matrix, &other.matrix),
        }
    }
}

pub(crate) fn sums(graph: &Graph, left: &[Id], right: &[Id]) -> Vec<Id> {
    left.iter().zip(right).map(|(&a, &b)| graph.add(a, b)).collect()
}

/// For each function the place of the way that computes it in the fewest operations.
fn cheapest(ways: &[Way<'_, Frictionless>], choices: [Choice; 4]) -> [(usize, Choice); 4] {
    let mut best = choices.map(|choice| (usize::MAX, 0, choice));
    for (place, way) in ways.iter().enumerate() {
        let graph = Graph::default();
        let functions = way(&graph);
        for (least, at, choice) in &mut best {
            let weight = weight(&graph, choice(&functions));
            if weight < *least {
                (*least, *at) = (weight, place);
            }
        }
    }
    best.map(|(_, place, choice)| (place, choice))
}

fn weight(graph: &Graph, roots: &[Id]) -> usize {
    let (graph, roots) = lowered(graph, roots);
    Cost::of(&graph, &roots).weight()
}

fn joined(terms: Vec<(EnergyTerm, f64)>) -> Vec<Weighted<EnergyTerm>> {
    let mut sums: BTreeMap<EnergyTerm, f64> = BTreeMap::new();
    for (term, coefficient) in terms {
        *sums.entry(term).or_insert(0.0) += coefficient;
    }
    sums.into_iter().map(|(term, weight)| Weighted::new(term, weight)).collect()
}

/// The parts that cost least where it matters most, of all ways to compute them.
fn of_form(graph: &Graph, form: &Form, n: usize, which: fn(&Parts) -> &Vec<Id>) -> Frictionless {
    let equations = form.equations(n);
    let energies = match form {
        Form::Energy(terms) => with_sums(terms.clone(), n),
        Form::Torque(_) => Vec::new(),
    };
    let mut ways: Vec<Way<'_, Parts>> = Vec::new();
    for order in [Order::Products, Order::Horner] {
        for terms in &energies {
            ways.push(Box::new(move |graph| from_energies(graph, terms, n, order)));
        }
        for grouping in [Grouping::ByMotion, Grouping::None] {
            let equations = &equations;
            ways.push(Box::new(move |graph| from_equations(graph, equations, order, grouping)));
        }
    }
    let tried = ways.iter().map(|way| {
        let graph = Graph::default();
        weight(&graph, which(&way(&graph)))
    });
    let best = tried.enumerate().min_by_key(|&(place, cost)| (cost, place));
    let parts = ways[best.map_or(0, |(place, _)| place)](graph);
    Frictionless::of(graph, parts)
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
