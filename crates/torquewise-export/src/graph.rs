//! From values to graph of operations in which nothing is computed twice.
//!
//! Nodes are numbered in an order in which they can be computed. A node is made once: whoever asks
//! for the same operation on the same nodes gets the same number, so that a common factor is shared
//! however it came about. Constants are folded, signs are drawn out of products.

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

/// A function of one value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Function {
    /// tanh x
    Tanh,
    /// eˣ
    Exp,
    /// −1, 0 or 1
    Sign,
    /// 1 for x > 0, else 0
    Positive,
    /// |x|
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
    /// The nodes it is computed from.
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

/// Operations, each once.
#[derive(Clone, Debug, Default)]
pub(crate) struct Graph {
    nodes: Vec<Node>,
    places: HashMap<Node, Id>,
}

impl Graph {
    pub(crate) fn node(&self, id: Id) -> &Node {
        &self.nodes[id]
    }

    pub(crate) fn len(&self) -> usize {
        self.nodes.len()
    }

    fn put(&mut self, node: Node) -> Id {
        if let Some(&id) = self.places.get(&node) {
            return id;
        }
        let id = self.nodes.len();
        self.nodes.push(node.clone());
        self.places.insert(node, id);
        id
    }

    /// A number; never −0, which nothing tells from 0.
    pub(crate) fn constant(&mut self, value: f64) -> Id {
        let value = if value == 0.0 { 0.0 } else { value };
        self.put(Node::Constant(value.to_bits()))
    }

    /// The number a node is, if it is one.
    pub(crate) fn value(&self, id: Id) -> Option<f64> {
        match self.nodes[id] {
            Node::Constant(bits) => Some(f64::from_bits(bits)),
            _ => None,
        }
    }

    pub(crate) fn input(&mut self, input: Input) -> Id {
        self.put(Node::Input(input))
    }

    /// sin(k·q); the first k that is not zero is made positive.
    pub(crate) fn sin(&mut self, multiples: &[i32]) -> Id {
        match multiples.iter().find(|k| **k != 0) {
            None => self.constant(0.0),
            Some(k) if *k < 0 => {
                let opposite: Vec<i32> = multiples.iter().map(|k| -k).collect();
                let sine = self.put(Node::Sin(opposite));
                self.neg(sine)
            }
            Some(_) => self.put(Node::Sin(multiples.to_vec())),
        }
    }

    /// cos(k·q); the first k that is not zero is made positive.
    pub(crate) fn cos(&mut self, multiples: &[i32]) -> Id {
        match multiples.iter().find(|k| **k != 0) {
            None => self.constant(1.0),
            Some(k) if *k < 0 => self.put(Node::Cos(multiples.iter().map(|k| -k).collect())),
            Some(_) => self.put(Node::Cos(multiples.to_vec())),
        }
    }

    pub(crate) fn add(&mut self, a: Id, b: Id) -> Id {
        match (self.value(a), self.value(b)) {
            (Some(x), Some(y)) => return self.constant(x + y),
            (Some(0.0), None) => return b,
            (None, Some(0.0)) => return a,
            (Some(x), None) if x < 0.0 => return self.less(b, -x),
            (None, Some(x)) if x < 0.0 => return self.less(a, -x),
            _ => {}
        }
        match (&self.nodes[a], &self.nodes[b]) {
            (_, &Node::Neg(b)) => self.sub(a, b),
            (&Node::Neg(a), _) => self.sub(b, a),
            _ => self.put(Node::Add(a.min(b), a.max(b))),
        }
    }

    fn less(&mut self, a: Id, by: f64) -> Id {
        let by = self.constant(by);
        self.sub(a, by)
    }

    pub(crate) fn sub(&mut self, a: Id, b: Id) -> Id {
        if a == b {
            return self.constant(0.0);
        }
        match (self.value(a), self.value(b)) {
            (Some(x), Some(y)) => return self.constant(x - y),
            (Some(0.0), None) => return self.neg(b),
            (None, Some(0.0)) => return a,
            (None, Some(x)) if x < 0.0 => {
                let opposite = self.constant(-x);
                return self.add(a, opposite);
            }
            _ => {}
        }
        match (&self.nodes[a], &self.nodes[b]) {
            (_, &Node::Neg(b)) => self.add(a, b),
            (&Node::Neg(a), _) => {
                let sum = self.add(a, b);
                self.neg(sum)
            }
            _ => self.put(Node::Sub(a, b)),
        }
    }

