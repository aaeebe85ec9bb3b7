//! Linearised torque: rows [J e] of a block of motion.

use crate::drive_terms::Gravity;
use crate::regions::Regions;
use crate::{DriveTerm, WEIGHT_AT_REST, chain_rows, columns};
use faer::Mat;
use serde::{Deserialize, Serialize};
use torquewise_model::RobotNames;
use torquewise_motion::path::TRAVELS;
use torquewise_motion::{Motion, Signals};
use torquewise_rigid::search::all_parameters;
use torquewise_rigid::{Chain, ChainRows, Geometry, Tangent};
use torquewise_stepwise::{IdentifyError, NoiseFloor};

/// Where the torque of an arm is linearised, and how its rows are weighted: all that a pass over
/// logs needs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Linearisation {
    /// Rotors, friction, springs: columns of their own.
    pub(crate) drive: Vec<DriveTerm>,
    /// How many of these were chosen. The others were offered as well: what the arm does is the mean
    /// of what both say (E21).
    pub(crate) chosen: usize,
    /// What a URDF calls its parts, where one gave the geometry.
    pub(crate) robot: Option<RobotNames>,
    /// Parameters of the geometry that may move, ascending; the others stay, unless all rows
    /// together ask for their release.
    pub(crate) free: Vec<usize>,
    /// Joints slower than this \[rad/s\] are at rest: their friction may be anything; n.
    pub(crate) rest: Vec<f64>,
    /// Where the axes lie, θ₀, and what moves by them.
    pub(crate) geometry: Geometry,
    /// Inertial parameters of the bodies, 10 each, then coefficients of the drive.
    pub(crate) linear: Vec<f64>,
    /// One over the noise of each joint \[1/(N·m)\], n.
    pub(crate) weights: Vec<f64>,
    /// Scale of each parameter, a power of two, so that sums are of one size.
    pub(crate) scales: Vec<f64>,
    /// White noise of the rows that is corrected for.
    pub(crate) noise: NoiseFloor,
    /// Whether noise of the raw samples that went through the filter is corrected for.
    pub(crate) raw_noise: bool,
    /// Rows of a block of time.
    pub(crate) block_rows: usize,
    /// What is held out together in cross-validation: blocks of time of one region (E20).
    pub(crate) regions: Regions,
    /// Seed of the draws of noise.
    pub(crate) seed: u64,
}

/// A column smaller than this part of the largest is counted as if it were of this size.
const LEAST_COLUMN: f64 = 1e-6;

impl Linearisation {
    /// At a chain, its geometry held, with so much beside its links; rows count as they are, without
    /// scales.
    ///
    /// - `drive`: what stands beside the links, and its coefficients
    /// - `rest`: speeds below which joints are at rest \[rad/s\], n
    pub(crate) fn of(
        chain: &Chain,
        (drive, coefficients): (Vec<DriveTerm>, &[f64]),
        rest: Vec<f64>,
    ) -> Self {
        // Of a torque that was not measured nothing is left.
        let per = |rms: &f64| if *rms > 0.0 { 1.0 / rms } else { 0.0 };
        Self {
            chosen: drive.len(),
            drive,
            robot: None,
            free: Vec::new(),
            rest,
            geometry: chain.geometry.clone(),
            linear: chain.inertial.iter().chain(coefficients).copied().collect(),
            weights: chain.residual_rms.iter().map(per).collect(),
            scales: Vec::new(),
            noise: NoiseFloor::none(chain.geometry.n_joints()),
            raw_noise: false,
            block_rows: 1,
            regions: Regions::default(),
            seed: 0,
        }
    }

    /// Number of parameters p: linear ones, then those of the geometry, free or not.
    pub(crate) fn n_parameters(&self) -> usize {
        self.linear.len() + self.geometry.parameters().len()
    }

    pub(crate) fn active(&self) -> Vec<usize> {
        let linear = self.linear.len();
        (0..linear).chain(self.free.iter().map(|&k| linear + k)).collect()
    }

    pub(crate) fn chosen_indices(&self) -> Vec<usize> {
        let offered = self.drive.len() - self.chosen;
        (0..self.linear.len() - offered).collect()
    }

    /// The same without what was not chosen.
    pub(crate) fn narrowed(&self) -> Self {
        let chosen = self.chosen_indices().len();
        let mut narrowed = self.clone();
        narrowed.drive.truncate(self.chosen);
        narrowed.linear.truncate(chosen);
        narrowed.scales.drain(chosen..self.linear.len());
        narrowed
    }

    /// The same with what was offered beside what was chosen.
    pub(crate) fn widened(
        mut self,
        offered: &[DriveTerm],
        sample: &Motion,
    ) -> Result<Self, IdentifyError> {
        for term in offered {
            if !self.drive.contains(term) {
                self.drive.push(term.clone());
                self.linear.push(0.0);
            }
        }
        self.scaled_by(sample)
    }

    /// The same where these parameters may move.
    pub(crate) fn freed(self, active: &[usize]) -> Self {
        let linear = self.linear.len();
        Self { free: active.iter().filter_map(|k| k.checked_sub(linear)).collect(), ..self }
    }

