//! From a seed to models of arms that were never fitted, with the sparsity of models that were.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::PI;
use torquewise_model::rigid_chain::{Coupled, Coupling};
use torquewise_model::{
    Direction, Drive, EnergyTerm, Form, FrictionLaw, FrictionTerm, JointKind, Model, Place,
    RigidChain, Stage, Term, Trig, Weighted,
};

/// A state of an arm: q, q̇, q̈.
pub(crate) type State = [Vec<f64>; 3];

pub(crate) fn states(n: usize, count: usize, seed: u64) -> Vec<State> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut signal = |most: f64| (0..n).map(|_| most * (2.0 * rng.random::<f64>() - 1.0)).collect();
    (0..count).map(|_| [signal(PI), signal(3.0), signal(10.0)]).collect()
}

/// A product of up to three functions of angles: sines, powers of cosines, harmonics, sums.
fn function(rng: &mut ChaCha8Rng, n: usize) -> Term {
    let mut term = Term::one(n);
    for _ in 0..rng.random_range(0..4) {
        let trig = if rng.random::<bool>() { Trig::Sin } else { Trig::Cos };
        let (joint, multiple) = (rng.random_range(0..n), *pick(rng, &[1, 1, 1, 2, -1, 3]));
        let power = *pick(rng, &[1, 1, 1, 2, 3]);
        term = term.times(trig, joint, multiple, power);
        if rng.random_range(0..6) == 0
            && let Some(factor) = term.factors.last_mut()
        {
            let other = (joint + 1) % n;
            factor.multiples[other] = *pick(rng, &[1, -1]);
        }
    }
    term
}

fn pick<'a, T>(rng: &mut ChaCha8Rng, from: &'a [T]) -> &'a T {
    &from[rng.random_range(0..from.len())]
}

/// M(q) and V(q) of `count` terms, and friction.
pub(crate) fn energies(n: usize, count: usize, seed: u64) -> Model {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut terms = Vec::new();
    for place in 0..count {
        let place = if place % 4 == 0 {
            Place::Potential
        } else {
            let (i, j) = (rng.random_range(0..n), rng.random_range(0..n));
            Place::Inertia(i.min(j), i.max(j))
        };
        let function = function(&mut rng, n);
        let scale = if place == Place::Potential { 20.0 } else { 1.0 };
        let coefficient = scale * (2.0 * rng.random::<f64>() - 1.0);
        terms.push(Weighted::new(EnergyTerm { place, function }, coefficient));
    }
    let first = terms.iter().filter(|w| w.term.place == Place::Potential).take(5);
    let (name, form) = ("standstill".into(), Form::Energy(first.cloned().collect()));
    let stage = Stage { name, rows: 1, candidates: 1, form, friction: Vec::new() };
    model(n, Form::Energy(terms), friction(n), vec![stage])
}

/// An arm whose second and third axis are parallel: its energies depend on q₂ + q₃, written as
/// products of sines and cosines.
pub(crate) fn parallel(n: usize, count: usize, seed: u64) -> Model {
    let mut model = energies(n, count, seed);
    if let Form::Energy(terms) = &mut model.form {
        let both = |Weighted { term: EnergyTerm { place, function }, coefficient, .. }: &_| {
            let times = |trig| function.clone().times(trig, 1, 1, 1).times(trig, 2, 1, 1);
            [(Trig::Cos, 1.0), (Trig::Sin, -1.0)].map(|(trig, sign)| {
                let term = EnergyTerm { place: *place, function: times(trig) };
                Weighted::new(term, sign * coefficient)
            })
        };
        *terms = terms.iter().flat_map(both).collect();
    }
    model
}

/// Torques of each joint on its own, of `count` terms each.
pub(crate) fn products(n: usize, count: usize, seed: u64) -> Model {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let equation = |rng: &mut ChaCha8Rng| {
        let term = |rng: &mut ChaCha8Rng| {
            let mut term = function(rng, n);
            match rng.random_range(0..4) {
                0 => {}
                1 => term = term.times_ddq(rng.random_range(0..n)),
                _ => {
                    let (i, j) = (rng.random_range(0..n), rng.random_range(0..n));
                    term = term.times_dq(i).times_dq(j);
                }
            }
            Weighted::new(term, 10.0 * (2.0 * rng.random::<f64>() - 1.0))
        };
        (0..count).map(|_| term(rng)).collect()
    };
    let equations = (0..n).map(|_| equation(&mut rng)).collect();
    model(n, Form::Torque(equations), Vec::new(), Vec::new())
}

