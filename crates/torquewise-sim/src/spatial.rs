//! Frames that compose, bodies that weld.
#![expect(non_snake_case, reason = "frames are written quantity_fromTo: X_AB = X_AC * X_CB")]

use nalgebra::{Matrix3, Rotation3, Unit, Vector3};
use std::ops::Mul;
use torquewise_rigid::recursion::PER_BODY;

/// Frame B seen from frame A.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pose {
    /// Turns B's components of a vector into A's.
    pub(crate) R_AB: Matrix3<f64>,
    /// Origin of B \[m\], in A.
    pub(crate) p_AB: Vector3<f64>,
}

impl Pose {
    pub(crate) fn identity() -> Self {
        Self { R_AB: Matrix3::identity(), p_AB: Vector3::zeros() }
    }

    /// Shift \[m\], then fixed-axis roll, pitch, yaw \[rad\], as a URDF `<origin>` says it.
    pub(crate) fn from_xyz_rpy(xyz: [f64; 3], rpy: [f64; 3]) -> Self {
        let R_AB = *Rotation3::from_euler_angles(rpy[0], rpy[1], rpy[2]).matrix();
        Self { R_AB, p_AB: xyz.into() }
    }

    /// Turn about z by `theta`, shift along z by `d`, shift along x by `a`, turn about x by
    /// `alpha`: one row of a standard Denavit–Hartenberg table.
    pub(crate) fn from_dh(theta: f64, d: f64, a: f64, alpha: f64) -> Self {
        let turn = |axis, angle| *Rotation3::from_axis_angle(&axis, angle).matrix();
        let about_z = turn(Vector3::z_axis(), theta);
        Self {
            R_AB: about_z * turn(Vector3::x_axis(), alpha),
            p_AB: about_z * Vector3::new(a, 0.0, d),
        }
    }

    /// Turned so that z lies along `axis`; no turn at all if `axis` is z.
    pub(crate) fn with_z_along(axis: &Unit<Vector3<f64>>) -> Self {
        let x = Vector3::ith(axis.iamin(), 1.0);
        let x = (x - axis.into_inner() * axis.dot(&x)).normalize();
        let R_AB = Matrix3::from_columns(&[x, axis.cross(&x), axis.into_inner()]);
        Self { R_AB, p_AB: Vector3::zeros() }
    }

    pub(crate) fn inverse(&self) -> Self {
        Self { R_AB: self.R_AB.transpose(), p_AB: -self.R_AB.tr_mul(&self.p_AB) }
    }
}

impl Mul for Pose {
    type Output = Self;

    /// X_AC = X_AB * X_BC.
    fn mul(self, X_BC: Self) -> Self {
        Self { R_AB: self.R_AB * X_BC.R_AB, p_AB: self.p_AB + self.R_AB * X_BC.p_AB }
    }
}

/// Mass distribution of a rigid body, in one frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Body {
    pub(crate) mass: f64,
    /// Centre of mass \[m\].
    pub(crate) com: Vector3<f64>,
    /// Inertia about the centre of mass \[kg·m²\].
    pub(crate) inertia: Matrix3<f64>,
}

impl Body {
    pub(crate) fn none() -> Self {
        Self { mass: 0.0, com: Vector3::zeros(), inertia: Matrix3::zeros() }
    }

    /// Moments in the order ixx, iyy, izz, ixy, ixz, iyz.
    pub(crate) fn new(mass: f64, com: [f64; 3], moments: [f64; 6]) -> Self {
        let [xx, yy, zz, xy, xz, yz] = moments;
        let inertia = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
        Self { mass, com: com.into(), inertia }
    }

    /// The body of inertial parameters m, m·c and moments about the origin; the mass is not zero.
    pub(crate) fn of_parameters(p: &[f64; PER_BODY]) -> Self {
        let [mass, x, y, z, xx, yy, zz, xy, xz, yz] = *p;
        let com = Vector3::new(x, y, z) / mass;
        let about_origin = Self::new(mass, [0.0; 3], [xx, yy, zz, xy, xz, yz]).inertia;
        let shift = Matrix3::identity() * com.norm_squared() - com * com.transpose();
        Self { mass, com, inertia: about_origin - mass * shift }
    }

    pub(crate) fn seen_from(&self, X_AB: &Pose) -> Self {
        Self {
            mass: self.mass,
            com: X_AB.p_AB + X_AB.R_AB * self.com,
            inertia: X_AB.R_AB * self.inertia * X_AB.R_AB.transpose(),
        }
    }

    /// Both bodies welded together, all in one frame.
    pub(crate) fn welded_to(&self, other: &Self) -> Self {
        let mass = self.mass + other.mass;
        if mass <= 0.0 {
            return Self { inertia: self.inertia + other.inertia, ..Self::none() };
        }
        let com = (self.com * self.mass + other.com * other.mass) / mass;
        Self { mass, com, inertia: self.inertia_about(&com) + other.inertia_about(&com) }
    }