    pub(crate) fn is_sound(&self, n: usize) -> bool {
        let bodies = torquewise_rigid::recursion::PER_BODY * n;
        let geometry = self.geometry.parameters();
        let finite = |x: &[f64]| x.iter().all(|x| x.is_finite());
        let noise = [&self.noise.q, &self.noise.dq, &self.noise.ddq];
        Geometry::new(geometry).is_ok_and(|geometry| geometry.n_joints() == n)
            && self.linear.len() == bodies + self.drive.len()
            && self.drive.iter().all(|term| term.n_joints() == n)
            && self.chosen <= self.drive.len()
            && self.geometry.coupling().is_sound(n)
            && self.geometry.kinds().fit(n)
            && self.free.iter().all(|&k| k < geometry.len())
            && self.rest.len() == n
            && self.weights.len() == n
            && self.scales.len() == self.n_parameters()
            && noise.iter().all(|noise| noise.len() == n && finite(noise))
            && finite(geometry)
            && [&self.linear, &self.weights, &self.scales].iter().all(|x| finite(x))
            && self.block_rows > 0
            && self.regions.is_sound(n)
    }

    /// Travels \[rad\] of the elements by which friction remembers the path.
    pub(crate) fn travels(&self) -> Vec<f64> {
        let mut laws = self.drive.iter().filter_map(DriveTerm::law);
        let remembers = laws.any(|term| term.element().is_some());
        if remembers { TRAVELS.to_vec() } else { Vec::new() }
    }

    pub(crate) fn n_joints(&self) -> usize {
        self.weights.len()
    }

    pub(crate) fn parameters(&self) -> Vec<f64> {
        self.linear.iter().chain(self.geometry.parameters()).copied().collect()
    }

    /// The same at other parameters.
    pub(crate) fn at(&self, parameters: &[f64]) -> Self {
        let (linear, geometry) = parameters.split_at(self.linear.len());
        Self { geometry: self.geometry.at(geometry), linear: linear.to_vec(), ..self.clone() }
    }

    /// The same with parameters counted in such units that the columns of a sample are of size 1:
    /// powers of two, so that nothing is rounded.
    pub(crate) fn scaled_by(self, sample: &Motion) -> Result<Self, IdentifyError> {
        let at = Self { scales: vec![1.0; self.n_parameters()], ..self };
        let (rows, _) = at.rows(sample, sample)?;
        let count = rows.nrows().max(1) as f64;
        let sizes: Vec<f64> = (0..at.n_parameters())
            .map(|j| (rows.col(j).squared_norm_l2() / count).sqrt())
            .collect();
        // A column that is nothing here may be something elsewhere.
        let least = LEAST_COLUMN * sizes.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
        let scale = |rms: &f64| (-rms.max(least).log2().round()).exp2();
        Ok(Self { scales: sizes.iter().map(scale).collect(), ..at })
    }

    pub(crate) fn chain(&self) -> Chain {
        let bodies = torquewise_rigid::recursion::PER_BODY * self.n_joints();
        let (inertial, drive) = self.linear.split_at(bodies);
        Chain {
            geometry: self.geometry.clone(),
            inertial: inertial.to_vec(),
            drive: drive.to_vec(),
            residual_rms: self.weights.iter().map(|weight| 1.0 / weight).collect(),
            cost: 0.0,
        }
    }

    /// Rows \[J e\] of a block in units of the noise and of the scales, (m·n)×(p+1), and what each
    /// was multiplied by, m·n.
    ///
    /// - `seen`: the motion whose speeds say which joints rest; the block itself, or the same
    ///   without added noise
    pub(crate) fn rows(
        &self,
        block: &Motion,
        seen: &Motion,
    ) -> Result<(Mat<f64>, Vec<f64>), IdentifyError> {
        let rows = self.weighed(block, seen)?;
        let Tangent { weights, residual, mut columns } =
            self.chain().tangent(&rows, &self.weights, &all_parameters(self.n_joints()))?;
        for (j, scale) in self.scales.iter().enumerate() {
            columns.col_as_slice_mut(j).iter_mut().for_each(|x| *x *= scale);
        }
        columns.resize_with(residual.len(), columns.ncols() + 1, |k, _| residual[k]);
        Ok((columns, weights))
    }

    /// The rows of a block, those of joints at rest with little weight.
    fn weighed(&self, block: &Motion, seen: &Motion) -> Result<ChainRows, IdentifyError> {
        let is_loaded = self.drive.iter().any(DriveTerm::is_load_dependent);
        let gravity = is_loaded.then(|| Gravity::of(&self.chain(), &self.drive));
        let rows = chain_rows(block, columns(&self.drive, block, gravity.as_ref()))?;
        Ok(rows.with_shares(|row, joint| {
            let moves = seen.dq()[(row, joint)].abs() >= self.rest[joint];
            if moves { 1.0 } else { WEIGHT_AT_REST }
        }))
    }

    /// Columns of the linear parameters and of steps of the geometry that may move, in units of the
    /// noise, (m·n)×p, joint by joint, and what each row was multiplied by, m·n; with `weighs` of an
    /// arm under gravity, else where nothing weighs.
    pub(crate) fn columns_of(
        &self,
        motion: &Motion,
        weighs: bool,
    ) -> Result<(Mat<f64>, Vec<f64>), IdentifyError> {
        let rows = self.weighed(motion, motion)?;
        let rows = if weighs { rows } else { rows.weightless() };
        let tangent = self.chain().tangent(&rows, &self.weights, &self.free)?;
        Ok((tangent.columns, tangent.weights))
    }
}

/// The same motion with q, q̇ and q̈ shifted.
///
/// - `by`: m×3n
pub(crate) fn shifted(motion: &Motion, by: &Mat<f64>, sign: f64) -> Result<Motion, IdentifyError> {
    let (n, mut signals) = (motion.n_joints(), motion.clone().into_signals());
    let Signals { q, dq, ddq, .. } = &mut signals;
    for (k, x) in [q, dq, ddq].into_iter().enumerate() {
        *x += faer::Scale(sign) * by.subcols(k * n, n);
    }
    Ok(Motion::new(signals)?.with_memory(motion.memory().cloned()))
}
