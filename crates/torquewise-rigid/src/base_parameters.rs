//! Regrouping of the inertial parameters of a chain towards its base parameters.

use crate::inertia::{Inertial, seen_from};
use crate::{Geometry, JointKind, PER_BODY};

/// Regroups inertial parameters without changing any torque: of a revolute link, mass, first moment
/// along z and Iyy act like a body symmetric about the axis, and move to the parent link (those of the
/// first have no effect). Left are first moments across the axis, Ixx − Iyy, Izz, Ixy, Ixz and Iyz. Of a
/// sliding link all six moments move, mass and first moments are left. What special axes leave
/// undetermined besides stays. The map is linear in the parameters.
///
/// - `inertial`: ten parameters of each link, 10n
/// - returns: the same number, zeros where nothing is left
///
/// Source: M. Gautier, W. Khalil, *Direct calculation of minimum set of inertial parameters of
/// serial robots*, IEEE T-RA (1990).
pub fn base_parameters(geometry: &Geometry, inertial: &[f64]) -> Vec<f64> {
    let mut base = inertial.to_vec();
    let placements = geometry.placements();
    for link in (0..placements.len()).rev() {
        let own = PER_BODY * link;
        let round = unnoticed(geometry.kinds().of(link), &base[own..]);
        base[own..].iter_mut().zip(round).for_each(|(own, round)| *own -= round);
        if let Some(before) = own.checked_sub(PER_BODY) {
            let moved = seen_from(&round, &placements[link]);
            base[before..].iter_mut().zip(moved).for_each(|(own, moved)| *own += moved);
        }
    }
    base
}

/// What of a link the motion of its joint does not notice, to move to the link before.
///
/// - `link`: its inertial parameters, 10 or those of more links behind it
pub fn unnoticed(kind: JointKind, link: &[f64]) -> Inertial {
    let [m, mz, yy] = [link[0], link[3], link[5]];
    let mut round = if kind.turns() {
        [m, 0.0, 0.0, mz, yy, yy, 0.0, 0.0, 0.0, 0.0]
    } else {
        std::array::from_fn(|k| link[k])
    };
    if kind.slides() {
        round[..4].fill(0.0);
    }
    round
}
