//! Derivatives of a graph: forward along a motion, backward by all angles at once.
//!
//! The rates of M(q) along a motion cost about twice M(q), the slopes of an energy by all n angles
//! about thrice the energy (Griewank and Walther, *Evaluating Derivatives*, 2008, ch. 3); terms
//! differentiated one by one would cost n times as much.

use crate::{Graph, Id, Input, Node};
use std::collections::BTreeMap;

/// What moves while all else is held fixed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Along {
    /// q, with q̇.
    Motion,
    /// The velocity of one joint, with 1.
    Velocity(usize),
}

/// Derivatives of nodes of q and q̇ along what moves.
///
/// - returns: one node for each of `roots`
pub(crate) fn rates(graph: &Graph, roots: &[Id], along: Along) -> Vec<Id> {
    let mut rates: BTreeMap<Id, Id> = BTreeMap::new();
    let (zero, one) = (graph.constant(0.0), graph.constant(1.0));
    let angle_rate = |multiples: &[i32]| graph.multiple_sum(multiples, Input::Dq);
    for id in graph.reachable(roots) {
        let rate_of = |operand: Id| rates.get(&operand).copied().unwrap_or(zero);
        let rate = match graph.node(id) {
            Node::Sin(_) | Node::Cos(_) if along != Along::Motion => zero,
            Node::Input(Input::Q(joint)) if along == Along::Motion => graph.input(Input::Dq(joint)),
            Node::Input(Input::Dq(joint)) if along == Along::Velocity(joint) => one,
            Node::Sin(multiples) => graph.mul(graph.cos(&multiples), angle_rate(&multiples)),
            Node::Cos(multiples) => {
                graph.neg(graph.mul(graph.sin(&multiples), angle_rate(&multiples)))
            }
            Node::Add(a, b) => graph.add(rate_of(a), rate_of(b)),
            Node::Sub(a, b) => graph.sub(rate_of(a), rate_of(b)),
            Node::Mul(a, b) => graph.add(graph.mul(rate_of(a), b), graph.mul(a, rate_of(b))),
            Node::Neg(a) => graph.neg(rate_of(a)),
            Node::Constant(_) | Node::Input(_) | Node::Call(..) => zero,
        };
        rates.insert(id, rate);
    }
    roots.iter().map(|root| rates[root]).collect()
}

/// ∂/∂q of Σ weight·node over nodes of q alone, where weights are held fixed.
///
/// - `weighted`: (node, its weight, which may be any node)
/// - returns: one node per joint, n
pub(crate) fn slopes(graph: &Graph, weighted: &[(Id, Id)], n_joints: usize) -> Vec<Id> {
    let roots: Vec<Id> = weighted.iter().map(|(root, _)| *root).collect();
    let order = graph.reachable(&roots);
    let mut adjoints: BTreeMap<Id, Vec<Id>> = BTreeMap::new();
    for &(root, weight) in weighted {
        adjoints.entry(root).or_default().push(weight);
    }
    let mut by_angle: BTreeMap<Vec<i32>, Vec<Id>> = BTreeMap::new();
    for id in order.into_iter().rev() {
        let Some(parts) = adjoints.remove(&id) else { continue };
        let adjoint = graph.sum(&parts);
        let mut hand = |operand: Id, part: Id| adjoints.entry(operand).or_default().push(part);
        match graph.node(id) {
            Node::Sin(multiples) => {
                let part = graph.mul(adjoint, graph.cos(&multiples));
                by_angle.entry(multiples).or_default().push(part);
            }
            Node::Cos(multiples) => {
                let part = graph.neg(graph.mul(adjoint, graph.sin(&multiples)));
                by_angle.entry(multiples).or_default().push(part);
            }
            Node::Input(Input::Q(joint)) => {
                let own = (0..n_joints).map(|other| i32::from(other == joint)).collect();
                by_angle.entry(own).or_default().push(adjoint);
            }
            Node::Add(a, b) => [a, b].into_iter().for_each(|operand| hand(operand, adjoint)),
            Node::Sub(a, b) => {
                hand(a, adjoint);
                hand(b, graph.neg(adjoint));
            }
            Node::Mul(a, b) => {
                for (operand, factor) in [(a, b), (b, a)] {
                    // A number has no slope.
                    if graph.value(operand).is_none() {
                        hand(operand, graph.mul(adjoint, factor));
                    }
                }
            }
            Node::Neg(a) => hand(a, graph.neg(adjoint)),
            Node::Constant(_) | Node::Input(_) | Node::Call(..) => {}
        }
    }
    // From slopes by the angles k·q, or positions, to those by each q.
    let mut joints = vec![Vec::new(); n_joints];
    for (multiples, parts) in by_angle {
        let slope = graph.sum(&parts);
        for (joint, &k) in multiples.iter().enumerate().filter(|&(_, &k)| k != 0) {
            joints[joint].push(graph.mul(graph.constant(f64::from(k)), slope));
        }
    }
    joints.iter().map(|parts| graph.sum(parts)).collect()
}
