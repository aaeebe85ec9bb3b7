//! What slides, in the recursion: a body goes along z of its frame, which keeps its direction (E26).

use super::{Body, Moved, PER_BODY, Scalar, along_z, back, splat};
use nalgebra::Vector3;

impl<T: Scalar> Body<T> {
    /// This body, behind one before, slid by s: p += s z, and s·(ω̇×z + ω×(ω×z)) of that one and
    /// 2 ω×z ṡ beside z s̈.
    pub(super) fn slid(self, before: &Self, [s, ds, dds]: [T; 3]) -> Self {
        let out = self.rotation.column(2) * s;
        let carried = before.alpha.cross(&out) + before.omega.cross(&before.omega.cross(&out));
        let own = self.omega.cross(&along_z(ds + ds)) + along_z(dds);
        let acceleration = self.acceleration + back(&self.rotation, &carried) + own;
        Self { origin: self.origin + out, acceleration, ..self }
    }

    /// Force along an axis per unit of each parameter.
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

    /// Velocity \[m/s\] of a slide relative to its parent, and the acceleration it adds, z s̈ + 2 ω×z ṡ
    /// \[m/s²\], in the frame of its body.
    pub(super) fn sliding(&self, joint: usize) -> [Vector3<T>; 2] {
        let [_, ds, dds] = self.slides[joint];
        let speed = along_z(ds);
        [speed, self.bodies[joint].omega.cross(&(speed + speed)) + along_z(dds)]
    }
}
