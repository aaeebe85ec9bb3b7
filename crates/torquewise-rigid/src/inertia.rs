//! Inertial parameters that a rigid body can have: pseudo-inertia, and the divergence from a nominal
//! body (E14).

use crate::{PER_BODY, Placement};
use nalgebra::{Cholesky, Matrix4, Vector3};

/// The ten inertial parameters of a body, as in [`crate::recursion`].
pub type Inertial = [f64; PER_BODY];

/// P = \[Σ h; hᵀ m\], Σ = ½ tr(I) 1 − I: positive definite exactly for the bodies there can be.
pub fn pseudo_inertia(p: &[f64]) -> Matrix4<f64> {
    let [m, hx, hy, hz, xx, yy, zz, xy, xz, yz] = std::array::from_fn(|k| p[k]);
    let [x, y, z] = [yy + zz - xx, xx + zz - yy, xx + yy - zz].map(|sum| 0.5 * sum);
    Matrix4::new(x, -xy, -xz, hx, -xy, y, -yz, hy, -xz, -yz, z, hz, hx, hy, hz, m)
}

/// The inertial parameters of a pseudo-inertia.
pub fn inertial_of(p: &Matrix4<f64>) -> Inertial {
    let [m, hx, hy, hz] = [3, 0, 1, 2].map(|row| p[(row, 3)]);
    let [x, y, z] = [0, 1, 2].map(|axis| p[(axis, axis)]);
    let [xy, xz, yz] = [(0, 1), (0, 2), (1, 2)].map(|pair| -p[pair]);
    [m, hx, hy, hz, y + z, x + z, x + y, xy, xz, yz]
}

/// The inertial parameters of a body seen from another frame, in which its own lies as `placement`
/// says.
pub fn seen_from(inertial: &[f64], placement: &Placement) -> Inertial {
    let mut transform = Matrix4::identity();
    transform.fixed_view_mut::<3, 3>(0, 0).copy_from(&placement.rotation);
    transform.fixed_view_mut::<3, 1>(0, 3).copy_from(&placement.origin);
    inertial_of(&(transform * pseudo_inertia(inertial) * transform.transpose()))
}

/// Whether a body can have these inertial parameters.
pub fn is_feasible(inertial: &[f64]) -> bool {
    Cholesky::new(pseudo_inertia(inertial)).is_some()
}

/// The inertial parameters of a plain link: a uniform rod of the given mass \[kg\] from the origin to
/// `end` \[m\], thickened by a standard deviation of `spread` \[m\] in every direction.
pub fn plain_link(mass: f64, end: &Vector3<f64>, spread: f64) -> Inertial {
    let center = 0.5 * end;
    let second = end * end.transpose() / 12.0
        + center * center.transpose()
        + nalgebra::Matrix3::identity() * spread * spread;
    let mut p = Matrix4::zeros();
    p.fixed_view_mut::<3, 3>(0, 0).copy_from(&(mass * second));
    p.fixed_view_mut::<3, 1>(0, 3).copy_from(&(mass * center));
    p.fixed_view_mut::<1, 3>(3, 0).copy_from(&(mass * center.transpose()));
    p[(3, 3)] = mass;
    inertial_of(&p)
}

/// The log-det divergence D(P‖P⁰) = tr(P⁰⁻¹P) − ln det(P⁰⁻¹P) − 4 of a body from a nominal one, by
/// its inertial parameters. It is convex, zero at P⁰, and grows without bound towards bodies that
/// cannot be.
///
/// `None` outside of the feasible bodies.
///
/// Source: T. Lee, P. Wensing, F. Park, *Geometric robot dynamic identification*, T-RO (2020).
pub fn divergence(inertial: &[f64], nominal: &Inertial) -> Option<f64> {
    let inertia = pseudo_inertia(inertial);
    let p = Cholesky::new(inertia)?;
    let of_nominal = Cholesky::new(pseudo_inertia(nominal))?;
    let log_det = |l: &Cholesky<f64, nalgebra::Const<4>>| -> f64 {
        2.0 * l.l_dirty().diagonal().iter().map(|x| x.ln()).sum::<f64>()
    };
    let ratio = of_nominal.inverse().component_mul(&inertia).sum();
    Some(ratio - log_det(&p) + log_det(&of_nominal) - 4.0)
}

