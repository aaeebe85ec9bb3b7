//! Arms, motions and fits that the tests share.

use faer::{Mat, MatRef};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use torquewise_identify::{
    ChainOptions, FrictionKind, Plan, Reconstruction, UNWATCHED, reconstruct, score,
};
use torquewise_model::{Model, to_json};
use torquewise_motion::{Motion, Recording, Signals};
use torquewise_sim::{Arm, MotionKind, MotionPlan, Noise, add_noise, simulate};

/// Positions, speeds and accelerations of the joints at one time.
pub(crate) type State = [Vec<f64>; 3];

pub(crate) fn reference_arm() -> Arm {
    Arm::builtin("puma560-3").unwrap()
}

/// A motion of an arm and its torque, `rate` rows a second.
pub(crate) fn motion(arm: &Arm, kind: MotionKind, seconds: f64, rate: f64, seed: u64) -> Motion {
    simulate(arm, &MotionPlan { kind, seconds, rate, seed }).unwrap().motion
}

/// A motion that no fit has seen.
pub(crate) fn outside(arm: &Arm) -> Motion {
    motion(arm, MotionKind::Sines, 20.0, 100.0, 77)
}

pub(crate) fn noisy(clean: &Motion, case: u8, seed: u64) -> Motion {
    add_noise(clean, &Noise::case(case).unwrap(), seed).unwrap()
}

/// Standard normal numbers.
pub(crate) fn normals(seed: u64) -> impl FnMut() -> f64 {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    move || StandardNormal.sample(&mut random)
}

pub(crate) fn row_of(x: MatRef<'_, f64>, row: usize) -> Vec<f64> {
    x.row(row).iter().copied().collect()
}

pub(crate) fn states_of(motion: &Motion) -> Vec<State> {
    (0..motion.n_rows()).map(|row| motion.state(row)).collect()
}

/// States of an arm, with the torque that it needs for them.
pub(crate) fn executed(arm: &Arm, t: Vec<f64>, states: &[State]) -> Motion {
    let torques: Vec<Vec<f64>> =
        states.iter().map(|[q, dq, ddq]| arm.inverse_dynamics(q, dq, ddq)).collect();
    let signal = |of: &dyn Fn(usize) -> Vec<f64>| {
        let rows: Vec<Vec<f64>> = (0..states.len()).map(of).collect();
        Mat::from_fn(rows.len(), arm.n_joints(), |row, joint| rows[row][joint])
    };
    let [q, dq, ddq] = [0, 1, 2].map(|order| signal(&|row| states[row][order].clone()));
    let tau = Some(signal(&|row| torques[row].clone()));
    Motion::new(Signals { joints: arm.joints().to_vec(), t, q, dq, ddq, tau }).unwrap()
}

/// The motion with the torque of each row changed, which `change` is given with the state.
pub(crate) fn with_torque(motion: Motion, mut change: impl FnMut(&State, &mut [f64])) -> Motion {
    let states = states_of(&motion);
    let mut signals = motion.into_signals();
    let tau = signals.tau.as_mut().unwrap();
    for (row, state) in states.iter().enumerate() {
        let mut own = row_of(tau.as_ref(), row);
        change(state, &mut own);
        own.into_iter().enumerate().for_each(|(joint, x)| tau[(row, joint)] = x);
    }
    Motion::new(signals).unwrap()
}

/// Root mean square of the torque of a joint about its mean.
pub(crate) fn deviation(tau: MatRef<'_, f64>, joint: usize) -> f64 {
    let m = tau.nrows() as f64;
    let mean = tau.col(joint).sum() / m;
    (tau.col(joint).iter().map(|x| (x - mean).powi(2)).sum::<f64>() / m).sqrt()
}

/// The plan of a chain with this friction.
pub(crate) fn chain(friction: FrictionKind) -> Plan {
    ChainOptions { friction, ..ChainOptions::default() }.into()
}

pub(crate) fn fit(log: &(impl Recording + ?Sized), plan: &Plan) -> Reconstruction {
    reconstruct(log, plan, UNWATCHED).unwrap()
}

/// NRMSE \[%\] of each joint.
pub(crate) fn percent(model: &Model, test: &Motion) -> Vec<f64> {
    let joints = score(model, test).unwrap().joints;
    joints.into_iter().map(|joint| joint.nrmse_percent).collect()
}

/// Whether a model misses less than so many percent of the torque of each joint.
#[track_caller]
pub(crate) fn assert_predicts(model: &Model, test: &Motion, most: f64) {
    let errors = percent(model, test);
    assert!(errors.iter().all(|&percent| percent < most), "{errors:?}");
}

/// Whether a fit gives the same bits at one and three threads.
pub(crate) fn threads_leave_no_trace(log: &Motion, plan: &Plan) -> bool {
    let [one, three] = [1, 3].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| to_json(&fit(log, plan).model).unwrap())
    });
    one == three
}
