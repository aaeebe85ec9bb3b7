//! M(q) by composite rigid bodies, from the tip inward.

use super::{Body, Inertia, Moved, PER_BODY, Scalar, Wrench, along_z, product, times};
use crate::JointKind;
use nalgebra::Matrix3;

impl<T: Scalar> Moved<T> {
    /// M(q) \[kg·m²\] where the bodies are, however they move. `put(i, j, value)` is called for
    /// i ≤ j.
    ///
    /// Column j is the torque when only joint j accelerates, at rest and without gravity: all links
    /// beyond it move as one rigid body, and the joints before it hold that body's force.
    ///
    /// - `inertial`: inertial parameters of all bodies, 10 each
    ///
    /// Source: M. Walker, D. Orin, J. Dyn. Sys. Meas. Control 104 (1982).
    pub fn mass_matrix(&self, inertial: &[f64], mut put: impl FnMut(usize, usize, T)) {
        if self.coupling.is_none() {
            return self.mass_matrix_of_chain(inertial, put);
        }
        let n = self.bodies.len();
        let mut columns = vec![vec![T::zero(); n]; n];
        self.mass_matrix_of_chain(inertial, |i, j, value| {
            (columns[i][j], columns[j][i]) = (value, value);
        });
        // ΓᵀM, column by column, then the same of its rows.
        for column in &mut columns {
            self.coupling.load(column);
        }
        for i in 0..n {
            let mut row: Vec<T> = columns.iter().map(|column| column[i]).collect();
            self.coupling.load(&mut row);
            (i..n).for_each(|j| put(i, j, row[j]));
        }
    }

    /// M of the joints of the chain.
    fn mass_matrix_of_chain(&self, inertial: &[f64], mut put: impl FnMut(usize, usize, T)) {
        let mut composite = Inertia::default();
        for (j, body) in self.bodies.iter().enumerate().rev() {
            composite = composite.plus(&Inertia::of(&inertial[PER_BODY * j..]));
            let mut wrench = composite.unit_wrench(self.kinds.of(j));
            put(j, j, wrench.effort(self.kinds.of(j)));
            for i in (0..j).rev() {
                wrench = wrench.before(&self.bodies[i + 1]);
                put(i, j, wrench.effort(self.kinds.of(i)));
            }
            composite = composite.before(body);
        }
    }
}

impl<T: Scalar> Inertia<T> {
    /// Both welded together.
    pub fn plus(&self, other: &Self) -> Self {
        Self {
            mass: self.mass + other.mass,
            first: self.first + other.first,
            about_origin: self.about_origin + other.about_origin,
        }
    }

    /// Force and moment that move it from rest as a joint does at an acceleration of 1: about z, along
    /// it.
    fn unit_wrench(&self, kind: JointKind) -> Wrench<T> {
        let z = along_z(T::one());
        let [turn, slide] = kind.twist.map(T::splat);
        let force = z.cross(&self.first) * turn + along_z(self.mass * slide);
        let moment = self.about_origin.column(2) * turn + self.first.cross(&z) * slide;
        Wrench { force, moment }
    }

    /// The same in the frame before that of a body: turned, then moved (Huygens–Steiner).
    fn before(&self, body: &Body<T>) -> Self {
        let Body { rotation, origin, .. } = body;
        let carried = times(rotation, &self.first);
        let first = carried + origin * self.mass;
        // The sum over its points of |p + r|² − (p + r)(p + r)ᵀ less that of |r|² − r rᵀ.
        let trace = origin.dot(&(carried + first));
        let shift = Matrix3::from_diagonal_element(trace)
            - origin * first.transpose()
            - carried * origin.transpose();
        let turned = product(&product(rotation, &self.about_origin), &rotation.transpose());
        Self { mass: self.mass, first, about_origin: turned + shift }
    }
}
