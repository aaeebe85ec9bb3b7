//! A graph rewritten so that its only angle functions are sin q and cos q of each joint.
//!
//! Harmonics and sums of angles follow from these by cos(a + b) = cos a cos b − sin a sin b and
//! sin(a + b) = sin a cos b + cos a sin b. Derivatives are taken before this, where the sine of a
//! sum is still one function.

use crate::{Graph, Id, Node};
use std::collections::HashMap;

/// The same nodes in a graph that holds nothing else.
pub(crate) fn lowered(graph: &Graph, roots: &[Id]) -> (Graph, Vec<Id>) {
    let mut lower = Lower { target: Graph::default(), angles: HashMap::new() };
    let order = graph.reachable(roots);
    let mut places: HashMap<Id, Id> = HashMap::new();
    for id in order {
        let at = |operand: Id| places[&operand];
        let place = match graph.node(id) {
            Node::Constant(bits) => lower.target.constant(f64::from_bits(bits)),
            Node::Input(input) => lower.target.input(input),
            Node::Sin(multiples) => lower.angle(&multiples)[0],
            Node::Cos(multiples) => lower.angle(&multiples)[1],
            Node::Add(a, b) => lower.target.add(at(a), at(b)),
            Node::Sub(a, b) => lower.target.sub(at(a), at(b)),
            Node::Mul(a, b) => lower.target.mul(at(a), at(b)),
            Node::Neg(a) => lower.target.neg(at(a)),
            Node::Call(function, a) => lower.target.call(function, at(a)),
        };
        places.insert(id, place);
    }
    let roots = roots.iter().map(|root| places[root]).collect();
    (lower.target, roots)
}

struct Lower {
    target: Graph,
    /// Sine and cosine of k·q.
    angles: HashMap<Vec<i32>, [Id; 2]>,
}

impl Lower {
    /// sin and cos of k·q; k of the first joint that turns it is positive, as the graph keeps it,
    /// but here any sign will do.
    fn angle(&mut self, multiples: &[i32]) -> [Id; 2] {
        if let Some(&known) = self.angles.get(multiples) {
            return known;
        }
        let turning: Vec<usize> = (0..multiples.len()).filter(|&j| multiples[j] != 0).collect();
        let made = match turning[..] {
            [] => [0.0, 1.0].map(|x| self.target.constant(x)),
            [joint] => self.harmonic(multiples, joint),
            [.., last] => {
                let (mut head, mut tail) = (multiples.to_vec(), vec![0; multiples.len()]);
                tail[last] = head[last];
                head[last] = 0;
                let (head, tail) = (self.angle(&head), self.angle(&tail));
                self.sum(head, tail)
            }
        };
        self.angles.insert(multiples.to_vec(), made);
        made
    }

    /// sin and cos of k·q of one joint.
    fn harmonic(&mut self, multiples: &[i32], joint: usize) -> [Id; 2] {
        let k = multiples[joint];
        let of = |k: i32| {
            let mut multiples = vec![0; multiples.len()];
            multiples[joint] = k;
            multiples
        };
        if k < 0 {
            let [sin, cos] = self.angle(&of(-k));
            return [self.target.neg(sin), cos];
        }
        if k == 1 {
            return [self.target.sin(multiples), self.target.cos(multiples)];
        }
        let (left, right) = (self.angle(&of(k / 2)), self.angle(&of(k - k / 2)));
        self.sum(left, right)
    }

    fn sum(&mut self, [sin_a, cos_a]: [Id; 2], [sin_b, cos_b]: [Id; 2]) -> [Id; 2] {
        let graph = &self.target;
        let (cc, ss) = (graph.mul(cos_a, cos_b), graph.mul(sin_a, sin_b));
        let sin = graph.add(graph.mul(sin_a, cos_b), graph.mul(cos_a, sin_b));
        [sin, graph.sub(cc, ss)]
    }
}
