//! Chains of bodies that can be, and the arms that simulate them.

use faer::Mat;
use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use torquewise_motion::Motion;
use torquewise_rigid::geometry::PER_JOINT;
use torquewise_rigid::inertia::plain_link;
use torquewise_rigid::{Chain, ChainRows, Geometry, PER_BASE};
use torquewise_sim::{Arm, MotionKind, MotionPlan, simulate};

/// A chain of bodies that can be, with axes at all angles, in a base that is tilted.
pub(crate) fn drawn(n: usize, seed: u64) -> Chain {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut between = |low: f64, high: f64| random.random_range(low..high);
    let parameters = PER_BASE + PER_JOINT * (n - 1);
    let parameters: Vec<f64> = (0..parameters).map(|_| between(-1.0, 1.0)).collect();
    let body = |_| {
        let end: [f64; 3] = std::array::from_fn(|_| between(-0.6, 0.6));
        plain_link(between(0.5, 5.0), &Vector3::from(end), between(0.2, 0.4))
    };
    let inertial = (0..n).flat_map(body).collect();
    let geometry = Geometry::new(&parameters).unwrap();
    Chain { geometry, inertial, drive: vec![], residual_rms: vec![], cost: 0.0 }
}

/// The chain as rigid-body dynamics has it.
pub(crate) fn arm(chain: &Chain) -> Arm {
    let n = chain.geometry.n_joints();
    let joints: Vec<String> = (1..=n).map(|joint| format!("joint{joint}")).collect();
    let limits = std::iter::repeat(([-3.0, 3.0], 2.0));
    Arm::of_chain(&joints, &chain.geometry, &chain.inertial, limits).unwrap()
}

/// Smooth motion of an arm with the torque it takes.
pub(crate) fn sines(arm: &Arm, seconds: f64, seed: u64) -> Motion {
    let plan = MotionPlan { kind: MotionKind::Sines, seconds, rate: 50.0, seed };
    simulate(arm, &plan).unwrap().motion
}

/// Rows of a motion with nothing beside the chain.
pub(crate) fn rows(motion: &Motion) -> ChainRows {
    let tau = motion.require_tau().unwrap();
    let none = Mat::zeros(motion.n_rows() * motion.n_joints(), 0);
    ChainRows::new([motion.q(), motion.dq(), motion.ddq(), tau], none).unwrap()
}

/// RMSE of a chain on rows over the standard deviation of the torque, of each joint.
pub(crate) fn errors(chain: &Chain, rows: &ChainRows) -> Vec<f64> {
    let (m, found) = (rows.len(), chain.torque(rows));
    let of_joint = |joint: usize| {
        let tau = rows.torque_of(joint);
        let mean = tau.iter().sum::<f64>() / m as f64;
        let spread: f64 = tau.iter().map(|tau| (tau - mean).powi(2)).sum();
        let pairs = tau.iter().zip(&found[joint * m..]);
        (pairs.map(|(tau, found)| (tau - found).powi(2)).sum::<f64>() / spread).sqrt()
    };
    (0..rows.n_joints()).map(of_joint).collect()
}

pub(crate) fn largest(errors: &[f64]) -> f64 {
    errors.iter().fold(0.0, |most, error| error.max(most))
}
