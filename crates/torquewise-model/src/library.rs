//! The candidates: the product library F₁·F₂ and the energy library.

use crate::expansion::Basis;
use crate::{EnergyTerm, Kind, Place, Term, Trig};
use torquewise_rigid::{Functions, JointKind};

/// Degree in the velocities and in the accelerations of a group of motion functions F₂.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Degree {
    /// Degree in q̇.
    pub velocity: u8,
    /// Degree in q̈.
    pub acceleration: u8,
}

impl Degree {
    /// F₂ of a step: 1 at standstill (14), products of two velocities at uniform velocity (15), one
    /// acceleration at variable velocity, which is what (16) adds to the earlier steps. Of the laws
    /// of friction (17) this library holds one, the viscous.
    pub fn of(kind: Kind) -> Self {
        match kind {
            Kind::Friction => Self { velocity: 1, acceleration: 0 },
            Kind::Gravity => Self { velocity: 0, acceleration: 0 },
            Kind::Coriolis => Self { velocity: 2, acceleration: 0 },
            Kind::Inertia => Self { velocity: 0, acceleration: 1 },
        }
    }

    /// All of F₂ up to a total degree, for one-shot SINDy.
    pub fn up_to(total: u8) -> Vec<Self> {
        let of = |degree: u8| {
            (0..=degree).map(move |own| Self { velocity: degree - own, acceleration: own })
        };
        (0..=total).flat_map(of).collect()
    }
}

/// F₁ (11) without repeats (E2), at most `order` factors: sinᵃ·cosᵇ of a joint that turns, a ∈ {0, 1},
/// and q or q² of one that slides (E26).
pub fn angle_functions(kinds: &[JointKind], order: u8) -> Vec<Term> {
    let mut functions = vec![(Term::one(kinds.len()), 0)];
    for (joint, &kind) in kinds.iter().enumerate() {
        let (first, most, cosines) = match kind.functions {
            Functions::Harmonics => (Trig::Sin, 1, order),
            Functions::Powers => (Trig::Position, MOST_POWER, 0),
        };
        let mut longer = Vec::new();
        for (term, used) in functions {
            for power in 0..=most.min(order - used) {
                for cosines in 0..=cosines.min(order - used - power) {
                    let grown = term.clone().times(first, joint, 1, power);
                    let grown = grown.times(Trig::Cos, joint, 1, cosines);
                    longer.push((grown, used + power + cosines));
                }
            }
        }
        functions = longer;
    }
    functions.sort_by_key(|(_, used)| *used);
    functions.into_iter().map(|(term, _)| term).collect()
}

/// The energy of a chain holds no higher power of the position of a joint that slides.
const MOST_POWER: u8 = 2;

/// The powers of all monomials of exactly one degree.
fn monomials(n: usize, degree: u8) -> Vec<Vec<u8>> {
    if n == 0 {
        return if degree == 0 { vec![Vec::new()] } else { Vec::new() };
    }
    let beginning = |first: u8| {
        let rest = monomials(n - 1, degree - first).into_iter();
        rest.map(move |rest| [vec![first], rest].concat())
    };
    (0..=degree).rev().flat_map(beginning).collect()
}

/// The product library F = F₁·F₂ (13), without repeats.
///
/// - `trig_order`: N₁
/// - `degrees`: which groups of F₂
///
/// Sizes for three joints, N₁ = 4: 129 times 28 for all of F₂ up to N₂ = 2.
pub fn product_library(kinds: &[JointKind], trig_order: u8, degrees: &[Degree]) -> Vec<Term> {
    let (n_joints, angles) = (kinds.len(), angle_functions(kinds, trig_order));
    // F₂ (12): monomials in q̇ and q̈.
    let mut motions = Vec::new();
    for degree in degrees {
        let accelerations = monomials(n_joints, degree.acceleration);
        for dq in monomials(n_joints, degree.velocity) {
            let with = |ddq: &Vec<u8>| Term { factors: vec![], dq: dq.clone(), ddq: ddq.clone() };
            motions.extend(accelerations.iter().map(with));
        }
    }
    let product =
        |angle: &Term, motion: &Term| Term { factors: angle.factors.clone(), ..motion.clone() };
    angles.iter().flat_map(|angle| motions.iter().map(|motion| product(angle, motion))).collect()
}

