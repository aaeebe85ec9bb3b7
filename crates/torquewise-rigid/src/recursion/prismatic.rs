//! Sliding joints in the recursion: a body slides along z of its frame, which keeps its direction
//! (E26).

use super::{Body, Moved, PER_BODY, Scalar, along_z, splat};
use crate::geometry::Placement;
use nalgebra::{Matrix3, Vector3};

impl<T: Scalar> Body<T> {
    /// The body behind the next joint, which slides: p += q z, and 2 ω×z q̇ beside z q̈.
    pub(super) fn slid(&self, placement: &Placement, q: T, dq: T, ddq: T) -> Self {
        let rotation: Matrix3<T> = placement.rotation.map(T::splat);
        let origin: Vector3<T> = splat::<T>(&placement.origin) + rotation.column(2) * q;
        let omega: Vector3<T> = rotation.tr_mul(&self.omega);
        let alpha: Vector3<T> = rotation.tr_mul(&self.alpha);
        let carried = self.acceleration
            + self.alpha.cross(&origin)
            + self.omega.cross(&self.omega.cross(&origin));
        let acceleration =
            rotation.tr_mul(&carried) + omega.cross(&along_z(dq + dq)) + along_z(ddq);
        Self { rotation, origin, omega, alpha, acceleration }
    }

    /// Force along a slide per unit of each parameter.
    pub(super) fn pushes(&self, along: &Vector3<T>) -> [T; PER_BODY] {
        let (w, dw, a) = (&self.omega, &self.alpha, &self.acceleration);
        // along·(ω̇×e + ω×(ω×e)) for the three unit vectors e at once; moments push nothing.
        let first = along.cross(dw) + w * w.dot(along) - along * w.dot(w);
        let mut forces = [T::zero(); PER_BODY];
        forces[..4].copy_from_slice(&[along.dot(a), first.x, first.y, first.z]);
        forces
    }
}

impl<T: Scalar> Moved<T> {
    /// Derivative of the origin of a joint, in the parent frame, as its placement turns by `rotation`
    /// and shifts by `origin`: the distance it has slid turns along.
    pub(super) fn shift_of(
        &self,
        joint: usize,
        (rotation, origin): (&Vector3<f64>, &Vector3<f64>),
    ) -> Vector3<T> {
        let shift: Vector3<T> = splat(origin);
        if !self.kinds.slides(joint) {
            return shift;
        }
        let slide = self.bodies[joint].rotation.column(2) * self.slides[joint][0];
        shift + splat::<T>(rotation).cross(&slide)
    }

    /// Velocity \[m/s\] of a slide relative to its parent, and the acceleration it adds, z q̈ + 2 ω×z q̇
    /// \[m/s²\], in the frame of its body.
    pub(super) fn sliding(&self, joint: usize) -> [Vector3<T>; 2] {
        let [_, dq, ddq] = self.slides[joint];
        let speed = along_z(dq);
        [speed, self.bodies[joint].omega.cross(&(speed + speed)) + along_z(ddq)]
    }
}
