//! A rigid chain in the frames and base parameters in which its recursion is cheapest.
//!
//! Torque leaves open where a frame lies along its axis, how it is turned about it, and which of
//! two links carries what does not notice the turn of the joint between them. Frames are turned so
//! that each joint is a turn about x, a shift and a turn about z (Craig); mass, first moment along
//! the axis and Iyy of each link are put into the link before it (Gautier and Khalil, 1990), so
//! that links have seven parameters and no mass. A slide notices no moments: they go into the link
//! before, and it keeps mass and first moment.

use crate::error::Result;
use nalgebra::{Matrix3, Vector3};
use torquewise_model::{JointKind, RigidChain};
use torquewise_rigid::recursion::Inertia;

/// Sines and cosines this near −1, 0 or 1 are these: π/2 is not a right angle to the last bit.
const ROUNDING: f64 = 1e-15;

type Matrix = Matrix3<f64>;
type Vector = Vector3<f64>;
type Body = Inertia<f64>;

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
    /// Mass \[kg\] and first moment \[kg·m\]; of a joint that turns, the moment across its axis alone.
    pub(crate) mass: f64,
    pub(crate) first: [f64; 3],
    /// Moments about the origin \[kg·m²\].
    pub(crate) moments: Moments,
}

/// A symmetric tensor less its yy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Moments {
    /// About x, less that about y.
    pub(crate) xx: f64,
    /// About z.
    pub(crate) zz: f64,
    pub(crate) xy: f64,
    pub(crate) xz: f64,
    pub(crate) yz: f64,
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
        let mut bodies: Vec<Body> =
            links.map(|(link, turn)| turned(&Body::of(link), &about_z(-turn))).collect();
        for j in (1..n).rev() {
            let twist = about_x(joints[j].twist);
            // What of it does not notice how the joint moves.
            let mut moved = bodies[j];
            if axes.kinds().slides(j) {
                (moved.mass, moved.first) = (0.0, Vector::zeros());
            }
            if axes.kinds().of(j).turns() {
                let yy = moved.about_origin.m22;
                moved.first = Vector::new(0.0, 0.0, moved.first.z);
                moved.about_origin = Matrix::from_diagonal(&Vector::new(yy, yy, 0.0));
            } else {
                bodies[j].about_origin = Matrix::zeros();
                moved = turned(&moved, &about_z(joints[j].after + turns[j]));
            }
            let moved = shifted(&turned(&moved, &twist), &joints[j].origin);
            bodies[j - 1] = bodies[j - 1].plus(&moved);
        }
        let link = |(k, ((joint, body), turn)): (usize, ((&Joint, &Body), &f64))| {
            let (kind, m) = (axes.kinds().of(k), body.about_origin);
            let slides = kind.slides();
            let [x, y, z]: [f64; 3] = body.first.into();
            BaseLink {
                kind,
                turns: chain.coupling.row(k, n),
                origin: joint.origin.into(),
                twist: sine_cosine(joint.twist),
                offset: sine_cosine(joint.after + turn),
                mass: if slides { body.mass } else { 0.0 },
                first: [x, y, if slides { z } else { 0.0 }],
                moments: Moments { xx: m.m11 - m.m22, zz: m.m33, xy: m.m12, xz: m.m13, yz: m.m23 },
            }
        };
        let links = joints.iter().zip(&bodies).zip(&turns).enumerate().map(link).collect();
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

/// Components in a frame from which `rotation` turns to the one they are in.
fn turned(body: &Body, rotation: &Matrix) -> Body {
    let about_origin = rotation * body.about_origin * rotation.transpose();
    Body { mass: body.mass, first: rotation * body.first, about_origin }
}

/// The same body about a point that lies at −`by`.
fn shifted(&Body { mass, first, about_origin }: &Body, by: &Vector) -> Body {
    let round = Matrix::from_diagonal_element(2.0 * by.dot(&first) + mass * by.dot(by));
    let across = by * first.transpose() + first * by.transpose() + mass * by * by.transpose();
    Body { mass, first: first + mass * by, about_origin: about_origin - across + round }
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