/// A rigid chain with rotors, one of them on the shaft of two joints, a spring and friction. Of its
/// equations to read only a part is left, as of a model that was fitted.
///
/// - `skew`: whether axes lie anyhow, under tilted gravity, and not mostly at right angles
pub(crate) fn chain(n: usize, skew: bool, seed: u64) -> Model {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut between = |low: f64, high: f64| low + (high - low) * rng.random::<f64>();
    let mut geometry = if skew { vec![0.1, -0.2] } else { vec![0.0, 0.0] };
    let quarter = PI / 2.0;
    let right = [[quarter, 0.0], [0.0, 0.0], [0.0, -quarter], [PI, 0.0], [-quarter, 0.0]];
    for joint in 1..n {
        let direction = right[(joint - 1) % right.len()];
        let off = if skew { between(-0.3, 0.3) } else { 0.0 };
        geometry.extend([direction[0] + off, direction[1] - 0.5 * off]);
        geometry.push(between(-0.5, 0.5));
        geometry.push(if joint % 2 == 0 { 0.0 } else { between(-0.2, 0.2) });
    }
    let link = |_| {
        let [x, y, z] = [0, 1, 2].map(|_| between(-0.4, 0.4));
        let [xx, yy, zz] = [0, 1, 2].map(|_| between(0.5, 0.7));
        let [xy, xz, yz] = [0, 1, 2].map(|_| between(-0.1, 0.1));
        [between(1.0, 4.0), x, y, z, xx, yy, zz, xy, xz, yz]
    };
    let links = (0..n).map(link).collect();
    let mut shafts = [vec![0.0; n], vec![0.0; n]];
    shafts[0][1] = 1.0;
    (shafts[1][n - 2], shafts[1][n - 1]) = (1.0, -0.5);
    let rotors = shafts.into_iter().map(|shaft| Drive::Rotor { shaft, inertia: 0.3 });
    let function = Term::one(n).times(Trig::Cos, 1, 1, 1);
    let term = EnergyTerm { place: Place::Potential, function };
    let drives = rotors.chain([Drive::Energy { term: term.clone(), coefficient: -4.0 }]).collect();
    let chain = RigidChain { geometry, links, drives, ..RigidChain::default() };
    let form = Form::Energy(vec![Weighted::new(term, 1.0)]);
    Model { chain: Some(chain), ..model(n, form, friction(n), Vec::new()) }
}

/// The same behind a parallelogram: the third joint turns with q₃ − q₂, the last with twice the one
/// before it as well.
pub(crate) fn coupled(n: usize, skew: bool, seed: u64) -> Model {
    let mut model = chain(n, skew, seed);
    if let Some(chain) = &mut model.chain {
        chain.coupling = Coupling::default()
            .with(Coupled { joint: n - 1, driver: n - 2, ratio: 2 })
            .with(Coupled { joint: 2, driver: 1, ratio: -1 });
    }
    model
}

/// The same whose second joint slides, and every third beyond it.
pub(crate) fn sliding(n: usize, skew: bool, seed: u64) -> Model {
    let mut model = chain(n, skew, seed);
    if let Some(chain) = &mut model.chain {
        let kind = |joint| if joint % 3 == 1 { JointKind::Prismatic } else { JointKind::Revolute };
        chain.kinds = (0..n).map(kind).collect::<Vec<_>>().into();
        let function = Term::one(n).times(Trig::Position, 1, 1, 2);
        let spring = |drive: &mut Drive| {
            if let Drive::Energy { term, .. } = drive {
                term.function = function.clone();
            }
        };
        chain.drives.iter_mut().for_each(spring);
    }
    model
}