/// The energy library (E4): every function that M(q) and V(q) of a serial arm can hold (E26), of
/// revolute joints Σ_{i<j} 3^{j−i} 5^{n−j} + Σᵢ 5^{n−i} + 3ⁿ − 1 of them.
///
/// - `interaction`: how many joint positions a function may depend on; `None` for no limit
pub fn energy_library(kinds: &[JointKind], interaction: Option<usize>) -> Vec<EnergyTerm> {
    let limit = interaction.unwrap_or(kinds.len());
    let of_place = |(place, bases): (Place, Vec<Basis>)| {
        // A constant of V is no torque.
        let constants = usize::from(place == Place::Potential);
        let functions = functions(&bases, limit).into_iter().skip(constants);
        functions.map(move |function| EnergyTerm { place, function })
    };
    parts(kinds).flat_map(of_place).collect()
}

/// V(q) and each entry of M(q), with what may stand there of each joint: V is linear in all, Mᵢⱼ
/// independent of the joints up to i, linear in those between, and quadratic in those beyond j.
fn parts(kinds: &[JointKind]) -> impl Iterator<Item = (Place, Vec<Basis>)> {
    let n = kinds.len();
    let bases = move |degree: &dyn Fn(usize) -> usize| -> Vec<Basis> {
        kinds.iter().enumerate().map(|(joint, &kind)| Basis::new(kind, degree(joint))).collect()
    };
    let inertia = move |(i, j)| {
        let degree = move |joint: usize| usize::from(joint > i) + usize::from(joint > j);
        (Place::Inertia(i, j), bases(&degree))
    };
    let entries = (0..n).flat_map(move |i| (i..n).map(move |j| (i, j)));
    std::iter::once((Place::Potential, bases(&|_| 1))).chain(entries.map(inertia))
}

/// How many terms [`product_library`] lists, told without listing them; at most `usize::MAX`.
pub fn product_library_size(kinds: &[JointKind], trig_order: u8, degrees: &[Degree]) -> usize {
    // Of one joint: 1, and a sine or none with cosines, two of each order above; or 1, q and q².
    let of_joint = |kind: JointKind, order: usize| match kind.functions {
        _ if order == 0 => 1,
        Functions::Harmonics => 2,
        Functions::Powers => usize::from(order <= MOST_POWER.into()),
    };
    let mut of_order = vec![0_usize; usize::from(trig_order) + 1];
    of_order[0] = 1;
    for &kind in kinds {
        let grown = |order: usize| {
            saturating((0..=order).map(|own| (of_order[order - own], of_joint(kind, own))))
        };
        of_order = (0..of_order.len()).map(grown).collect();
    }
    let angles = saturating(of_order.into_iter().map(|count| (count, 1)));
    let n = kinds.len();
    let motions = degrees
        .iter()
        .map(|degree| (n_monomials(n, degree.velocity), n_monomials(n, degree.acceleration)));
    angles.saturating_mul(saturating(motions))
}

/// How many monomials of a degree n variables have: C(n + degree − 1, degree).
fn n_monomials(n: usize, degree: u8) -> usize {
    let mut of_degree = vec![0_usize; usize::from(degree) + 1];
    of_degree[0] = 1;
    for _ in 0..n {
        for degree in 1..of_degree.len() {
            of_degree[degree] = of_degree[degree].saturating_add(of_degree[degree - 1]);
        }
    }
    of_degree[usize::from(degree)]
}