    /// What is left once another is taken away, all in one frame; it may be no body.
    pub(crate) fn without(&self, other: &Self) -> Self {
        let (whole, part) = (self.inertial_parameters(), other.inertial_parameters());
        if part.iter().all(|x| *x == 0.0) {
            return *self;
        }
        Self::of_parameters(&std::array::from_fn(|k| whole[k] - part[k]))
    }

    /// Inertia \[kg·m²\] about a point of the frame (Huygens–Steiner).
    fn inertia_about(&self, point: &Vector3<f64>) -> Matrix3<f64> {
        let r = self.com - point;
        self.inertia + self.mass * (Matrix3::identity() * r.norm_squared() - r * r.transpose())
    }

    /// m, m·c (3), and the moments about the origin: xx, yy, zz, xy, xz, yz.
    pub(crate) fn inertial_parameters(&self) -> [f64; PER_BODY] {
        let first = self.mass * self.com;
        let i = self.inertia_about(&Vector3::zeros());
        [self.mass, first.x, first.y, first.z, i.m11, i.m22, i.m33, i.m12, i.m13, i.m23]
    }
}

/// Whether no principal moment of a symmetric matrix is negative, up to rounding.
///
/// All principal minors are compared with 0, after scaling to the largest entry so that no
/// product overflows.
pub(crate) fn is_positive_semidefinite(inertia: &Matrix3<f64>) -> bool {
    let scale = inertia.amax();
    if scale == 0.0 {
        return true;
    }
    let unit = inertia / scale;
    let minor = |i: usize, j: usize| unit[(i, i)] * unit[(j, j)] - unit[(i, j)] * unit[(j, i)];
    let minors = [
        unit[(0, 0)],
        unit[(1, 1)],
        unit[(2, 2)],
        minor(0, 1),
        minor(0, 2),
        minor(1, 2),
        unit.determinant(),
    ];
    // Tables are printed to six digits or so: a flat body may come out a little negative.
    minors.iter().all(|&minor| minor >= -1e-6)
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn two_halves_of_a_rod_weigh_and_turn_like_the_whole() {
        let rod = |length: f64, mass: f64, middle: f64| {
            let across = mass * length * length / 12.0;
            Body::new(mass, [middle, 0.0, 0.0], [0.0, across, across, 0.0, 0.0, 0.0])
        };

        let whole = rod(0.5, 1.5, 0.25).welded_to(&rod(0.5, 1.5, 0.75));

        assert_relative_eq!(whole.mass, 3.0);
        assert_relative_eq!(whole.com, Vector3::new(0.5, 0.0, 0.0));
        assert_relative_eq!(whole.inertia, rod(1.0, 3.0, 0.5).inertia, epsilon = 1e-15);
    }

    #[test]
    fn a_dh_row_is_the_product_of_its_four_motions() {
        let turn_z = Pose::from_xyz_rpy([0.0; 3], [0.0, 0.0, 0.3]);
        let shift = Pose::from_xyz_rpy([0.2, 0.0, 0.1], [0.0; 3]);
        let turn_x = Pose::from_xyz_rpy([0.0; 3], [-0.7, 0.0, 0.0]);

        let row = Pose::from_dh(0.3, 0.1, 0.2, -0.7);

        let product = turn_z * shift * turn_x;
        assert_relative_eq!(row.R_AB, product.R_AB, epsilon = 1e-15);
        assert_relative_eq!(row.p_AB, product.p_AB, epsilon = 1e-15);
    }

    #[test]
    fn a_body_seen_from_a_turned_frame_keeps_its_moments() {
        let body = Body::new(2.0, [0.1, 0.2, 0.3], [1.0, 2.0, 3.0, 0.0, 0.0, 0.0]);
        let quarter = Pose::from_xyz_rpy([0.0; 3], [0.0, 0.0, std::f64::consts::FRAC_PI_2]);

        let turned = body.seen_from(&quarter);

        let expected = Body::new(2.0, [-0.2, 0.1, 0.3], [2.0, 1.0, 3.0, 0.0, 0.0, 0.0]);
        assert_relative_eq!(turned.com, expected.com, epsilon = 1e-15);
        assert_relative_eq!(turned.inertia, expected.inertia, epsilon = 1e-15);
    }

    #[test]
    fn a_negative_principal_moment_is_seen_behind_positive_diagonals() {
        let fine = Body::new(1.0, [0.0; 3], [1e300, 2e300, 2e300, 0.0, 0.0, 0.0]).inertia;
        let wrong = Body::new(1.0, [0.0; 3], [1.0, 1.0, 1.0, 1.5, 0.0, 0.0]).inertia;

        assert!(is_positive_semidefinite(&fine));
        assert!(!is_positive_semidefinite(&wrong));
    }
}
