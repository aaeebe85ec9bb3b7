//! A start → the chain refined on a recording: passes until nothing moves (E11).

use super::linearisation::{Linearisation, Structure};
use super::nominal::Sizes;
use super::pass::add_up;
use super::solve::{Solved, solve, step};
use crate::error::IdentifyError;
use torquewise_motion::Recording;
use torquewise_sparse::normal_sums::NormalSums;

/// Passes that make the links physical before the geometry moves.
const HELD_PASSES: usize = 2;
/// A step that explains the torque worse by this part, residuals of the joints by their geometric
/// mean, was too long.
const WORSE: f64 = 0.02;
/// Times that a step is shortened at most.
const HALVINGS: usize = 3;

/// Passes over a recording from a linearisation until the parameters settle, `most` at most.
///
/// The search leaves inertial parameters that no arm has, and derivatives by the geometry that are
/// those of such an arm: the geometry is held until its links are physical.
pub(crate) fn refine(
    recording: &(impl Recording + ?Sized),
    start: Linearisation,
    sizes: &Sizes,
    most: usize,
) -> Result<Solved, IdentifyError> {
    let free = start.structure.free.clone();
    let held = Structure { free: Vec::new(), ..start.structure.clone() };
    let mut at = Linearisation { structure: held, ..start };
    for _ in 0..HELD_PASSES {
        at = step(&add_up(recording, &at)?, &at, sizes)?.at;
    }
    at.structure.free = free;
    let mut sums = add_up(recording, &at)?;
    let mut solved = solve(&sums, &at, sizes)?;
    for _ in 1..most {
        if solved.settled {
            break;
        }
        let mut next = solved.at.clone();
        let mut ahead = add_up(recording, &next);
        for _ in 0..HALVINGS {
            // A torque beyond all numbers is one that is explained worse.
            if ahead.as_ref().is_ok_and(|ahead| !is_worse(ahead, &sums)) {
                break;
            }
            next = at.towards(&next, 0.25);
            ahead = add_up(recording, &next);
        }
        (at, sums) = (next, ahead?);
        solved = solve(&sums, &at, sizes)?;
    }
    Ok(solved)
}

/// Whether the torque of the joints is explained worse, by their geometric mean, than before.
fn is_worse(sums: &NormalSums, before: &NormalSums) -> bool {
    let merit = |sums: &NormalSums| -> f64 {
        sums.weighted_rms().iter().map(|rms| rms.max(f64::MIN_POSITIVE).ln()).sum()
    };
    let joints = sums.weighted_rms().len().max(1) as f64;
    (merit(sums) - merit(before)) / joints > WORSE
}
