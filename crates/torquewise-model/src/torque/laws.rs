//! Laws of friction over a motion.

use super::{Remembered, Torque};
use crate::{ModelError, Weighted};
use faer::Mat;
use torquewise_motion::Motion;

impl Torque {
    /// What each law of friction comes to at the rows of a motion, per unit of its coefficient, on
    /// its shaft, m×k in the order of [`crate::Model::friction`].
    ///
    /// # Errors
    /// [`ModelError::JointCount`] if the motion is of another arm.
    pub fn laws(&self, motion: &Motion) -> Result<Mat<f64>, ModelError> {
        let mut laws = Mat::zeros(motion.n_rows(), self.friction.len());
        self.visit_laws_of(motion, |row, k, _, [value, load]| laws[(row, k)] = value * load)?;
        Ok(laws)
    }

    /// What friction may take from and add to the torque that is predicted \[N·m\], m×n each: where a shaft
    /// rests, dry friction holds it with whatever is asked of it, up to that at which it breaks away.
    ///
    /// # Errors
    /// As [`Self::laws`].
    pub fn held(&self, motion: &Motion) -> Result<[Mat<f64>; 2], ModelError> {
        let mut ends = [(); 2].map(|()| Mat::zeros(motion.n_rows(), self.n_joints));
        self.visit_laws_of(motion, |row, k, dq, [value, load]| {
            let Weighted { term, coefficient, .. } = &self.friction[k];
            let limit: f64 =
                term.shaft.iter().zip(&self.rest_speeds).map(|(s, v)| s.abs() * v).sum();
            if !term.law.is_dry() || term.speed(dq).abs() >= limit {
                return;
            }
            for (end, way) in ends.iter_mut().zip([-1.0, 1.0]) {
                let there = if term.direction.holds(way) { way } else { 0.0 };
                for (joint, shaft) in term.shaft.iter().enumerate().filter(|(_, s)| **s != 0.0) {
                    end[(row, joint)] += shaft * coefficient * (there - value) * load;
                }
            }
        })?;
        let [one, other] = ends;
        let of = |pick: fn(f64, f64) -> f64| {
            Mat::from_fn(one.nrows(), one.ncols(), |row, joint| {
                pick(pick(one[(row, joint)], other[(row, joint)]), 0.0)
            })
        };
        Ok([of(f64::min), of(f64::max)])
    }

    /// Hands over each law at each row of a motion: row, place of the law, q̇, and [`Self::visit_laws`].
    fn visit_laws_of(
        &self,
        motion: &Motion,
        mut put: impl FnMut(usize, usize, &[f64], [f64; 2]),
    ) -> Result<(), ModelError> {
        self.check_joints(motion)?;
        let motion = self.path().follow(0, motion);
        for row in 0..motion.n_rows() {
            let [q, dq, _] = motion.state(row);
            let memory = |joint, travel| motion.memory()?.state(row, joint, travel);
            let gravity = if self.is_load_dependent { self.gravity(&q)? } else { Vec::new() };
            self.visit_laws((&gravity, &dq), &memory, |k, law| put(row, k, &dq, law));
        }
        Ok(())
    }

    /// Hands over each law: its place, and what it comes to per unit of its coefficient, without a load
    /// and the load.
    ///
    /// - `gravity`: G(q) \[N·m\], n
    pub(super) fn visit_laws(
        &self,
        (gravity, dq): (&[f64], &[f64]),
        memory: Remembered<'_>,
        mut put: impl FnMut(usize, [f64; 2]),
    ) {
        for (k, Weighted { term, .. }) in self.friction.iter().enumerate() {
            let state = term.element().and_then(|(joint, travel)| memory(joint, travel));
            put(k, [state.unwrap_or_else(|| term.value(dq)), term.pressed(gravity)]);
        }
    }
}
