//! Frames that compose, bodies that weld.
#![expect(non_snake_case, reason = "frames are written quantity_fromTo: X_AB = X_AC * X_CB")]

use nalgebra::{IsometryMatrix3, Matrix3, Rotation3, Translation3, Unit, Vector3};
use torquewise_rigid::recursion::Inertia;
use torquewise_rigid::{PER_BODY, Placement};

/// Frame B seen from frame A: it turns B's components of a vector into A's, its translation is the
/// origin of B \[m\], in A.
pub(crate) type Pose = IsometryMatrix3<f64>;

/// Shift \[m\], then fixed-axis roll, pitch, yaw \[rad\], as a URDF `<origin>` says it.
pub(crate) fn shifted_turned(xyz: [f64; 3], rpy: [f64; 3]) -> Pose {
    Pose::from_parts(xyz.into(), Rotation3::from_euler_angles(rpy[0], rpy[1], rpy[2]))
}

/// Turn about z by `theta`, shift along z by `d`, shift along x by `a`, turn about x by `alpha`: one
/// row of a standard Denavit–Hartenberg table.
pub(crate) fn dh_row(theta: f64, d: f64, a: f64, alpha: f64) -> Pose {
    let about_z = Rotation3::from_axis_angle(&Vector3::z_axis(), theta);
    let turned = about_z * Rotation3::from_axis_angle(&Vector3::x_axis(), alpha);
    Pose::from_parts((about_z * Vector3::new(a, 0.0, d)).into(), turned)
}

/// Turned so that z lies along `axis`; no turn at all if `axis` is z.
pub(crate) fn with_z_along(axis: &Unit<Vector3<f64>>) -> Pose {
    let x = Vector3::ith(axis.iamin(), 1.0);
    let x = (x - axis.into_inner() * axis.dot(&x)).normalize();
    let turned = Matrix3::from_columns(&[x, axis.cross(&x), axis.into_inner()]);
    Pose::from_parts(Translation3::identity(), Rotation3::from_matrix_unchecked(turned))
}

pub(crate) fn pose(Placement { rotation, origin }: &Placement) -> Pose {
    Pose::from_parts((*origin).into(), Rotation3::from_matrix_unchecked(*rotation))
}

pub(crate) fn placement(X_AB: &Pose) -> Placement {
    Placement { rotation: *X_AB.rotation.matrix(), origin: X_AB.translation.vector }
}

/// Mass distribution of a rigid body, in one frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Body {
    /// \[kg\]
    pub mass: f64,
    /// Centre of mass \[m\].
    pub com: Vector3<f64>,
    /// Inertia about the centre of mass \[kg·m²\].
    pub inertia: Matrix3<f64>,
}

impl Body {
    /// Moments in the order ixx, iyy, izz, ixy, ixz, iyz.
    pub(crate) fn new(mass: f64, com: [f64; 3], moments: [f64; 6]) -> Self {
        let [xx, yy, zz, xy, xz, yz] = moments;
        let inertia = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
        Self { mass, com: com.into(), inertia }
    }

    /// The body of inertial parameters m, m·c and moments about the origin; the mass is not zero.
    pub fn of_parameters(p: &[f64; PER_BODY]) -> Self {
        let Inertia::<f64> { mass, first, about_origin } = Inertia::of(p);
        let com = first / mass;
        let shift = Matrix3::identity() * com.norm_squared() - com * com.transpose();
        Self { mass, com, inertia: about_origin - mass * shift }
    }

    pub(crate) fn seen_from(&self, X_AB: &Pose) -> Self {
        let turn = X_AB.rotation.matrix();
        let com = X_AB.translation.vector + turn * self.com;
        Self { mass: self.mass, com, inertia: turn * self.inertia * turn.transpose() }
    }

    /// Both bodies welded together, all in one frame.
    pub(crate) fn welded_to(&self, other: &Self) -> Self {
        let mass = self.mass + other.mass;
        if mass <= 0.0 {
            return Self { inertia: self.inertia + other.inertia, ..Self::default() };
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
pub(crate) fn is_positive_semidefinite(inertia: &Matrix3<f64>) -> bool {
    let scale = inertia.amax();
    // Tables are printed to six digits or so: a flat body may come out a little negative.
    scale == 0.0 || (inertia / scale).symmetric_eigenvalues().min() >= -1e-5
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
        let turn_z = shifted_turned([0.0; 3], [0.0, 0.0, 0.3]);
        let shift = shifted_turned([0.2, 0.0, 0.1], [0.0; 3]);
        let turn_x = shifted_turned([0.0; 3], [-0.7, 0.0, 0.0]);

        let row = dh_row(0.3, 0.1, 0.2, -0.7);

        let product = turn_z * shift * turn_x;
        assert_relative_eq!(row, product, epsilon = 1e-15);
    }

    #[test]
    fn a_body_seen_from_a_turned_frame_keeps_its_moments() {
        let body = Body::new(2.0, [0.1, 0.2, 0.3], [1.0, 2.0, 3.0, 0.0, 0.0, 0.0]);
        let quarter = shifted_turned([0.0; 3], [0.0, 0.0, std::f64::consts::FRAC_PI_2]);

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
