//! The parts of a model as nodes: M(q), C(q, q̇)q̇, G(q), F(q, q̇).

use crate::derivative::{Along, rates, slopes};
use crate::polynomial::{Monomial, Order, angles, motions, polynomial};
use crate::{Function, Graph, Id, Input};
use std::collections::BTreeMap;
use torquewise_model::{
    Direction, EnergyTerm, FrictionLaw, FrictionTerm, Kind, Place, Sum, Term, Weighted,
};

/// What a model computes but for friction, as nodes.
#[derive(Clone, Debug)]
pub(crate) struct Parts {
    /// M(q)q̈ + C(q, q̇)q̇, n, and G(q) once it is [`Self::weighed`].
    pub(crate) torque: Vec<Id>,
    pub(crate) gravity: Vec<Id>,
    /// C(q, q̇)q̇, n.
    pub(crate) coriolis: Vec<Id>,
    /// Torque of joint i per unit acceleration of joint j at rest, M(q) of a rigid arm, row by row,
    /// n·n.
    pub(crate) matrix: Vec<Id>,
}

impl Parts {
    /// With G(q) in the torque.
    pub(crate) fn weighed(self, graph: &Graph) -> Self {
        Self { torque: sums(graph, &self.torque, &self.gravity), ..self }
    }
}

pub(crate) fn sums(graph: &Graph, left: &[Id], right: &[Id]) -> Vec<Id> {
    left.iter().zip(right).map(|(&a, &b)| graph.add(a, b)).collect()
}

/// Parts from energies: τ = Mq̈ + Ṁq̇ − ½ ∂(q̇ᵀMq̇)/∂q + ∂V/∂q.
///
/// Source: method.md, \[E4\].
pub(crate) fn from_energies(
    graph: &Graph,
    terms: &[Weighted<EnergyTerm>],
    n: usize,
    order: Order,
) -> Parts {
    let mut places: BTreeMap<Place, Vec<Monomial>> = BTreeMap::new();
    for weighted in terms {
        let weight = graph.constant(weighted.coefficient);
        let powers = angles(graph, &weighted.term.function);
        let place = places.entry(weighted.term.place).or_default();
        place.push(Monomial { weight, powers });
    }
    let zero = graph.constant(0.0);
    let (mut matrix, mut potential) = (vec![zero; n * n], zero);
    for (place, monomials) in places {
        let node = polynomial(graph, monomials, order);
        match place {
            Place::Potential => potential = node,
            Place::Inertia(i, j) => (matrix[i * n + j], matrix[j * n + i]) = (node, node),
        }
    }
    let gravity = slopes(graph, &[(potential, graph.constant(1.0))], n);
    let matrix_rates = rates(graph, &matrix, Along::Motion);
    // ½ q̇ᵀMq̇ as entries of M with their weights: q̇ᵢq̇ⱼ, halved on the diagonal.
    let half = graph.constant(0.5);
    let mut weights = Vec::new();
    for (i, j) in (0..n).flat_map(|i| (i..n).map(move |j| (i, j))) {
        let rates = graph.mul(graph.input(Input::Dq(i)), graph.input(Input::Dq(j)));
        let weight = if i == j { graph.mul(half, rates) } else { rates };
        if graph.value(matrix[i * n + j]).is_none() {
            weights.push((matrix[i * n + j], weight));
        }
    }
    let kinetic_slopes = slopes(graph, &weights, n);
    let (mut coriolis, mut torque) = (Vec::new(), Vec::new());
    for (joint, &slope) in kinetic_slopes.iter().enumerate() {
        let row = joint * n..(joint + 1) * n;
        let less = graph.neg(slope);
        let moved = [products(graph, &matrix_rates[row.clone()], Input::Dq), vec![less]].concat();
        coriolis.push(graph.sum(&moved));
        let mut both = products(graph, &matrix[row], Input::Ddq);
        both.extend(moved);
        torque.push(graph.sum(&both));
    }
    Parts { torque, gravity, coriolis, matrix }
}

/// One row of a matrix, each entry times the rate of its joint.
pub(crate) fn products(graph: &Graph, row: &[Id], rate: fn(usize) -> Input) -> Vec<Id> {
    let product = |(joint, &entry)| graph.mul(entry, graph.input(rate(joint)));
    row.iter().enumerate().map(product).collect()
}

