//! A graph of operations in which nothing is computed twice.
//!
//! Nodes are numbered in an order in which they can be computed. A node is made once: whoever asks
//! for the same operation on the same nodes gets the same number, so that a common factor is shared
//! however it came about. Constants are folded, signs are drawn out of products.

use std::cell::RefCell;
use std::collections::HashMap;

pub(crate) type Id = usize;

/// A signal of one joint, counted from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) enum Input {
    /// Its position \[rad\].
    Q(usize),
    /// Its velocity \[rad/s\].
    Dq(usize),
    /// Its acceleration \[rad/s²\].
    Ddq(usize),
    /// Its position one sample before \[rad\].
    Last(usize),
    /// Torque of its motor \[N·m\].
    Tau(usize),
    /// State of a Dahl element, counted from 0.
    Element(usize),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Function {
    Tanh,
    Exp,
    /// −1, 0 or 1
    Sign,
    /// 1 for x > 0, else 0
    Positive,
    Abs,
    /// 1/x
    Reciprocal,
}

#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Node {
    /// A number, by its bits.
    Constant(u64),
    Input(Input),
    /// sin(k·q) with an integer k for each joint.
    Sin(Vec<i32>),
    /// cos(k·q) with an integer k for each joint.
    Cos(Vec<i32>),
    Add(Id, Id),
    Sub(Id, Id),
    Mul(Id, Id),
    Neg(Id),
    Call(Function, Id),
}

impl Node {
    pub(crate) fn operands(&self) -> Vec<Id> {
        match *self {
            Self::Constant(_) | Self::Input(_) | Self::Sin(_) | Self::Cos(_) => Vec::new(),
            Self::Neg(a) | Self::Call(_, a) => vec![a],
            Self::Add(a, b) | Self::Sub(a, b) | Self::Mul(a, b) => vec![a, b],
        }
    }
}

/// Sums are added in chains of this length, and the chains again: short code, and a processor that
/// adds four chains at a time need not wait for one.
const CHAIN: usize = 4;

#[derive(Clone, Debug, Default)]
pub(crate) struct Graph {
    /// Behind cells, so that operations nest as expressions do.
    nodes: RefCell<Vec<Node>>,
    places: RefCell<HashMap<Node, Id>>,
}

impl Graph {
    pub(crate) fn node(&self, id: Id) -> Node {
        self.nodes.borrow()[id].clone()
    }

    pub(crate) fn len(&self) -> usize {
        self.nodes.borrow().len()
    }

    fn put(&self, node: Node) -> Id {
        *self.places.borrow_mut().entry(node).or_insert_with_key(|node| {
            let mut nodes = self.nodes.borrow_mut();
            nodes.push(node.clone());
            nodes.len() - 1
        })
    }

    /// A number; never −0, which nothing tells from 0.
    pub(crate) fn constant(&self, value: f64) -> Id {
        let value = if value == 0.0 { 0.0 } else { value };
        self.put(Node::Constant(value.to_bits()))
    }

    pub(crate) fn value(&self, id: Id) -> Option<f64> {
        match self.nodes.borrow()[id] {
            Node::Constant(bits) => Some(f64::from_bits(bits)),
            _ => None,
        }
    }

    pub(crate) fn constants(&self) -> impl Iterator<Item = f64> {
        (0..self.len()).filter_map(|id| self.value(id))
    }

    fn opposite(&self, id: Id) -> Option<Id> {
        if let Node::Neg(a) = self.nodes.borrow()[id] { Some(a) } else { None }
    }

    pub(crate) fn input(&self, input: Input) -> Id {
        self.put(Node::Input(input))
    }

    /// sin(k·q); the first k that is not zero is made positive.
    pub(crate) fn sin(&self, multiples: &[i32]) -> Id {
        match multiples.iter().find(|k| **k != 0) {
            None => self.constant(0.0),
            Some(k) if *k < 0 => {
                let opposite: Vec<i32> = multiples.iter().map(|k| -k).collect();
                self.neg(self.put(Node::Sin(opposite)))
            }
            Some(_) => self.put(Node::Sin(multiples.to_vec())),
        }
    }

    /// cos(k·q); the first k that is not zero is made positive.
    pub(crate) fn cos(&self, multiples: &[i32]) -> Id {
        match multiples.iter().find(|k| **k != 0) {
            None => self.constant(1.0),
            Some(k) if *k < 0 => self.put(Node::Cos(multiples.iter().map(|k| -k).collect())),
            Some(_) => self.put(Node::Cos(multiples.to_vec())),
        }
    }

    pub(crate) fn add(&self, a: Id, b: Id) -> Id {
        match (self.value(a), self.value(b)) {
            (Some(x), Some(y)) => return self.constant(x + y),
            (Some(0.0), None) => return b,
            (None, Some(0.0)) => return a,
            (Some(x), None) if x < 0.0 => return self.sub(b, self.constant(-x)),
            (None, Some(x)) if x < 0.0 => return self.sub(a, self.constant(-x)),
            _ => {}
        }
        match (self.opposite(a), self.opposite(b)) {
            (_, Some(b)) => self.sub(a, b),
            (Some(a), _) => self.sub(b, a),
            _ => self.put(Node::Add(a.min(b), a.max(b))),
        }
    }

