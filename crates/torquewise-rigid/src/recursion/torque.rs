//! Torque alone, without allocation; intermediate results are not kept.

use super::{
    Body, Inertia, Kinematics, Lanes, MOST_JOINTS, MotionState, N_LANES, PER_BODY, Scalar, Wrench,
    splat,
};
use crate::joint::JointKind;
use faer::MatRef;
use simba::simd::SimdValue;

impl Kinematics {
    /// Torques \[N·m\] of all joints, n, at most [`MOST_JOINTS`].
    ///
    /// - `inertial`: inertial parameters of all bodies, 10 each
    ///
    /// # Panics
    /// If the chain has more than [`MOST_JOINTS`] joints, or the arguments are of another one.
    pub fn torque<T: Scalar>(&self, state: MotionState<'_, T>, inertial: &[f64], torque: &mut [T]) {
        // Short chains should not pay for clearing what only long ones need.
        if !self.kinds.all_turn() {
            return self.torque_within::<MOST_JOINTS, true, T>(state, inertial, torque);
        }
        match self.n_joints() {
            0..=4 => self.torque_within::<4, false, T>(state, inertial, torque),
            5..=8 => self.torque_within::<8, false, T>(state, inertial, torque),
            _ => self.torque_within::<MOST_JOINTS, false, T>(state, inertial, torque),
        }
    }

    fn torque_within<const MOST: usize, const SLIDES: bool, T: Scalar>(
        &self,
        state: MotionState<'_, T>,
        inertial: &[f64],
        torque: &mut [T],
    ) {
        let mut bodies = [Body::at_rest(); MOST];
        let mut before = Body { acceleration: -splat(&self.gravity), ..Body::at_rest() };
        for (joint, placement) in self.placements.iter().enumerate() {
            let state = [state.q, state.dq, state.ddq]
                .map(|signal| self.coupling.drive(joint, |joint| signal[joint]));
            before = if SLIDES {
                before.moved(placement, self.kinds.of(joint), state)
            } else {
                before.next(placement, state)
            };
            bodies[joint] = before;
        }
        let mut wrench = Wrench::none();
        for (joint, body) in bodies[..self.n_joints()].iter().enumerate().rev() {
            wrench = wrench.plus(&body.wrench(&Inertia::of(&inertial[PER_BODY * joint..])));
            let kind = if SLIDES { self.kinds.of(joint) } else { JointKind::default() };
            torque[joint] = wrench.effort(kind);
            wrench = wrench.before(body);
        }
        self.coupling.load(&mut torque[..self.n_joints()]);
    }

    /// Torques \[N·m\] over many states, four at once: calls `put(row, joint, torque)`, row by row
    /// within each four. A row gives the same bits whatever rows are beside it.
    ///
    /// - `signals`: q, q̇, q̈, m×n each; `None` is all zeros
    /// - `inertial`: inertial parameters of all bodies, 10 each
    ///
    /// # Panics
    /// As [`Self::torque`].
    pub fn torques(
        &self,
        signals: [Option<MatRef<'_, f64>>; 3],
        inertial: &[f64],
        mut put: impl FnMut(usize, usize, f64),
    ) {
        let n = self.n_joints();
        let mut torque = [Lanes::splat(0.0); MOST_JOINTS];
        each_four(n, signals, |state, first, count| {
            self.torque(state, inertial, &mut torque[..n]);
            for lane in 0..count {
                (0..n).for_each(|joint| put(first + lane, joint, torque[joint].extract(lane)));
            }
        });
    }
}

/// Calls `visit` with four states of n joints at a time, the row of the first of them and how many of
/// them are rows; the last is repeated where rows run out.
///
/// - `signals`: q, q̇, q̈, m×n each; `None` is all zeros
pub(crate) fn each_four(
    n: usize,
    signals: [Option<MatRef<'_, f64>>; 3],
    mut visit: impl FnMut(MotionState<'_, Lanes>, usize, usize),
) {
    let m = signals.iter().flatten().map(MatRef::nrows).max().unwrap_or(0);
    let mut state = [[Lanes::splat(0.0); MOST_JOINTS]; 3];
    for first in (0..m).step_by(N_LANES) {
        for (lanes, signal) in state.iter_mut().zip(&signals) {
            let Some(signal) = signal else { continue };
            for lane in 0..N_LANES {
                let row = (first + lane).min(m - 1);
                (0..n).for_each(|joint| lanes[joint].replace(lane, signal[(row, joint)]));
            }
        }
        let [q, dq, ddq] = state.each_ref().map(|lanes| &lanes[..n]);
        visit(MotionState { q, dq, ddq }, first, N_LANES.min(m - first));
    }
}
