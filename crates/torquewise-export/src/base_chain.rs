//! A rigid chain in the frames and base parameters in which its recursion is cheapest.
//!
//! Torque leaves open where a frame lies along its axis, how it is turned about it, and which of
//! two links carries what does not notice the turn of the joint between them. Frames are turned so
//! that each joint is a turn about x, a shift and a turn about z (Craig); mass, first moment along
//! the axis and Iyy of each link are put into the link before it (Gautier and Khalil, 1990), so
//! that links have seven parameters and no mass. A slide notices no moments: they go into the link
//! before, and it keeps mass and first moment.

use crate::Result;
use nalgebra::{Matrix3, Vector3};
use torquewise_model::{JointKind, RigidChain};
use torquewise_rigid::Placement;
use torquewise_rigid::base_parameters::unnoticed;
use torquewise_rigid::inertia::{Inertial, seen_from};

/// Sines and cosines this near −1, 0 or 1 are these: π/2 is not a right angle to the last bit.
const ROUNDING: f64 = 1e-15;

type Matrix = Matrix3<f64>;
type Vector = Vector3<f64>;

/// A chain whose links carry what torque can tell.
#[derive(Clone, Debug)]
pub(crate) struct BaseChain {
    pub(crate) links: Vec<BaseLink>,
    /// Acceleration of gravity \[m/s²\], in the base.
    pub(crate) gravity: [f64; 3],
}

/// A link and the joint before it: a shift, a turn about x, a turn about z by an offset, and what q
/// does about z and along it.
#[derive(Clone, Debug)]
pub(crate) struct BaseLink {
    pub(crate) kind: JointKind,
    /// Integer multiples of the coordinates that turn the joint, n.
    pub(crate) turns: Vec<i8>,
    /// Origin of its frame \[m\], in the frame before.
    pub(crate) origin: [f64; 3],
    /// Sine and cosine of the turn about x.
    pub(crate) twist: [f64; 2],
    /// Sine and cosine of what is added to q.
    pub(crate) offset: [f64; 2],
    /// Mass, first moment and moments about the origin, of which Iyy counts for nothing and Ixx is less
    /// Iyy; of a joint that turns, the first moment across its axis alone.
    pub(crate) inertial: Inertial,
}

/// How the frame of a joint lies in the one before: turns about z, x and z again, and the origin.
struct Joint {
    before: f64,
    twist: f64,
    after: f64,
    origin: Vector,
}

impl BaseChain {
    pub(crate) fn of(chain: &RigidChain) -> Result<Self> {
        let axes = chain.axes()?;
        let n = chain.n_joints();
        let joints: Vec<Joint> =
            (0..n).map(|j| Joint::of(axes.direction(j), axes.place(j))).collect();
        // Frames turn along with the joint behind them; the last turns so that it has no offset.
        let turn = |j: usize| joints.get(j + 1).map_or(-joints[j].after, |next| next.before);
        let turns: Vec<f64> = (0..n).map(turn).collect();
        let links = chain.links.iter().zip(&turns);
        let place = |rotation, origin| Placement { rotation, origin };
        let mut links: Vec<Inertial> = links
            .map(|(link, turn)| seen_from(link, &place(about_z(-turn), Vector::zeros())))
            .collect();
        for j in (0..n).rev() {
            let kind = axes.kinds().of(j);
            let round = unnoticed(kind, &links[j]);
            links[j].iter_mut().zip(round).for_each(|(own, round)| *own -= round);
            if let Some(before) = j.checked_sub(1) {
                let twist = about_x(joints[j].twist);
                // What is symmetric about its axis looks the same however it is turned.
                let rotation =
                    if kind.turns() { twist } else { twist * about_z(joints[j].after + turns[j]) };
                let moved = seen_from(&round, &place(rotation, joints[j].origin));
                links[before].iter_mut().zip(moved).for_each(|(own, moved)| *own += moved);
            }
        }
        let link = |(k, joint): (usize, &Joint)| BaseLink {
            kind: axes.kinds().of(k),
            turns: chain.coupling.row(k, n),
            origin: joint.origin.into(),
            twist: sine_cosine(joint.twist),
            offset: sine_cosine(joint.after + turns[k]),
            inertial: links[k],
        };
        let links = joints.iter().enumerate().map(link).collect();
        let gravity = axes.gravity();
        let size = gravity.iter().map(|g| g * g).sum::<f64>().sqrt();
        let gravity = gravity.map(|g| if g.abs() < ROUNDING * size { 0.0 } else { g });
        Ok(Self { links, gravity })
    }
}

impl Joint {
    /// - `direction`: rotation vector of the axis \[rad\]
    /// - `place`: origin along x and y of the turned frame \[m\]
    fn of([wx, wy]: [f64; 2], [px, py]: [f64; 2]) -> Self {
        let (twist, azimuth) = (wx.hypot(wy), wy.atan2(wx));
        let in_plane = about_x(twist) * (about_z(-azimuth) * Vector::new(px, py, 0.0));
        let [sine, cosine] = sine_cosine(twist);
        if sine.abs() > 0.0 {
            return Self { before: azimuth, twist, after: -azimuth, origin: in_plane };
        }
        // Parallel axes: x may point from one to the other.
        let [x, y, _]: [f64; 3] = (about_z(azimuth) * in_plane).into();
        let before = if x == 0.0 && y == 0.0 { azimuth } else { y.atan2(x) };
        let after = if cosine > 0.0 { -before } else { before - 2.0 * azimuth };
        Self { before, twist, after, origin: Vector::new(x.hypot(y), 0.0, 0.0) }
    }
}

/// Sine and cosine of an angle, exact at right angles.
fn sine_cosine(angle: f64) -> [f64; 2] {
    let (sine, cosine) = angle.sin_cos();
    [sine, cosine].map(|x| if (x - x.round()).abs() < ROUNDING { x.round() } else { x })
}

fn about_x(angle: f64) -> Matrix {
    let [s, c] = sine_cosine(angle);
    Matrix::new(1.0, 0.0, 0.0, 0.0, c, -s, 0.0, s, c)
}

fn about_z(angle: f64) -> Matrix {
    let [s, c] = sine_cosine(angle);
    Matrix::new(c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0)
}
