//! From nodes to their derivatives: along a motion forward, by all angles at once backward.
//!
//! The rates of M(q) along a motion cost about twice M(q), the slopes of an energy by all n angles
//! about thrice the energy (Griewank and Walther, *Evaluating Derivatives*, 2008, ch. 3); terms
//! differentiated one by one would cost n times as much.

use crate::graph::{Graph, Id, Input, Node};
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
pub(crate) fn rates(graph: &mut Graph, roots: &[Id], along: Along) -> Vec<Id> {
    let mut rates: BTreeMap<Id, Id> = BTreeMap::new();
    let (zero, one) = (graph.constant(0.0), graph.constant(1.0));
    for id in graph.reachable(roots) {
        let rate_of = |operand: Id| rates.get(&operand).copied().unwrap_or(zero);
        let rate = match graph.node(id).clone() {
            Node::Sin(_) | Node::Cos(_) if along != Along::Motion => zero,
            Node::Input(Input::Dq(joint)) if along == Along::Velocity(joint) => one,
            Node::Sin(multiples) => {
                let (slope, speed) = (graph.cos(&multiples), angle_rate(graph, &multiples));
                graph.mul(slope, speed)
            }
            Node::Cos(multiples) => {
                let (slope, speed) = (graph.sin(&multiples), angle_rate(graph, &multiples));
                let rate = graph.mul(slope, speed);
                graph.neg(rate)
            }
            Node::Add(a, b) => graph.add(rate_of(a), rate_of(b)),
            Node::Sub(a, b) => graph.sub(rate_of(a), rate_of(b)),
            Node::Mul(a, b) => {
                let (left, right) = (graph.mul(rate_of(a), b), graph.mul(a, rate_of(b)));
                graph.add(left, right)
            }
            Node::Neg(a) => graph.neg(rate_of(a)),
            Node::Constant(_) | Node::Input(_) | Node::Call(..) => zero,
        };
        rates.insert(id, rate);
    }
    roots.iter().map(|root| rates[root]).collect()
}

/// k·q̇
fn angle_rate(graph: &mut Graph, multiples: &[i32]) -> Id {
    let mut parts = Vec::new();
    for (joint, &k) in multiples.iter().enumerate().filter(|&(_, &k)| k != 0) {
        let (factor, speed) = (graph.constant(f64::from(k)), graph.input(Input::Dq(joint)));
        parts.push(graph.mul(factor, speed));
    }
    graph.sum(&parts)
}

/// ∂/∂q of Σ weight·node over nodes of q alone, where weights are held fixed.
///
/// - `weighted`: (node, its weight, which may be any node)
/// - returns: one node per joint, n
pub(crate) fn slopes(graph: &mut Graph, weighted: &[(Id, Id)], n_joints: usize) -> Vec<Id> {
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
        match graph.node(id).clone() {
            Node::Sin(multiples) => {
                let slope = graph.cos(&multiples);
                let part = graph.mul(adjoint, slope);
                by_angle.entry(multiples).or_default().push(part);
            }
            Node::Cos(multiples) => {
                let slope = graph.sin(&multiples);
                let part = graph.mul(adjoint, slope);
                let part = graph.neg(part);
                by_angle.entry(multiples).or_default().push(part);
            }
            Node::Add(a, b) => [a, b].into_iter().for_each(|operand| hand(operand, adjoint)),
            Node::Sub(a, b) => {
                hand(a, adjoint);
                hand(b, graph.neg(adjoint));
            }
            Node::Mul(a, b) => {
                let (to_a, to_b) = (depends(graph, a), depends(graph, b));
                if to_a {
                    hand(a, graph.mul(adjoint, b));
                }
                if to_b {
                    hand(b, graph.mul(adjoint, a));
                }
            }
            Node::Neg(a) => hand(a, graph.neg(adjoint)),
            Node::Constant(_) | Node::Input(_) | Node::Call(..) => {}
        }
    }
    by_joint(graph, &by_angle, n_joints)
}

/// Slopes by the angles k·q → slopes by each q.
fn by_joint(graph: &mut Graph, by_angle: &BTreeMap<Vec<i32>, Vec<Id>>, n_joints: usize) -> Vec<Id> {
    let mut joints = vec![Vec::new(); n_joints];
    for (multiples, parts) in by_angle {
        let slope = graph.sum(parts);
        for (joint, &k) in multiples.iter().enumerate().filter(|&(_, &k)| k != 0) {
            let factor = graph.constant(f64::from(k));
            joints[joint].push(graph.mul(factor, slope));
        }
    }
    joints.iter().map(|parts| graph.sum(parts)).collect()
}

/// A number has no slope.
fn depends(graph: &Graph, id: Id) -> bool {
    graph.value(id).is_none()
}