/// How many terms [`energy_library`] lists, told without listing them; at most `usize::MAX`.
pub fn energy_library_size(kinds: &[JointKind], interaction: Option<usize>) -> usize {
    let limit = interaction.unwrap_or(kinds.len()).min(kinds.len());
    // By how many positions a function depends on.
    let count = |(_, bases): (Place, Vec<Basis>)| {
        let mut of_positions = vec![0_usize; limit + 1];
        of_positions[0] = 1;
        for basis in bases {
            for positions in (1..=limit).rev() {
                let more = of_positions[positions - 1].saturating_mul(basis.size() - 1);
                of_positions[positions] = of_positions[positions].saturating_add(more);
            }
        }
        saturating(of_positions.into_iter().map(|count| (count, 1)))
    };
    parts(kinds).map(count).fold(0, usize::saturating_add) - 1
}

fn saturating(products: impl Iterator<Item = (usize, usize)>) -> usize {
    products.fold(0, |sum: usize, (a, b)| sum.saturating_add(a.saturating_mul(b)))
}

/// Products over the joints of one function of each, the constant first, of at most `limit` joints.
fn functions(bases: &[Basis], limit: usize) -> Vec<Term> {
    let mut functions = vec![Term::one(bases.len())];
    for (joint, basis) in bases.iter().enumerate() {
        let mut longer = Vec::new();
        for term in functions {
            if term.factors.len() < limit {
                longer.extend((1..basis.size()).map(|k| basis.factor(term.clone(), joint, k)));
            }
            longer.push(term);
        }
        functions = longer;
    }
    functions.sort_by_key(|term| term.factors.len());
    functions
}

#[cfg(test)]
mod tests {
    use super::*;

    const THREE: [JointKind; 3] = [JointKind::Revolute; 3];

    #[test]
    fn a13_libraries_are_counted_as_they_are_listed() {
        use JointKind::{Prismatic as P, Revolute as R};
        let all: [&[JointKind]; 6] = [&[R], &[P], &[R, R], &[R, P, R], &[P; 3], &[R; 4]];
        for kinds in all {
            for order in 1..=4 {
                for degrees in [Degree::up_to(2), vec![Degree::of(Kind::Coriolis)]] {
                    let listed = product_library(kinds, order, &degrees).len();
                    let counted = product_library_size(kinds, order, &degrees);
                    assert_eq!(counted, listed, "{kinds:?} {order}");
                }
                let listed = energy_library(kinds, Some(order.into())).len();
                let counted = energy_library_size(kinds, Some(order.into()));
                assert_eq!(counted, listed, "{kinds:?} {order}");
            }
            let listed = energy_library(kinds, None).len();
            assert_eq!(energy_library_size(kinds, None), listed, "{kinds:?}");
        }
        assert_eq!(product_library_size(&[R; 1000], 255, &Degree::up_to(255)), usize::MAX);
    }

    #[test]
    fn product_libraries_have_the_sizes_of_the_method() {
        let whole = product_library(&THREE, 4, &Degree::up_to(2));
        let steps = [(Kind::Gravity, 2), (Kind::Coriolis, 4), (Kind::Inertia, 4)]
            .map(|(kind, order)| product_library(&THREE, order, &[Degree::of(kind)]).len());

        assert_eq!(whole.len(), 3612);
        assert_eq!(steps, [25, 774, 387]);
    }

    #[test]
    fn energy_libraries_have_the_sizes_of_the_method() {
        let sizes: Vec<usize> =
            (3..=6).map(|n| energy_library(&[JointKind::Revolute; 6][..n], None).len()).collect();

        assert_eq!(sizes, [84, 410, 2013, 9947]);
    }

    #[test]
    fn no_candidate_comes_twice() {
        let mut terms = product_library(&THREE, 3, &Degree::up_to(2));
        let mut energies = energy_library(&[JointKind::Revolute; 4], Some(2));
        let before = (terms.len(), energies.len());

        terms.sort();
        terms.dedup();
        energies.sort();
        energies.dedup();

        assert_eq!((terms.len(), energies.len()), before);
        assert!(energies.iter().all(|energy| energy.function.interaction() <= 2));
    }
}