/// Gradient and Hessian of the [`divergence`].
///
/// `None` outside of the feasible bodies.
pub fn divergence_slopes(
    inertial: &[f64],
    nominal: &Inertial,
) -> Option<(Inertial, [Inertial; PER_BODY])> {
    let inverse = Cholesky::new(pseudo_inertia(inertial))?.inverse();
    let change = Cholesky::new(pseudo_inertia(nominal))?.inverse() - inverse;
    let gradient = ENTRIES.map(|own| own.iter().map(|&(i, j, x)| x * change[(j, i)]).sum::<f64>());
    // tr(P⁻¹ Bₖ P⁻¹ Bₗ), of which few entries are not zero.
    let hessian = ENTRIES.map(|first| {
        ENTRIES.map(|second| {
            let pair = |&(i, j, x): &(usize, usize, f64)| -> f64 {
                let own = second.iter();
                own.map(|&(k, l, y)| x * y * inverse[(l, i)] * inverse[(j, k)]).sum()
            };
            first.iter().map(pair).sum()
        })
    });
    Some((gradient, hessian))
}

/// Row, column and value of the entries of the pseudo-inertia that each inertial parameter makes.
const ENTRIES: [&[(usize, usize, f64)]; PER_BODY] = [
    &[(3, 3, 1.0)],
    &[(0, 3, 1.0), (3, 0, 1.0)],
    &[(1, 3, 1.0), (3, 1, 1.0)],
    &[(2, 3, 1.0), (3, 2, 1.0)],
    &[(0, 0, -0.5), (1, 1, 0.5), (2, 2, 0.5)],
    &[(0, 0, 0.5), (1, 1, -0.5), (2, 2, 0.5)],
    &[(0, 0, 0.5), (1, 1, 0.5), (2, 2, -0.5)],
    &[(0, 1, -1.0), (1, 0, -1.0)],
    &[(0, 2, -1.0), (2, 0, -1.0)],
    &[(1, 2, -1.0), (2, 1, -1.0)],
];

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    fn link() -> Inertial {
        plain_link(3.0, &Vector3::new(0.3, -0.1, 0.2), 0.08)
    }

    #[test]
    fn a_plain_link_weighs_what_it_should_about_its_middle() {
        let p = plain_link(2.0, &Vector3::new(0.6, 0.0, 0.0), 0.0);
        // A rod about its end: m l²/3 across, nothing along.
        assert_relative_eq!(p[4], 0.0, epsilon = 1e-15);
        assert_relative_eq!(p[5], 2.0 * 0.36 / 3.0, epsilon = 1e-15);
        assert_relative_eq!(p[1], 0.6, epsilon = 1e-15);
    }

    #[test]
    fn the_divergence_is_zero_and_level_at_the_nominal_body() {
        let value = divergence(&link(), &link()).unwrap();
        let (gradient, _) = divergence_slopes(&link(), &link()).unwrap();
        assert_relative_eq!(value, 0.0, epsilon = 1e-12);
        for slope in gradient {
            assert_relative_eq!(slope, 0.0, epsilon = 1e-9);
        }
    }

    #[test]
    fn slopes_of_the_divergence_are_those_of_differences() {
        let nominal = plain_link(2.0, &Vector3::new(0.1, 0.2, 0.0), 0.1);
        let (gradient, hessian) = divergence_slopes(&link(), &nominal).unwrap();
        for k in 0..PER_BODY {
            let moved = |step: f64| {
                let mut moved = link();
                moved[k] += step;
                moved
            };
            let [ahead, behind] = [1e-6, -1e-6].map(moved);
            let value = |at: &Inertial| divergence(at, &nominal).unwrap();
            let slope = (value(&ahead) - value(&behind)) / 2e-6;
            assert_relative_eq!(gradient[k], slope, max_relative = 1e-5, epsilon = 1e-4);
            let slopes = |at: &Inertial| divergence_slopes(at, &nominal).unwrap().0;
            let pairs = slopes(&ahead).into_iter().zip(slopes(&behind));
            for (curvature, (ahead, behind)) in hessian[k].iter().zip(pairs) {
                let slope = (ahead - behind) / 2e-6;
                assert_relative_eq!(*curvature, slope, max_relative = 1e-3, epsilon = 1.0);
            }
        }
    }
}