/// How terms that differ in their velocities and accelerations are put together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Grouping {
    /// The angles of each product of velocities and accelerations first.
    ByMotion,
    None,
}

pub(crate) fn from_equations(
    graph: &Graph,
    equations: &[Sum],
    order: Order,
    grouping: Grouping,
) -> Parts {
    let n = equations.len();
    let of_kinds = |kinds: &[Kind]| -> Vec<Id> {
        let of_joint = |sum: &Sum| {
            let held = sum.iter().filter(|(_, term)| kinds.contains(&term.kind()));
            equation(graph, held.cloned().collect(), order, grouping)
        };
        equations.iter().map(of_joint).collect()
    };
    let coriolis = of_kinds(&[Kind::Coriolis]);
    let torque = of_kinds(&[Kind::Inertia, Kind::Coriolis]);
    let gravity = of_kinds(&[Kind::Gravity]);
    let entries = equations.iter().flat_map(|row| (0..n).map(move |column| (row, column)));
    // What is left of an equation at q̇ = 0 and q̈ = 1 of one joint, less what is left at q̈ = 0.
    let entry = |(row, column): (&Sum, usize)| {
        let alone =
            |powers: &[u8]| powers.iter().enumerate().all(|(j, &p)| (j == column) == (p > 0));
        let still = |term: &Term| term.dq.iter().all(|&power| power == 0);
        let held = row.iter().filter(|(_, term)| alone(&term.ddq) && still(term));
        let held = held.map(|(weight, term)| (*weight, Term { ddq: vec![0; n], ..term.clone() }));
        equation(graph, held.collect(), order, grouping)
    };
    let matrix = entries.map(entry).collect();
    Parts { torque, gravity, coriolis, matrix }
}

fn equation(graph: &Graph, sum: Sum, order: Order, grouping: Grouping) -> Id {
    let mut groups: BTreeMap<Vec<(Id, u32)>, Vec<Monomial>> = BTreeMap::new();
    for (coefficient, term) in sum {
        let weight = graph.constant(coefficient);
        let mut powers = angles(graph, &term);
        let motions = motions(graph, &term);
        let group = match grouping {
            Grouping::ByMotion => motions.into_iter().collect(),
            Grouping::None => {
                powers.extend(motions);
                Vec::new()
            }
        };
        groups.entry(group).or_default().push(Monomial { weight, powers });
    }
    let part = |(group, monomials): (Vec<(Id, u32)>, _)| {
        let weight = polynomial(graph, monomials, order);
        Monomial { weight, powers: group.into_iter().collect() }
    };
    polynomial(graph, groups.into_iter().map(part).collect(), order)
}

/// F(q, q̇), n: each shaft loads the joints that turn it (17), where gears press harder under load
/// in proportion to |Gⱼ| of its joint (E13).
///
/// - `gravity`: G(q), n
/// - `elements`: whose states are known, in the order of their states
pub(crate) fn friction(
    graph: &Graph,
    terms: &[Weighted<FrictionTerm>],
    gravity: &[Id],
    elements: &[(usize, f64)],
) -> Vec<Id> {
    let mut shafts: Vec<(&FrictionTerm, BTreeMap<Id, f64>)> = Vec::new();
    for Weighted { term, coefficient, .. } in terms {
        let curve = match elements.iter().position(|known| term.element() == Some(*known)) {
            Some(element) => graph.input(Input::Element(element)),
            None => curve(graph, term),
        };
        let alike = |(other, _): &(&FrictionTerm, _)| {
            (&other.shaft, other.load) == (&term.shaft, term.load)
        };
        let place = shafts.iter().position(alike).unwrap_or_else(|| {
            shafts.push((term, BTreeMap::new()));
            shafts.len() - 1
        });
        *shafts[place].1.entry(curve).or_insert(0.0) += coefficient;
    }
    let mut torques = vec![Vec::new(); gravity.len()];
    for (term, curves) in shafts {
        let part = |(node, weight)| graph.mul(graph.constant(weight), node);
        let torque = graph.sum(&curves.into_iter().map(part).collect::<Vec<Id>>());
        let torque = match term.joint().and_then(|joint| gravity.get(joint)) {
            Some(&load) if term.load => graph.mul(graph.abs(load), torque),
            _ => torque,
        };
        for (torques, &share) in torques.iter_mut().zip(&term.shaft) {
            torques.push(graph.mul(graph.constant(share), torque));
        }
    }
    torques.iter().map(|parts| graph.sum(parts)).collect()
}

