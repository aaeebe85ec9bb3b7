//! Forward dynamics: solves M(q) q̈ = τ − C(q, q̇) q̇ − G(q).

use crate::arm::Arm;
use crate::error::{SimError, check_joints};
use faer::linalg::cholesky::llt::factor::LltError;
use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use torquewise_rigid::{Moved, State};

impl Arm {
    /// Acceleration that a torque causes.
    ///
    /// - `q` \[rad\], `dq` \[rad/s\], `tau` \[N·m\]: n each
    /// - returns: q̈ \[rad/s²\], n
    ///
    /// Source: method.md (1), solved by Cholesky. Checked against: `tests/dynamics/identities.rs`.
    ///
    /// # Errors
    /// [`SimError::JointCount`] for a slice of another length than n;
    /// [`SimError::Massless`] if a joint moves nothing that has mass or inertia.
    pub fn forward_dynamics(
        &self,
        q: &[f64],
        dq: &[f64],
        tau: &[f64],
    ) -> Result<Vec<f64>, SimError> {
        let expected = self.n_joints();
        for (what, values) in [("q", q), ("dq", dq), ("tau", tau)] {
            check_joints(what, values.len(), expected)?;
        }

        let (ddq, mut bias) = (vec![0.0; expected], vec![0.0; expected]);
        let mut moved = Moved::default();
        self.load(State { q, dq, ddq: &ddq }, &mut moved, &mut bias);
        let rest = Mat::from_fn(expected, 1, |i, _| tau[i] - bias[i]);
        let factor = self
            .mass_matrix_of(&moved)
            .llt(Side::Lower)
            .map_err(|LltError::NonPositivePivot { index }| SimError::Massless { joint: index })?;
        Ok(factor.solve(&rest).col_as_slice(0).to_vec())
    }
}