    pub(crate) fn sub(&self, a: Id, b: Id) -> Id {
        if a == b {
            return self.constant(0.0);
        }
        match (self.value(a), self.value(b)) {
            (Some(x), Some(y)) => return self.constant(x - y),
            (Some(0.0), None) => return self.neg(b),
            (None, Some(0.0)) => return a,
            (None, Some(x)) if x < 0.0 => return self.add(a, self.constant(-x)),
            _ => {}
        }
        match (self.opposite(a), self.opposite(b)) {
            (_, Some(b)) => self.add(a, b),
            (Some(a), _) => self.neg(self.add(a, b)),
            _ => self.put(Node::Sub(a, b)),
        }
    }

    pub(crate) fn mul(&self, a: Id, b: Id) -> Id {
        match (self.value(a), self.value(b)) {
            (Some(x), Some(y)) => return self.constant(x * y),
            (Some(x), None) => return self.scaled(x, b),
            (None, Some(x)) => return self.scaled(x, a),
            (None, None) => {}
        }
        match (self.opposite(a), self.opposite(b)) {
            (Some(a), _) => self.neg(self.mul(a, b)),
            (_, Some(b)) => self.neg(self.mul(a, b)),
            _ => self.put(Node::Mul(a.min(b), a.max(b))),
        }
    }

    /// factor·a, the factor first and positive.
    fn scaled(&self, factor: f64, a: Id) -> Id {
        if factor == 0.0 {
            return self.constant(0.0);
        }
        if factor < 0.0 {
            return self.neg(self.scaled(-factor, a));
        }
        if let Some(a) = self.opposite(a) {
            return self.neg(self.scaled(factor, a));
        }
        if (factor - 1.0).abs() == 0.0 {
            return a;
        }
        self.put(Node::Mul(self.constant(factor), a))
    }

    pub(crate) fn neg(&self, a: Id) -> Id {
        match self.node(a) {
            Node::Constant(bits) => self.constant(-f64::from_bits(bits)),
            Node::Neg(a) => a,
            Node::Sub(a, b) => self.sub(b, a),
            _ => self.put(Node::Neg(a)),
        }
    }

    pub(crate) fn call(&self, function: Function, a: Id) -> Id {
        self.put(Node::Call(function, a))
    }

    pub(crate) fn abs(&self, a: Id) -> Id {
        match self.node(a) {
            Node::Constant(bits) => self.constant(f64::from_bits(bits).abs()),
            Node::Neg(a) => self.abs(a),
            _ => self.call(Function::Abs, a),
        }
    }

    /// aᵖ by repeated squares.
    pub(crate) fn power(&self, a: Id, power: u32) -> Id {
        if power == 0 {
            return self.constant(1.0);
        }
        let half = self.power(a, power / 2);
        let even = self.mul(half, half);
        if power.is_multiple_of(2) { even } else { self.mul(even, a) }
    }

    pub(crate) fn sum(&self, parts: &[Id]) -> Id {
        if parts.len() > CHAIN {
            let chains: Vec<Id> = parts.chunks(CHAIN).map(|chain| self.sum(chain)).collect();
            return self.sum(&chains);
        }
        parts.iter().fold(self.constant(0.0), |sum, &part| self.add(sum, part))
    }

    /// Σ k·input over the joints whose k is not zero.
    pub(crate) fn multiple_sum(&self, multiples: &[i32], input: fn(usize) -> Input) -> Id {
        let turning = multiples.iter().enumerate().filter(|&(_, &k)| k != 0);
        let part = |(joint, &k)| self.mul(self.constant(f64::from(k)), self.input(input(joint)));
        self.sum(&turning.map(part).collect::<Vec<Id>>())
    }

    pub(crate) fn product(&self, parts: &[Id]) -> Id {
        parts.iter().fold(self.constant(1.0), |product, &part| self.mul(product, part))
    }

    /// The nodes that some nodes are computed from, and they, in order.
    pub(crate) fn reachable(&self, roots: &[Id]) -> Vec<Id> {
        let nodes = self.nodes.borrow();
        let mut needed = vec![false; nodes.len()];
        for &root in roots {
            needed[root] = true;
        }
        for id in (0..nodes.len()).rev() {
            if needed[id] {
                nodes[id].operands().into_iter().for_each(|operand| needed[operand] = true);
            }
        }
        (0..nodes.len()).filter(|&id| needed[id]).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_same_operation_is_one_node_and_signs_are_drawn_out() {
        let graph = Graph::default();
        let (a, b) = (graph.input(Input::Q(0)), graph.input(Input::Q(1)));

        assert_eq!(graph.mul(a, b), graph.mul(b, a));
        assert_eq!(graph.add(a, b), graph.add(b, a));
        assert_ne!(graph.sub(a, b), graph.sub(b, a));
        let minus = graph.neg(a);

        let scaled = graph.mul(graph.constant(-2.0), minus);
        let sum = graph.add(b, minus);

        assert!(matches!(graph.node(scaled), Node::Mul(..)));
        assert_eq!(graph.sub(b, a), sum);
        assert_eq!(graph.sin(&[-1, 2]), graph.neg(graph.sin(&[1, -2])));
    }
}
