//! Regions of configuration: what a log repeats in time is still unseen where the arm has not been
//! (E20).

use serde::{Deserialize, Serialize};
use torquewise_motion::Motion;
use torquewise_regression::kmeans::kmeans;
use torquewise_rigid::recursion::MOST_JOINTS;
use torquewise_stepwise::thinned;

/// Rows that regions are found on, at most.
const ROWS: usize = 4_000;

/// Configurations shared out among centres, each joint counted by its own spread.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Regions {
    /// One over the spread of each joint \[1/rad\], n; none of a joint that does not move.
    scales: Vec<f64>,
    /// Positions in units of the spread, k×n.
    centres: Vec<Vec<f64>>,
}

impl Regions {
    /// Clusters the positions of a motion by k-means; fewer regions where it has fewer rows.
    pub(crate) fn of(motion: &Motion, count: usize) -> Self {
        let motion = thinned(motion, ROWS);
        let (m, n) = (motion.n_rows(), motion.n_joints());
        let scale = |joint: usize| {
            let q = motion.q().col(joint);
            let mean = q.iter().sum::<f64>() / m.max(1) as f64;
            let variance = q.iter().map(|q| (q - mean).powi(2)).sum::<f64>() / m.max(1) as f64;
            if variance > 0.0 { 1.0 / variance.sqrt() } else { 0.0 }
        };
        let scales: Vec<f64> = (0..n).map(scale).collect();
        let point = |row: usize| -> [f64; MOST_JOINTS] {
            std::array::from_fn(|joint| {
                if joint < n { scales[joint] * motion.q()[(row, joint)] } else { 0.0 }
            })
        };
        let points: Vec<_> = (0..m).map(point).collect();
        // Rows that are no numbers are no regions: whoever reads them on says where.
        let found = kmeans(&points, count.min(m), 0);
        let centres = found.map_or_else(|_| Vec::new(), |found| found.centres);
        Self { scales, centres: centres.iter().map(|centre| centre[..n].to_vec()).collect() }
    }

    /// The region of a row of a motion of the same arm.
    pub(crate) fn of_row(&self, motion: &Motion, row: usize) -> usize {
        let apart = |centre: &Vec<f64>| -> f64 {
            let own = self.scales.iter().enumerate().zip(centre);
            own.map(|((joint, scale), x)| (scale * motion.q()[(row, joint)] - x).powi(2)).sum()
        };
        let nearest = self.centres.iter().map(apart).enumerate();
        nearest.min_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |(region, _)| region)
    }

    pub(crate) fn is_sound(&self, n: usize) -> bool {
        let finite = |x: &[f64]| x.len() == n && x.iter().all(|x| x.is_finite());
        finite(&self.scales) && self.centres.iter().all(|centre| finite(centre))
    }
}
