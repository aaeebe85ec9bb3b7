//! The prior of the geometry: axes at right angles and near each other (E8).

use crate::geometry::nearest_right_angle;
use crate::{Geometry, PER_BASE};

/// Gaussian prior of a geometry: mean, the nearest right angles with all axes through one point, and
/// precision of each parameter.
#[derive(Clone, Debug)]
pub struct UsualArm {
    /// Parameters of the geometry.
    pub parameters: Vec<f64>,
    /// Inverse variance of each parameter over usual arms \[1/rad², 1/m²\].
    pub precision: Vec<f64>,
}

/// Standard deviation of the tilt of the base \[rad\], and of an axis from its right angle.
const TILT: f64 = 0.05;
const DIRECTION: f64 = 0.15;
/// Standard deviation of the place of an axis \[m\]: the length of a link.
const PLACE: f64 = 0.5;

impl UsualArm {
    /// That of a geometry.
    pub fn near(geometry: &Geometry) -> Self {
        let mut usual = Geometry::straight(geometry.n_joints());
        for joint in 0..geometry.n_joints() {
            usual.set_turn(joint, nearest_right_angle(geometry.turn_of(joint)));
        }
        let of_joints = [DIRECTION, DIRECTION, PLACE, PLACE].repeat(geometry.n_joints() - 1);
        let spreads = [TILT; PER_BASE].into_iter().chain(of_joints);
        let precision = spreads.map(|spread| spread.powi(-2)).collect();
        Self { parameters: usual.parameters().to_vec(), precision }
    }

    /// Σ precision · (x − usual)².
    pub(crate) fn cost(&self, geometry: &Geometry) -> f64 {
        let own = geometry.parameters().iter().zip(&self.parameters).zip(&self.precision);
        own.map(|((x, usual), precision)| precision * (x - usual).powi(2)).sum()
    }
}
