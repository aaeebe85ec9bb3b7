//! The prior of the geometry: axes at right angles and near each other (E8).

use crate::geometry::{Geometry, PER_BASE, nearest_right_angle};

/// The prior of a geometry where the log determines nothing: the axes at the right angles that
/// they are nearest to, all through one point, and by how much arms differ from that.
#[derive(Clone, Debug)]
pub struct UsualArm {
    /// Parameters of the geometry.
    pub parameters: Vec<f64>,
    /// One over the variance of each among arms \[1/rad², 1/m²\].
    pub precision: Vec<f64>,
}

/// Spread of the tilt of the base \[rad\], and of a direction that is not held at its right angle.
const TILT: f64 = 0.05;
const DIRECTION: f64 = 0.15;
/// Spread of the place of an axis \[m\]: how long links are.
const PLACE: f64 = 0.5;

impl UsualArm {
    /// That of a geometry.
    pub fn near(geometry: &Geometry) -> Self {
        let mut usual = Geometry::straight(geometry.n_joints());
        usual.set_tilt(nearest_right_angle(geometry.tilt()));
        for joint in 1..geometry.n_joints() {
            usual.set_direction(joint, nearest_right_angle(geometry.direction(joint)));
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