/// Every law, exact and smooth, in both directions and one, on joints and on a coupled shaft.
fn friction(n: usize) -> Vec<Weighted<FrictionTerm>> {
    let mut terms = Vec::new();
    for joint in 0..n {
        let width = if joint % 2 == 0 { 0.02 } else { 0.0 };
        let laws = [
            (FrictionLaw::Offset, Direction::Both),
            (FrictionLaw::Viscous, Direction::Both),
            (FrictionLaw::Viscous, Direction::Backward),
            (FrictionLaw::Coulomb { width }, Direction::Both),
            (FrictionLaw::Stribeck { speed: 0.1, width }, Direction::Backward),
        ];
        for (place, (law, direction)) in laws.into_iter().enumerate() {
            let term = FrictionTerm { direction, ..FrictionTerm::of_joint(n, joint, law) };
            terms.push(Weighted::new(term, 1.5 - 0.4 * place as f64));
        }
    }
    let mut shaft = vec![0.0; n];
    (shaft[n - 2], shaft[n - 1]) = (1.0, -0.5);
    let (law, direction) = (FrictionLaw::Coulomb { width: 0.0 }, Direction::Both);
    terms.push(Weighted::new(FrictionTerm { shaft, law, direction, load: false }, 0.7));
    terms
}

fn model(n: usize, form: Form, friction: Vec<Weighted<FrictionTerm>>, stages: Vec<Stage>) -> Model {
    // Names that a careless printer would break a string or a comment with.
    let names = (0..n).map(|joint| format!("gelenk \"{joint}\" */ ??/ é\\"));
    Model { joints: names.collect(), form, friction, stages, ..Model::default() }
}

/// The same with Dahl elements, two on the second joint, one of which also feels its load, and one
/// on the last.
pub(crate) fn remembers(mut model: Model) -> Model {
    let n = model.n_joints();
    let dahl = |joint, travel| FrictionTerm::of_joint(n, joint, FrictionLaw::Dahl { travel });
    model.friction.extend([
        Weighted::new(dahl(1, 0.01), 2.5),
        Weighted::new(dahl(1, 0.2), 0.7),
        Weighted::new(dahl(1, 0.2).under_load(), 0.1),
        Weighted::new(dahl(n - 1, 0.002), 1.3),
    ]);
    model
}

/// The same with elements of five travels on each joint, each with load and without.
pub(crate) fn remembers_all(mut model: Model) -> Model {
    let n = model.n_joints();
    for (joint, travel) in (0..n).flat_map(|j| [0.0005, 0.002, 0.01, 0.05, 0.2].map(|d| (j, d))) {
        let term = FrictionTerm::of_joint(n, joint, FrictionLaw::Dahl { travel });
        model.friction.push(Weighted::new(term.clone(), 0.3));
        model.friction.push(Weighted::new(term.under_load(), 0.03));
    }
    model
}

/// The same with laws in proportion to the load of a gear, one of them backward alone.
pub(crate) fn loaded(mut model: Model) -> Model {
    let n = model.n_joints();
    for joint in 0..n {
        let law = FrictionLaw::Coulomb { width: 0.02 };
        let term = FrictionTerm::of_joint(n, joint, law).under_load();
        model.friction.push(Weighted::new(term, 0.05 + 0.02 * joint as f64));
    }
    let viscous = FrictionTerm::of_joint(n, 1, FrictionLaw::Viscous).under_load();
    let term = FrictionTerm { direction: Direction::Backward, ..viscous };
    model.friction.push(Weighted::new(term, 0.1));
    model
}

/// A path with reversals, on which each joint rests in every third of its samples, one of them not finite.
pub(crate) fn way(n: usize) -> Vec<State> {
    let mut way = states(n, 600, 11);
    for (row, [q, ..]) in way.iter_mut().enumerate() {
        for (joint, q) in q.iter_mut().enumerate() {
            let time = (row + joint) / 3 * 2 + (row + joint) % 3 / 2;
            *q = 0.1 * (0.05 * time as f64 * (1.0 + joint as f64)).sin();
        }
    }
    way[300][0][1] = f64::NAN;
    way
}
