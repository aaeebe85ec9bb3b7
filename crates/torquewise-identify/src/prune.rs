//! The few energy terms that the torque of a chain needs, on states like those of the log.

use crate::States;
use faer::{ColRef, Mat};
use rayon::prelude::*;
use torquewise_model::{EnergyTerm, Place};
use torquewise_motion::Motion;

/// States that terms are judged on: half of them of the log, half with its parts mixed anew.
const STATES: usize = 400;
/// Part of the residual that the terms left out may add, RMS.
const TOLERANCE: f64 = 0.1;
/// Part of the tolerance spent on terms so small that a bound on their torque suffices.
const GLANCE: f64 = 0.05;

/// Keeps the terms without which the torque of some joint would be off by more than a tenth of the
/// residual.
///
/// - `residual_rms`: what the chain leaves of the torque of each joint \[N·m\], n
pub(crate) fn prune(
    terms: Vec<(EnergyTerm, f64)>,
    motion: &Motion,
    residual_rms: &[f64],
    seed: u64,
) -> Vec<(EnergyTerm, f64)> {
    let states = States::mixed(motion, STATES, seed);
    let tolerance: Vec<f64> = residual_rms.iter().map(|rms| TOLERANCE * rms).collect();
    let terms = glance(terms, &states, &tolerance);
    let size = |loads: &Mat<f64>| -> f64 {
        let squares = |x: ColRef<'_, f64>| x.iter().map(|x| x * x).sum::<f64>();
        let parts = loads.col_iter().zip(&tolerance).map(|(x, limit)| squares(x).sqrt() / limit);
        parts.fold(0.0, f64::max)
    };
    let mut order: Vec<usize> = (0..terms.len()).collect();
    let loads = |place: usize| states.loads(&terms[place].0, terms[place].1);
    let sizes: Vec<f64> = (0..terms.len()).into_par_iter().map(|k| size(&loads(k))).collect();
    order.sort_by(|&a, &b| sizes[a].total_cmp(&sizes[b]).then(a.cmp(&b)));
    let limit = (states.len() as f64).sqrt() * (1.0 - GLANCE);
    let mut left_out = Mat::<f64>::zeros(states.len(), states.n_joints());
    let mut kept = vec![true; terms.len()];
    for place in order {
        let more = &left_out + &loads(place);
        if size(&more) > limit {
            break;
        }
        (left_out, kept[place]) = (more, false);
    }
    terms.into_iter().zip(kept).filter(|(_, is_kept)| *is_kept).map(|(term, _)| term).collect()
}

/// Drops the terms that no state can make matter.
fn glance(
    terms: Vec<(EnergyTerm, f64)>,
    states: &States,
    tolerance: &[f64],
) -> Vec<(EnergyTerm, f64)> {
    let [dq, ddq] = states.peaks();
    let inertial = 2.0 * ddq + 6.0 * states.n_joints() as f64 * dq * dq;
    let bound = |(term, coefficient): &(EnergyTerm, f64)| {
        coefficient.abs() * if term.place == Place::Potential { 1.0 } else { inertial }
    };
    let least = tolerance.iter().copied().fold(f64::INFINITY, f64::min);
    let budget = (GLANCE * least).powi(2);
    let mut bounds: Vec<f64> = terms.iter().map(bound).collect();
    bounds.sort_by(f64::total_cmp);
    let mut spent = 0.0;
    let mut floor = 0.0;
    for bound in bounds {
        spent += bound * bound;
        if spent > budget {
            break;
        }
        floor = bound;
    }
    terms.into_iter().filter(|term| bound(term) > floor).collect()
}

#[cfg(test)]
mod tests;