    pub(crate) fn mul(&mut self, a: Id, b: Id) -> Id {
        match (self.value(a), self.value(b)) {
            (Some(x), Some(y)) => return self.constant(x * y),
            (Some(x), None) => return self.scaled(x, b),
            (None, Some(x)) => return self.scaled(x, a),
            (None, None) => {}
        }
        match (&self.nodes[a], &self.nodes[b]) {
            (&Node::Neg(a), _) => self.neg_product(a, b),
            (_, &Node::Neg(b)) => self.neg_product(a, b),
            _ => self.put(Node::Mul(a.min(b), a.max(b))),
        }
    }

    fn neg_product(&mut self, a: Id, b: Id) -> Id {
        let product = self.mul(a, b);
        self.neg(product)
    }

    /// factor·a, the factor first and positive.
    fn scaled(&mut self, factor: f64, a: Id) -> Id {
        if factor == 0.0 {
            return self.constant(0.0);
        }
        if factor < 0.0 {
            let opposite = self.scaled(-factor, a);
            return self.neg(opposite);
        }
        if let Node::Neg(a) = self.nodes[a] {
            let opposite = self.scaled(factor, a);
            return self.neg(opposite);
        }
        if (factor - 1.0).abs() == 0.0 {
            return a;
        }
        let factor = self.constant(factor);
        self.put(Node::Mul(factor, a))
    }

    pub(crate) fn neg(&mut self, a: Id) -> Id {
        match self.nodes[a] {
            Node::Constant(bits) => self.constant(-f64::from_bits(bits)),
            Node::Neg(a) => a,
            Node::Sub(a, b) => self.sub(b, a),
            _ => self.put(Node::Neg(a)),
        }
    }

    pub(crate) fn call(&mut self, function: Function, a: Id) -> Id {
        self.put(Node::Call(function, a))
    }

    pub(crate) fn abs(&mut self, a: Id) -> Id {
        match self.nodes[a] {
            Node::Constant(bits) => self.constant(f64::from_bits(bits).abs()),
            Node::Neg(a) => self.abs(a),
            _ => self.call(Function::Abs, a),
        }
    }

    /// aᵖ by repeated squares.
    pub(crate) fn power(&mut self, a: Id, power: u32) -> Id {
        if power == 0 {
            return self.constant(1.0);
        }
        let half = self.power(a, power / 2);
        let even = self.mul(half, half);
        if power.is_multiple_of(2) { even } else { self.mul(even, a) }
    }

    pub(crate) fn sum(&mut self, parts: &[Id]) -> Id {
        if parts.len() > CHAIN {
            let chains: Vec<Id> = parts.chunks(CHAIN).map(|chain| self.sum(chain)).collect();
            return self.sum(&chains);
        }
        let zero = self.constant(0.0);
        parts.iter().fold(zero, |sum, &part| self.add(sum, part))
    }

    pub(crate) fn product(&mut self, parts: &[Id]) -> Id {
        let one = self.constant(1.0);
        parts.iter().fold(one, |product, &part| self.mul(product, part))
    }

    /// The nodes that some nodes are computed from, and they, in order.
    pub(crate) fn reachable(&self, roots: &[Id]) -> Vec<Id> {
        let mut needed = vec![false; self.nodes.len()];
        for &root in roots {
            needed[root] = true;
        }
        for id in (0..self.nodes.len()).rev() {
            if needed[id] {
                for operand in self.nodes[id].operands() {
                    needed[operand] = true;
                }
            }
        }
        (0..self.nodes.len()).filter(|&id| needed[id]).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_same_operation_is_one_node() {
        let mut graph = Graph::default();
        let (a, b) = (graph.input(Input::Q(0)), graph.input(Input::Q(1)));

        assert_eq!(graph.mul(a, b), graph.mul(b, a));
        assert_eq!(graph.add(a, b), graph.add(b, a));
        assert_ne!(graph.sub(a, b), graph.sub(b, a));
    }

    #[test]
    fn signs_are_drawn_out_and_cancel() {
        let mut graph = Graph::default();
        let (a, b) = (graph.input(Input::Q(0)), graph.input(Input::Q(1)));
        let minus = graph.neg(a);
        let two = graph.constant(-2.0);

        let scaled = graph.mul(two, minus);
        let sum = graph.add(b, minus);

        assert!(matches!(graph.node(scaled), Node::Mul(..)));
        assert_eq!(graph.sub(b, a), sum);
        assert_eq!(graph.sin(&[-1, 2]), {
            let sine = graph.sin(&[1, -2]);
            graph.neg(sine)
        });
    }

    #[test]
    fn nothing_is_added_or_multiplied_in_vain() {
        let mut graph = Graph::default();
        let a = graph.input(Input::Dq(0));
        let (zero, one) = (graph.constant(-0.0), graph.constant(1.0));

        assert_eq!((graph.add(a, zero), graph.mul(one, a)), (a, a));
        assert_eq!(graph.mul(a, zero), zero);
        assert_eq!(graph.power(a, 0), one);
    }
}
