//! Derivative of the torque by the geometry: the recursion differentiated (E8).

use super::{Body, Inertia, Moved, Scalar, Wrench, along_z, back, splat, times};
use crate::geometry::GeometryDerivative;
use nalgebra::Vector3;

impl<T: Scalar> Moved<T> {
    /// The change of all torques per unit of one parameter of the geometry, exactly: the recursion
    /// differentiated. [`Self::torque`] must have been called with the inertial parameters meant.
    ///
    /// - `change`: output, \[N·m\], or \[N\] of a slide, per rad or m, n
    pub fn geometry_derivative(&mut self, derivative: &GeometryDerivative, change: &mut [T]) {
        let moved = derivative.joint;
        let mut tangents = std::mem::take(&mut self.tangents);
        tangents.clear();
        let GeometryDerivative { rotation, origin, gravity, .. } = derivative;
        let start = MotionDerivative { acceleration: -splat(gravity), ..Default::default() };
        for (joint, body) in self.bodies.iter().enumerate().skip(moved) {
            let before = if joint == 0 { &self.base } else { &self.bodies[joint - 1] };
            let own = (joint == moved)
                .then(|| [splat(rotation), self.shift_of(joint, (rotation, origin))]);
            let known = tangents.last().unwrap_or(&start);
            let next = if self.kinds.slides(joint) {
                known.slid([before, body], own, self.sliding(joint))
            } else {
                known.next([before, body], own, &body.acceleration)
            };
            tangents.push(next);
        }
        let mut wrench = Wrench::default();
        for (joint, body) in self.bodies.iter().enumerate().rev() {
            if joint >= moved {
                wrench = wrench.plus(&tangents[joint - moved].wrench(body, &self.inertias[joint]));
            }
            change[joint] = wrench.effort(self.kinds.of(joint));
            wrench = wrench.before(body);
            if joint == moved {
                let carried = self.wrenches[joint].before(body);
                let rotation: Vector3<T> = splat(&derivative.rotation);
                let shift = self.shift_of(joint, (&derivative.rotation, &derivative.origin));
                let force = rotation.cross(&carried.force);
                // The moment without the lever of the force turns; the lever moves with the origin.
                let turned = carried.moment - body.origin.cross(&carried.force);
                wrench.force += force;
                wrench.moment += rotation.cross(&turned)
                    + shift.cross(&carried.force)
                    + body.origin.cross(&force);
            }
        }
        self.tangents = tangents;
        self.coupling.load(&mut change[..self.bodies.len()]);
    }
}

/// How the motion of a body changes with one parameter of the geometry, in its own frame.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct MotionDerivative<T: Scalar> {
    omega: Vector3<T>,
    alpha: Vector3<T>,
    acceleration: Vector3<T>,
}

impl<T: Scalar> MotionDerivative<T> {
    /// The change of the next body.
    ///
    /// - `before`, `body`: the motion of the body before and of this one
    /// - `own`: how its own frame turns and shifts, in the frame before, if it does
    /// - `carried`: acceleration of this body but for what its own slide adds, in its frame
    fn next(
        &self,
        [before, body]: [&Body<T>; 2],
        own: Option<[Vector3<T>; 2]>,
        carried: &Vector3<T>,
    ) -> Self {
        let back = |v: Vector3<T>| back(&body.rotation, &v);
        let (w, o) = (&before.omega, &body.origin);
        let Self { mut omega, mut alpha, mut acceleration } = *self;
        acceleration =
            acceleration + alpha.cross(o) + omega.cross(&w.cross(o)) + w.cross(&omega.cross(o));
        if let Some([rotation, origin]) = own {
            omega -= rotation.cross(w);
            alpha -= rotation.cross(&before.alpha);
            let whole = times(&body.rotation, carried);
            acceleration = acceleration + before.alpha.cross(&origin) + w.cross(&w.cross(&origin))
                - rotation.cross(&whole);
        }
        let omega = back(omega);
        let spin = along_z(body.omega.z - body.rotation.column(2).dot(w));
        let alpha = back(alpha) + omega.cross(&spin);
        Self { omega, alpha, acceleration: back(acceleration) }
    }

    /// [`Self::next`] of a body that slides at a speed and acceleration in its own frame.
    fn slid(
        &self,
        [before, body]: [&Body<T>; 2],
        own: Option<[Vector3<T>; 2]>,
        [speed, rate]: [Vector3<T>; 2],
    ) -> Self {
        let next = self.next([before, body], own, &(body.acceleration - rate));
        Self { acceleration: next.acceleration + next.omega.cross(&(speed + speed)), ..next }
    }

    /// The change of the wrench that the motion takes.
    fn wrench(&self, body: &Body<T>, inertia: &Inertia<T>) -> Wrench<T> {
        let Inertia { mass, first, about_origin } = inertia;
        let (w, dw) = (&body.omega, &self.omega);
        Wrench {
            force: self.acceleration * *mass
                + self.alpha.cross(first)
                + dw.cross(&w.cross(first))
                + w.cross(&dw.cross(first)),
            moment: times(about_origin, &self.alpha)
                + dw.cross(&times(about_origin, w))
                + w.cross(&times(about_origin, dw))
                + first.cross(&self.acceleration),
        }
    }
}
