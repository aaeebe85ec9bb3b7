//! The same arm twice, from Denavit–Hartenberg rows: rigid-body dynamics, and a chain.

use faer::Mat;
use nalgebra::{Matrix3, Rotation3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::fmt::Write;
use torquewise_motion::Motion;
use torquewise_rigid::{Chain, Geometry, Rows};
use torquewise_sim::{Arm, MotionKind, MotionPlan, simulate};

/// A joint and its link, standard Denavit–Hartenberg, link values in the frame of the link.
pub(crate) struct Link {
    pub(crate) a: f64,
    pub(crate) alpha: f64,
    pub(crate) d: f64,
    pub(crate) mass: f64,
    pub(crate) com: [f64; 3],
    /// xx, yy, zz, xy, xz, yz about the centre of mass.
    pub(crate) inertia: [f64; 6],
}

/// The reference arm `puma560-3`, number by number.
pub(crate) fn puma() -> Vec<Link> {
    let quarter = std::f64::consts::FRAC_PI_2;
    let diagonal = |x, y, z| [x, y, z, 0.0, 0.0, 0.0];
    vec![
        Link {
            a: 0.0,
            alpha: quarter,
            d: 0.0,
            mass: 0.0,
            com: [0.0; 3],
            inertia: diagonal(0.0, 0.35, 0.0),
        },
        Link {
            a: 0.4318,
            alpha: 0.0,
            d: 0.0,
            mass: 17.4,
            com: [-0.3638, 0.006, 0.2275],
            inertia: diagonal(0.13, 0.524, 0.539),
        },
        Link {
            a: 0.0203,
            alpha: -quarter,
            d: 0.15005,
            mass: 4.8,
            com: [-0.0203, -0.0141, 0.070],
            inertia: diagonal(0.066, 0.086, 0.0125),
        },
    ]
}

/// Links at all angles.
pub(crate) fn drawn(n: usize, seed: u64) -> Vec<Link> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut between = |low: f64, high: f64| random.random_range(low..high);
    (0..n)
        .map(|_| Link {
            a: between(-0.5, 0.5),
            alpha: between(-3.0, 3.0),
            d: between(-0.5, 0.5),
            mass: between(0.5, 5.0),
            com: std::array::from_fn(|_| between(-0.3, 0.3)),
            // Moments of at least 0.3 outweigh products of at most 0.1.
            inertia: std::array::from_fn(|k| {
                if k < 3 { between(0.3, 1.0) } else { between(-0.1, 0.1) }
            }),
        })
        .collect()
}

/// The links as rigid-body dynamics has them.
pub(crate) fn arm(links: &[Link], gravity: [f64; 3]) -> Arm {
    let mut text = format!("name = 'twin'\ngravity = {gravity:?}\n");
    for (joint, link) in links.iter().enumerate() {
        let Link { a, alpha, d, mass, com, inertia } = link;
        write!(
            text,
            "[[joints]]\nname = 'joint{joint}'\na = {a:?}\nalpha = {alpha:?}\nd = {d:?}\n\
             mass = {mass:?}\ncom = {com:?}\ninertia = {inertia:?}\n"
        )
        .unwrap();
    }
    Arm::from_dh_toml(&text).unwrap()
}

/// The links as a chain, in a base that is tilted.
pub(crate) fn chain(links: &[Link], tilt: [f64; 2]) -> Chain {
    let mut parameters = tilt.to_vec();
    let mut inertial = Vec::new();
    // How far along its axis the frame of the chain lies from that of the table.
    let mut shift = 0.0;
    for (joint, link) in links.iter().enumerate() {
        let along = link.d - shift;
        inertial.extend(inertial_of(link, along));
        if joint + 1 < links.len() {
            parameters.extend([link.alpha, 0.0, link.a, along * link.alpha.sin()]);
        }
        shift = -along * link.alpha.cos();
    }
    let geometry = Geometry::new(&parameters).unwrap();
    Chain { geometry, inertial, drive: vec![], residual_rms: vec![], cost: 0.0 }
}

/// m, m·c and the moments about the origin of the joint's frame.
fn inertial_of(link: &Link, along: f64) -> [f64; 10] {
    let turned = Rotation3::from_axis_angle(&Vector3::x_axis(), link.alpha);
    let com = Vector3::new(link.a, 0.0, along) + turned * Vector3::from(link.com);
    let [xx, yy, zz, xy, xz, yz] = link.inertia;
    let central = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
    let steiner = Matrix3::identity() * com.norm_squared() - com * com.transpose();
    let i = turned * central * turned.transpose() + steiner * link.mass;
    let first = com * link.mass;
    [link.mass, first.x, first.y, first.z, i.m11, i.m22, i.m33, i.m12, i.m13, i.m23]
}

/// Smooth motion of an arm with the torque it takes.
pub(crate) fn sines(arm: &Arm, seconds: f64, seed: u64) -> Motion {
    let plan = MotionPlan { kind: MotionKind::Sines, seconds, rate: 50.0, seed };
    simulate(arm, &plan).unwrap().motion
}

/// Rows of a motion with nothing beside the chain.
pub(crate) fn rows(motion: &Motion) -> Rows {
    let tau = motion.require_tau().unwrap();
    let none = vec![Mat::zeros(motion.n_rows(), 0); motion.n_joints()];
    Rows::new([motion.q(), motion.dq(), motion.ddq(), tau], &none).unwrap()
}

/// RMSE of a chain on rows over the standard deviation of the torque, of each joint.
pub(crate) fn errors(chain: &Chain, rows: &Rows) -> Vec<f64> {
    let (m, found) = (rows.len(), chain.torque(rows));
    (0..rows.n_joints())
        .map(|joint| {
            let tau = rows.torque_of(joint);
            let mean = tau.iter().sum::<f64>() / m as f64;
            let spread: f64 = tau.iter().map(|tau| (tau - mean).powi(2)).sum();
            let pairs = tau.iter().zip(&found[joint * m..]);
            (pairs.map(|(tau, found)| (tau - found).powi(2)).sum::<f64>() / spread).sqrt()
        })
        .collect()
}

pub(crate) fn largest(errors: &[f64]) -> f64 {
    errors.iter().fold(0.0, |most, error| error.max(most))
}
