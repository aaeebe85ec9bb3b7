//! The candidates: the product library F₁·F₂ and the energy library.

use crate::energy::{EnergyTerm, Place};
use crate::term::{Kind, Term, Trig};

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
        (0..=total)
            .flat_map(|degree| {
                (0..=degree)
                    .map(move |acceleration| Self { velocity: degree - acceleration, acceleration })
            })
            .collect()
    }
}

/// F₁ (11) without repeats (E2): per joint sinᵃ·cosᵇ with a ∈ {0, 1}, at most `order` factors.
pub fn angle_functions(n_joints: usize, order: u8) -> Vec<Term> {
    let mut functions = vec![(Term::one(n_joints), 0)];
    for joint in 0..n_joints {
        let mut longer = Vec::new();
        for (term, used) in functions {
            for sines in 0..=1.min(order - used) {
                for cosines in 0..=order - used - sines {
                    let grown = term.clone().times(Trig::Sin, joint, 1, sines);
                    let grown = grown.times(Trig::Cos, joint, 1, cosines);
                    longer.push((grown, used + sines + cosines));
                }
            }
        }
        functions = longer;
    }
    functions.sort_by_key(|(_, used)| *used);
    functions.into_iter().map(|(term, _)| term).collect()
}

/// The powers of all monomials of exactly one degree.
fn monomials(n: usize, degree: u8) -> Vec<Vec<u8>> {
    if n == 0 {
        return if degree == 0 { vec![Vec::new()] } else { Vec::new() };
    }
    (0..=degree)
        .rev()
        .flat_map(|first| {
            monomials(n - 1, degree - first).into_iter().map(move |mut rest| {
                rest.insert(0, first);
                rest
            })
        })
        .collect()
}

