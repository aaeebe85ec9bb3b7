//! Residual of a chain, and its derivative by each parameter (E11).

use crate::inertial_fit::weighted_columns;
use crate::levenberg_marquardt::changes;
use crate::{Chain, ChainRows, Result, expect};
use faer::Mat;

/// The torque of rows, linearised at a chain.
///
/// Equations as in [`ChainRows`]: all rows of joint 1 first. Each is divided by the noise of its joint
/// and counts as the rows say.
#[derive(Clone, Debug)]
pub struct Tangent {
    /// What each equation counts: its share over the noise of its joint, m·n.
    pub weights: Vec<f64>,
    /// Weighted residual, m·n.
    pub residual: Vec<f64>,
    /// Change of the weighted torque per unit of each parameter, (m·n)×p: masses, what stands
    /// beside the links, and the geometry.
    pub columns: Mat<f64>,
}

impl Chain {
    /// What the chain leaves of some rows, linearised in its masses and these parameters of its geometry.
    ///
    /// - `weights`: one over the noise of each joint \[1/(N·m)\], n
    ///
    /// # Errors
    /// [`ChainError::Shape`](crate::ChainError::Shape) if the rows are of another arm, or have other columns beside the
    /// chain.
    pub fn tangent(&self, rows: &ChainRows, weights: &[f64], free: &[usize]) -> Result<Tangent> {
        let (m, n) = (rows.len(), rows.n_joints());
        expect("geometry", self.geometry.n_joints(), n)?;
        expect("drive", self.drive.len(), rows.extras.ncols())?;
        expect("weights", weights.len(), n)?;
        let masses: Vec<f64> = self.inertial.iter().chain(&self.drive).copied().collect();
        let moves = changes((rows, weights), &self.geometry, &masses, free);
        let weights = rows.counted(weights);
        let linear = weighted_columns(&self.geometry, rows, &weights);
        let mut residual: Vec<f64> =
            weights.iter().zip(&rows.torque).map(|(weight, tau)| weight * tau).collect();
        let p = masses.len();
        let mut columns = Mat::zeros(m * n, p + free.len());
        for (joint, own) in linear.iter().enumerate() {
            own.subtract(&masses, &mut residual[joint * m..(joint + 1) * m]);
            for (k, &place) in own.places.iter().enumerate() {
                columns.col_mut(place).subrows_mut(joint * m, m).copy_from(own.columns.col(k));
            }
        }
        columns.subcols_mut(p, free.len()).copy_from(&moves);
        Ok(Tangent { weights, residual, columns })
    }
}
