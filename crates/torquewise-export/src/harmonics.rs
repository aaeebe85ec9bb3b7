//! Energy terms rewritten with sums of the angles of neighbouring joints.
//!
//! Where joints turn about parallel axes, energies depend on sums of their angles: what reads
//! cos q₂ cos q₃ − sin q₂ sin q₃ in the functions of one angle each is cos(q₂ + q₃). Written so, an
//! arm of parallel axes has a fraction of the terms.

use std::collections::BTreeMap;
use std::ops::Range;
use torquewise_model::harmonic::summed_angles;
use torquewise_model::{EnergyTerm, Place, Weighted};

/// Part of the largest coefficient that moves a joint below which a coefficient is the rounding of
/// others that cancelled.
const ROUNDING: f64 = 1e-15;

/// Sums that grow to more than this many times the terms do not become fewer.
const GROWTH: usize = 4;
/// So many are never too many.
const FEW: usize = 100;

/// The same energies with the functions of a range of joints as sines and cosines of sums; `None`
/// where that takes far more terms.
pub(crate) fn summed(
    terms: &[Weighted<EnergyTerm>],
    joints: &Range<usize>,
) -> Option<Vec<Weighted<EnergyTerm>>> {
    let mut sums: BTreeMap<EnergyTerm, f64> = BTreeMap::new();
    let most = GROWTH * terms.len() + FEW;
    for weighted in terms {
        let Weighted { term: EnergyTerm { place, function }, coefficient, .. } = weighted;
        for (share, function) in summed_angles(function, joints, most)? {
            let term = EnergyTerm { place: *place, function };
            *sums.entry(term).or_insert(0.0) += share * coefficient;
        }
        if sums.len() > most {
            return None;
        }
    }
    // What is left of coefficients that cancelled is left out: what is below the rounding at every
    // joint it would move. Energy of one kind alone counts, as gravity is asked for alone.
    let n = terms.first().map_or(0, |w| w.term.function.n_joints());
    let mut largest = [vec![0.0_f64; n], vec![0.0_f64; n]];
    let kind = |term: &EnergyTerm| usize::from(term.place == Place::Potential);
    for (term, coefficient) in &sums {
        for joint in (0..n).filter(|&joint| moves(term, joint)) {
            let most = &mut largest[kind(term)][joint];
            *most = most.max(coefficient.abs());
        }
    }
    let counts = |(term, coefficient): &(EnergyTerm, f64)| {
        let scales = &largest[kind(term)];
        let mut moved = (0..n).filter(|&joint| moves(term, joint));
        *coefficient != 0.0 && moved.any(|joint| coefficient.abs() > ROUNDING * scales[joint])
    };
    let sums = sums.into_iter().filter(counts);
    Some(sums.map(|(term, weight)| Weighted::new(term, weight)).collect())
}

fn moves(term: &EnergyTerm, joint: usize) -> bool {
    let own = matches!(term.place, Place::Inertia(i, j) if i == joint || j == joint);
    own || term.function.depends_on(joint)
}