/// The product library F = F₁·F₂ (13), without repeats.
///
/// - `trig_order`: N₁
/// - `degrees`: which groups of F₂
///
/// Sizes for three joints, N₁ = 4: 129 times 28 for all of F₂ up to N₂ = 2.
pub fn product_library(n_joints: usize, trig_order: u8, degrees: &[Degree]) -> Vec<Term> {
    let angles = angle_functions(n_joints, trig_order);
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

/// The energy library (E4): every function that M(q) and V(q) of a serial arm of revolute joints
/// can hold, which is Σ_{i<j} 3^{j−i} 5^{n−j} + Σᵢ 5^{n−i} + 3ⁿ − 1 of them.
///
/// - `interaction`: how many joint angles a function may depend on; `None` for no limit
pub fn energy_library(n_joints: usize, interaction: Option<usize>) -> Vec<EnergyTerm> {
    let limit = interaction.unwrap_or(n_joints);
    let mut library = Vec::new();
    for function in harmonic_functions(&vec![1; n_joints], limit).into_iter().skip(1) {
        library.push(EnergyTerm { place: Place::Potential, function });
    }
    for i in 0..n_joints {
        for j in i..n_joints {
            // Mᵢⱼ is independent of the joints up to i, linear in those between, and quadratic in
            // those beyond j.
            let harmonics = (0..n_joints).map(|k| i8::from(k > i) + i8::from(k > j));
            for function in harmonic_functions(&harmonics.collect::<Vec<_>>(), limit) {
                library.push(EnergyTerm { place: Place::Inertia(i, j), function });
            }
        }
    }
    library
}

/// How many terms [`product_library`] lists, told without listing them; at most `usize::MAX`.
pub fn product_library_size(n_joints: usize, trig_order: u8, degrees: &[Degree]) -> usize {
    // Of one joint: 1, and a sine or none with cosines, two of each order above.
    let of_joint = |order: usize| if order == 0 { 1 } else { 2 };
    let mut of_order = vec![0_usize; usize::from(trig_order) + 1];
    of_order[0] = 1;
    for _ in 0..n_joints {
        of_order = (0..of_order.len())
            .map(|order| saturating((0..=order).map(|own| (of_order[order - own], of_joint(own)))))
            .collect();
    }
    let angles = saturating(of_order.into_iter().map(|count| (count, 1)));
    let motions = degrees.iter().map(|degree| {
        (n_monomials(n_joints, degree.velocity), n_monomials(n_joints, degree.acceleration))
    });
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
pub fn energy_library_size(n_joints: usize, interaction: Option<usize>) -> usize {
    let limit = interaction.unwrap_or(n_joints).min(n_joints);
    // By how many angles a function has: of each joint two for each of its harmonics.
    let functions = |harmonics: &dyn Fn(usize) -> usize| {
        let mut of_angles = vec![0_usize; limit + 1];
        of_angles[0] = 1;
        for joint in 0..n_joints {
            for angles in (1..=limit).rev() {
                let more = of_angles[angles - 1].saturating_mul(2 * harmonics(joint));
                of_angles[angles] = of_angles[angles].saturating_add(more);
            }
        }
        saturating(of_angles.into_iter().map(|count| (count, 1)))
    };
    let mut size = functions(&|_| 1) - 1;
    for i in 0..n_joints {
        for j in i..n_joints {
            let harmonics = |k: usize| usize::from(k > i) + usize::from(k > j);
            size = size.saturating_add(functions(&harmonics));
        }
    }
    size
}

fn saturating(products: impl Iterator<Item = (usize, usize)>) -> usize {
    products.fold(0, |sum: usize, (a, b)| sum.saturating_add(a.saturating_mul(b)))
}

/// Products over the joints of {1, cos kq, sin kq : k ≤ harmonics of the joint}, the constant
/// first, of at most `limit` joints.
fn harmonic_functions(harmonics: &[i8], limit: usize) -> Vec<Term> {
    let mut functions = vec![Term::one(harmonics.len())];
    for (joint, &largest) in harmonics.iter().enumerate() {
        let mut longer = Vec::new();
        for term in functions {
            if term.factors.len() < limit {
                for multiple in 1..=largest {
                    for trig in [Trig::Cos, Trig::Sin] {
                        longer.push(term.clone().times(trig, joint, multiple, 1));
                    }
                }
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

    #[test]
    fn a13_libraries_are_counted_as_they_are_listed() {
        for n in 1..=4 {
            for order in 1..=4 {
                for degrees in [Degree::up_to(2), vec![Degree::of(Kind::Coriolis)]] {
                    let listed = product_library(n, order, &degrees).len();
                    assert_eq!(product_library_size(n, order, &degrees), listed, "{n} {order}");
                }
                let listed = energy_library(n, Some(order.into())).len();
                assert_eq!(energy_library_size(n, Some(order.into())), listed, "{n} {order}");
            }
            assert_eq!(energy_library_size(n, None), energy_library(n, None).len(), "{n}");
        }
        assert_eq!(product_library_size(1000, 255, &Degree::up_to(255)), usize::MAX);
    }

    #[test]
    fn product_libraries_have_the_sizes_of_the_method() {
        let whole = product_library(3, 4, &Degree::up_to(2));
        let steps = [(Kind::Gravity, 2), (Kind::Coriolis, 4), (Kind::Inertia, 4)]
            .map(|(kind, order)| product_library(3, order, &[Degree::of(kind)]).len());

        assert_eq!(whole.len(), 3612);
        assert_eq!(steps, [25, 774, 387]);
    }

    #[test]
    fn energy_libraries_have_the_sizes_of_the_method() {
        let sizes: Vec<usize> = (3..=6).map(|n| energy_library(n, None).len()).collect();

        assert_eq!(sizes, [84, 410, 2013, 9947]);
    }

    #[test]
    fn no_candidate_comes_twice() {
        let mut terms = product_library(3, 3, &Degree::up_to(2));
        let mut energies = energy_library(4, Some(2));
        let before = (terms.len(), energies.len());

        terms.sort();
        terms.dedup();
        energies.sort();
        energies.dedup();

        assert_eq!((terms.len(), energies.len()), before);
        assert!(energies.iter().all(|energy| energy.function.interaction() <= 2));
    }
}