/// Joint, from 0, and travel \[rad\] of the Dahl elements that terms follow, once each.
pub(crate) fn elements(terms: &[Weighted<FrictionTerm>]) -> Vec<(usize, f64)> {
    let mut elements = Vec::new();
    for element in terms.iter().filter_map(|weighted| weighted.term.element()) {
        if !elements.contains(&element) {
            elements.push(element);
        }
    }
    elements
}

/// The states of Dahl elements after a step from the last positions to q, one each:
/// x ← s + (x − s)·e^(−|Δq|/δ), s = sign Δq, which leaves x as it is at rest (E13).
pub(crate) fn next_states(graph: &Graph, elements: &[(usize, f64)]) -> Vec<Id> {
    let fadings = fadings(graph, elements);
    let next = |(element, (&(joint, _), fading))| {
        let end = graph.call(Function::Sign, way(graph, joint));
        let state = graph.input(Input::Element(element));
        graph.add(end, graph.mul(graph.sub(state, end), fading))
    };
    elements.iter().zip(fadings).enumerate().map(next).collect()
}

/// Δq of a joint since the sample before.
fn way(graph: &Graph, joint: usize) -> Id {
    graph.sub(graph.input(Input::Q(joint)), graph.input(Input::Last(joint)))
}

/// Power up to which one exponential serves several elements: rounding grows with it.
const MOST_POWER: u32 = 512;

/// e^(−|Δq|/δ) of each element: where the next longer travel of the joint is a whole multiple of δ,
/// that power of its own, which costs less than an exponential.
fn fadings(graph: &Graph, elements: &[(usize, f64)]) -> Vec<Id> {
    let mut order: Vec<usize> = (0..elements.len()).collect();
    order.sort_by(|&a, &b| {
        let ((a, long), (b, short)) = (elements[a], elements[b]);
        a.cmp(&b).then(short.total_cmp(&long))
    });
    let mut fadings = vec![graph.constant(0.0); elements.len()];
    // The element before in this order, its fading, and which power of an exponential that is.
    let mut longer: Option<((usize, f64), Id, u32)> = None;
    for place in order {
        let (joint, travel) = elements[place];
        let power = longer.filter(|((other, _), ..)| *other == joint).and_then(
            |((_, long), fading, power)| {
                let is_long =
                    |k: &u32| (f64::from(*k) * travel - long).abs() < 4.0 * f64::EPSILON * long;
                let multiple = (1..=MOST_POWER / power).find(is_long)?;
                Some((graph.power(fading, multiple), power * multiple))
            },
        );
        let (fading, power) = power.unwrap_or_else(|| {
            let way = way(graph, joint);
            let (length, rate) = (graph.abs(way), graph.constant(-1.0 / travel));
            (graph.call(Function::Exp, graph.mul(rate, length)), 1)
        });
        fadings[place] = fading;
        longer = Some((elements[place], fading, power));
    }
    fadings
}

/// f(v) of one law, zero in the direction in which it does not act.
fn curve(graph: &Graph, term: &FrictionTerm) -> Id {
    let part = |(joint, &share)| graph.mul(graph.constant(share), graph.input(Input::Dq(joint)));
    let speed = graph.sum(&term.shaft.iter().enumerate().map(part).collect::<Vec<Id>>());
    let value = match term.law {
        FrictionLaw::Offset => graph.constant(1.0),
        FrictionLaw::Viscous => speed,
        FrictionLaw::Coulomb { width } => sign(graph, speed, width),
        FrictionLaw::Stribeck { speed: stribeck, width } => {
            let ratio = graph.mul(speed, graph.constant(1.0 / stribeck));
            let fading = graph.call(Function::Exp, graph.neg(graph.mul(ratio, ratio)));
            graph.mul(fading, sign(graph, speed, width))
        }
        FrictionLaw::Dahl { .. } => sign(graph, speed, 0.0),
    };
    match term.direction {
        Direction::Both => value,
        Direction::Backward => graph.mul(value, graph.call(Function::Positive, graph.neg(speed))),
    }
}

fn sign(graph: &Graph, speed: Id, width: f64) -> Id {
    if width > 0.0 {
        graph.call(Function::Tanh, graph.mul(speed, graph.constant(1.0 / width)))
    } else {
        graph.call(Function::Sign, speed)
    }
}
