//! Torque alone, without allocation; intermediate results are not kept.

use super::{
    Body, Inertia, Kinematics, Lanes, MOST_JOINTS, MotionState, N_LANES, PER_BODY, Scalar, Wrench,
};
use faer::MatRef;
use simba::simd::SimdValue;

impl Kinematics {
    /// Torques \[N·m\] of all joints, n.
    ///
    /// - `inertial`: inertial parameters of all bodies, 10 each
    ///
    /// # Panics
    /// If the chain has more than [`MOST_JOINTS`] joints, or the arguments are of another one.
    pub fn torque<T: Scalar>(&self, state: MotionState<'_, T>, inertial: &[f64], torque: &mut [T]) {
        let MotionState { q, dq, ddq } = state;
        let mut room = [Body::default(); MOST_JOINTS];
        let bodies = &mut room[..self.n_joints()];
        let base = self.base();
        for joint in 0..bodies.len() {
            let before = joint.checked_sub(1).map_or(&base, |before| &bodies[before]);
            bodies[joint] = self.body(joint, before, |joint| [q[joint], dq[joint], ddq[joint]]).0;
        }
        let mut wrench = Wrench::default();
        for (joint, body) in bodies.iter().enumerate().rev() {
            wrench = wrench.plus(&body.wrench(&Inertia::of(&inertial[PER_BODY * joint..])));
            torque[joint] = wrench.effort(self.kinds.of(joint));
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
    /// If the chain has more than [`MOST_JOINTS`] joints, or the arguments are of another one.
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
