//! Arm, q, q̇, q̈ → regressor: the torque per unit of each inertial parameter.
#![expect(non_snake_case, reason = "frames are written quantity_fromTo, as in `spatial`")]

use crate::arm::Arm;
use crate::inverse::Twist;
use faer::Mat;
use nalgebra::{Matrix3, Vector3};

/// Inertial parameters of a body: m, m·c (3), then the moments about the origin of its frame, xx,
/// yy, zz, xy, xz, yz.
pub const PARAMETERS_PER_BODY: usize = 10;

impl Arm {
    /// Y of τ = Y(q, q̇, q̈) π: what each inertial parameter of each body adds to each torque.
    ///
    /// - `q` \[rad\], `dq` \[rad/s\], `ddq` \[rad/s²\]: n each
    /// - returns: n×10n, ten columns for each body
    ///
    /// The masses of the arm are not used, its kinematics are. Rotors are not among the parameters.
    ///
    /// Source: C. Atkeson, C. An, J. Hollerbach, Int. J. Robotics Research 5 (1986). Checked
    /// against: [`Arm::inverse_dynamics`].
    ///
    /// # Panics
    /// If a slice does not hold n numbers.
    pub fn regressor(&self, q: &[f64], dq: &[f64], ddq: &[f64]) -> Mat<f64> {
        self.check_lengths(&[("q", q), ("dq", dq), ("ddq", ddq)]);
        let n = self.n_joints();
        let mut regressor = Mat::zeros(n, PARAMETERS_PER_BODY * n);
        let mut twist = Twist::base(self.gravity_vector());
        let mut poses = Vec::with_capacity(n);
        for (k, joint) in self.chain().iter().enumerate() {
            poses.push(joint.pose(q[k]));
            twist = twist.beyond(joint, &poses[k], dq[k], ddq[k]);
            for parameter in 0..PARAMETERS_PER_BODY {
                let (mut force, mut moment) = unit_wrench(&twist, parameter);
                for i in (0..=k).rev() {
                    regressor[(i, PARAMETERS_PER_BODY * k + parameter)] =
                        self.chain()[i].axis.dot(&moment);
                    let X_PJ = &poses[i];
                    force = X_PJ.R_AB * force;
                    moment = X_PJ.R_AB * moment + X_PJ.p_AB.cross(&force);
                }
            }
        }
        regressor
    }

    /// The inertial parameters π of all bodies, 10n, in the order of [`Arm::regressor`].
    pub fn inertial_parameters(&self) -> Vec<f64> {
        let of = |joint: &crate::arm::Joint| {
            let body = &joint.body;
            let c = body.com;
            let shift = Matrix3::identity() * c.norm_squared() - c * c.transpose();
            let about = body.inertia + body.mass * shift;
            let first = body.mass * c;
            let moments = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)].map(|at| about[at]);
            [body.mass, first.x, first.y, first.z].into_iter().chain(moments)
        };
        self.chain().iter().flat_map(of).collect()
    }
}

/// Force and moment about the origin that moving one unit of a parameter takes.
fn unit_wrench(twist: &Twist, parameter: usize) -> (Vector3<f64>, Vector3<f64>) {
    let Twist { w, dw, a } = twist;
    match parameter {
        0 => (*a, Vector3::zeros()),
        1..=3 => {
            let first = Vector3::ith(parameter - 1, 1.0);
            (dw.cross(&first) + w.cross(&w.cross(&first)), first.cross(a))
        }
        _ => {
            let (row, column) = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)][parameter - 4];
            let mut inertia = Matrix3::zeros();
            (inertia[(row, column)], inertia[(column, row)]) = (1.0, 1.0);
            (Vector3::zeros(), inertia * dw + w.cross(&(inertia * w)))
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::Arm;

    #[test]
    fn the_regressor_times_the_masses_is_the_torque() {
        let arm = Arm::builtin("puma560-3").unwrap();
        let masses = arm.inertial_parameters();
        for k in 0..20 {
            let state = |shift: f64| -> Vec<f64> {
                (0..3).map(|j| (f64::from(k) + shift + 1.7 * f64::from(j)).sin() * 2.0).collect()
            };
            let (q, dq, ddq) = (state(0.0), state(0.4), state(0.9));
            let regressor = arm.regressor(&q, &dq, &ddq);
            let torque = arm.inverse_dynamics(&q, &dq, &ddq);
            for (i, torque) in torque.iter().enumerate() {
                let sum: f64 = (0..30).map(|j| regressor[(i, j)] * masses[j]).sum();
                assert!((sum - torque).abs() < 1e-11 * (1.0 + torque.abs()), "{sum} {torque}");
            }
        }
    }
}
