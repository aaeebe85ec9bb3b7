//! Kept terms: their normal equations near a fit, and what noise does to these (E6) (E7).

use crate::rows::fill_in;
use crate::{Candidates, NoiseFloor};
use faer::Mat;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use torquewise_model::FrictionTerm;
use torquewise_regression::{Alike, BlockSums, Design, NormalSums, Samples, SparseError};

/// Terms to be fitted together.
pub(crate) struct ActiveSet<'a> {
    /// Joints whose torque they explain.
    pub(crate) joints: Vec<usize>,
    /// Columns of the library, ascending.
    pub(crate) columns: Vec<usize>,
    /// Weight of the rows of each joint: one over its noise variance, in a unit of its own, which
    /// changes no fit.
    pub(crate) weights: Vec<f64>,
    design: Design,
    /// Laws of friction whose values are among the variables.
    friction: &'a [FrictionTerm],
}

/// The largest weight of a row, a power of two squared: rows are then well within what exact sums
/// hold, and so is what they leave where torque is explained but for rounding.
const LARGEST: f64 = 4_294_967_296.0;

impl<'a> ActiveSet<'a> {
    pub(crate) fn new(
        candidates: &'a Candidates,
        joints: Vec<usize>,
        columns: Vec<usize>,
        weights: &[f64],
    ) -> Self {
        let most = weights.iter().fold(f64::MIN_POSITIVE, |most, weight| most.max(*weight));
        let weights = weights.iter().map(|weight| weight / most * LARGEST).collect();
        let design = candidates.design.subset(&columns);
        Self { joints, columns, weights, design, friction: &candidates.friction }
    }

    /// Rows √w·\[Y τ − Yβ\] of all joints, all instants of one after those of the one before.
    fn rows(&self, samples: &Samples, coefficients: &[f64]) -> Result<Mat<f64>, SparseError> {
        let columns = self.design.columns(samples)?;
        let (m, p) = (samples.n_rows(), self.columns.len());
        let joints = self.joints.iter().zip(&self.weights);
        let mut rows = Mat::zeros(m * self.weights.len(), p + 1);
        for (place, (&joint, &weight)) in joints.enumerate() {
            let (root, y) = (weight.sqrt(), &columns[if columns.len() == 1 { 0 } else { joint }]);
            let tau = samples.responses.col_as_slice(joint);
            for row in 0..m {
                let explained: f64 = (0..p).map(|j| coefficients[j] * y[(row, j)]).sum();
                let k = place * m + row;
                (0..p).for_each(|j| rows[(k, j)] = root * y[(row, j)]);
                rows[(k, p)] = root * (tau[row] - explained);
            }
        }
        Ok(rows)
    }

    /// What pieces of the sample say near a first fit, noise and its own spread included.
    ///
    /// - `coefficients`: where it is linearised
    /// - `draws`: times that the noise is drawn for each row
    /// - `random`: seed and stream of the noise
    pub(crate) fn normal_sums<'s>(
        &self,
        coefficients: &[f64],
        (noise, draws): (&NoiseFloor, usize),
        (seed, stream): (u64, u64),
        pieces: impl Iterator<Item = &'s Samples>,
    ) -> Result<NormalSums, SparseError> {
        let weights = &self.weights;
        let mut sums = NormalSums::new(self.columns.len(), weights.len(), 1);
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        random.set_stream(stream);
        let draws = if noise.is_none() { 0 } else { draws };
        for samples in pieces {
            let m = samples.n_rows();
            let roots = weights.iter().map(|weight| weight.sqrt());
            let roots: Vec<f64> = roots.flat_map(|root| std::iter::repeat_n(root, m)).collect();
            let rows = self.rows(samples, coefficients)?;
            let equations = (weights.len(), Alike::Instant);
            let mut block = BlockSums::new(0, rows.as_ref(), &roots, equations);
            // Noise drawn once more shows what noise did (E7).
            for _ in 0..draws {
                let drawn = noise.draw(&mut random, m);
                let (angles, rates) = drawn.split_at_col(noise.q.len());
                for sign in [1.0, -1.0] {
                    let mut shifted = samples.clone();
                    shifted.angles += faer::Scale(sign) * angles;
                    let mut moved = shifted.variables.subcols_mut(0, rates.ncols());
                    moved += faer::Scale(sign) * rates;
                    fill_in(&mut shifted, self.friction);
                    let noisy = self.rows(&shifted, coefficients)?;
                    block.add_noisy(noisy.as_ref(), 0.5 / draws as f64);
                }
            }
            sums.add(&block)?;
        }
        Ok(sums)
    }
}
