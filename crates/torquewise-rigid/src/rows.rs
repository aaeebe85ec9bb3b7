//! Rows of the regression that a chain is learned from: motion, torque, drive columns.

use crate::inertial_fit::{JointColumns, columns_at};
use crate::recursion::{Lanes, MOST_JOINTS, N_LANES};
use crate::{ChainError, Geometry, Kinematics, Result, expect};
use faer::{Mat, MatRef};
use std::sync::Arc;
use torquewise_regression::products::picked;

/// A spread of torque about its mean \[N·m\]; zero where it is rounding, as where torque never changes.
pub fn spread_above_rounding(std: f64, mean: f64) -> f64 {
    /// Below this part of the mean.
    const ROUNDING: f64 = 1e-6;
    if std > ROUNDING * mean.abs() { std } else { 0.0 }
}

/// Rows of one arm and what is known beside the chain.
#[derive(Clone, Debug)]
pub struct ChainRows {
    /// q, q̇, q̈, m×n each.
    states: [Mat<f64>; 3],
    /// Torques, m·n: all rows of joint 1 first.
    pub(crate) torque: Vec<f64>,
    /// Further columns, (m·n)×e, rows as in `torque`.
    pub(crate) extras: Mat<f64>,
    /// Joints that each of them may load; its other equations are zero.
    pub(crate) loaded: Vec<Vec<usize>>,
    /// Factor on each equation, m·n, 0 to 1: small where a joint rests, whose friction may be anything.
    pub(crate) shares: Vec<f64>,
    /// Whether gravity was taken out of the torque.
    weightless: bool,
    /// Their columns at one geometry, where these were worked out.
    pub(crate) known: Option<(Geometry, Arc<Vec<JointColumns>>)>,
}

impl ChainRows {
    /// Collects rows.
    ///
    /// - `q`, `dq`, `ddq`, `tau`: m×n; rad, rad/s, rad/s², N·m
    /// - `extras`: columns that explain torque beside the chain (friction, offsets), (m·n)×e: all rows
    ///   of joint 1 first
    ///
    /// # Errors
    /// [`ChainError::Shape`] if shapes differ, [`ChainError::TooManyJoints`] also if there is none.
    pub fn new([q, dq, ddq, tau]: [MatRef<'_, f64>; 4], extras: Mat<f64>) -> Result<Self> {
        let (m, n) = (q.nrows(), q.ncols());
        if n > MOST_JOINTS || n == 0 {
            return Err(ChainError::TooManyJoints { joints: n, most: MOST_JOINTS });
        }
        for (what, x) in [("dq", dq), ("ddq", ddq), ("tau", tau)] {
            if x.shape() != (m, n) {
                let (found, expected) = (x.nrows() * x.ncols(), m * n);
                return Err(ChainError::Shape { what, found, expected });
            }
        }
        expect("a column of extras", extras.nrows(), m * n)?;
        let states = [q, dq, ddq].map(|x| x.to_owned());
        let torque = (0..n).flat_map(|joint| (0..m).map(move |row| tau[(row, joint)])).collect();
        let is_loaded = |column: usize, joint: usize| {
            extras.col_as_slice(column)[joint * m..(joint + 1) * m].iter().any(|x| *x != 0.0)
        };
        let loaded = (0..extras.ncols())
            .map(|column| (0..n).filter(|&joint| is_loaded(column, joint)).collect())
            .collect();
        let shares = vec![1.0; m * n];
        let (weightless, known) = (false, None);
        Ok(Self { states, torque, extras, loaded, shares, weightless, known })
    }

    /// Number of joints n.
    pub fn n_joints(&self) -> usize {
        self.states[0].ncols()
    }

    /// Number of rows m.
    pub fn len(&self) -> usize {
        self.states[0].nrows()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The torques \[N·m\] of a joint, counted from 0, m.
    ///
    /// # Panics
    /// If there is no such joint.
    pub fn torque_of(&self, joint: usize) -> &[f64] {
        &self.torque[joint * self.len()..(joint + 1) * self.len()]
    }

    /// The same rows, the equation of each joint multiplied by `share(row, joint)`, 0 to 1.
    pub fn with_shares(mut self, share: impl Fn(usize, usize) -> f64) -> Self {
        let m = self.len();
        for (k, out) in self.shares.iter_mut().enumerate() {
            *out *= share(k % m, k / m).clamp(0.0, 1.0);
        }
        self
    }

    /// The same rows, of which those of a joint whose torque never changes, as where none was measured,
    /// count nothing.
    pub fn measured(self) -> Self {
        let changes: Vec<bool> =
            (0..self.n_joints()).map(|joint| self.deviation_of(joint) > 0.0).collect();
        self.with_shares(|_, joint| f64::from(u8::from(changes[joint])))
    }

    /// What each equation counts: its share over the noise of its joint, m·n.
    ///
    /// - `weights`: one over the noise of each joint \[1/(N·m)\], n
    pub(crate) fn counted(&self, weights: &[f64]) -> Vec<f64> {
        let m = self.len();
        self.shares.iter().enumerate().map(|(k, share)| share * weights[k / m]).collect()
    }

    /// Standard deviation of the torque of a joint \[N·m\], zero where it never changes.
    pub fn deviation_of(&self, joint: usize) -> f64 {
        let torque = self.torque_of(joint);
        let m = torque.len().max(1) as f64;
        let mean = torque.iter().sum::<f64>() / m;
        let squares = torque.iter().map(|tau| (tau - mean).powi(2)).sum::<f64>();
        spread_above_rounding((squares / m).sqrt(), mean)
    }

    /// q, q̇, q̈, m×n each.
    pub(crate) fn signals(&self) -> [Option<MatRef<'_, f64>>; 3] {
        self.states.each_ref().map(|x| Some(x.as_ref()))
    }

    /// The same rows, with the torque of a joint, counted from 0, negated.
    #[must_use]
    pub fn turned(mut self, joint: usize) -> Self {
        let m = self.len();
        self.torque.iter_mut().skip(joint * m).take(m).for_each(|tau| *tau = -*tau);
        self
    }

    /// The same rows, to be explained where nothing weighs.
    #[must_use]
    pub fn weightless(self) -> Self {
        Self { weightless: true, known: None, ..self }
    }

    /// The same rows, quick to be fitted to torques of other signs or in another order at one geometry.
    #[must_use]
    pub fn placed(self, geometry: &Geometry) -> Self {
        let known = Some((geometry.clone(), Arc::new(columns_at(geometry, &self))));
        Self { known, ..self }
    }

    /// The moving bodies of a geometry, under gravity if these rows are.
    pub(crate) fn kinematics(&self, geometry: &Geometry) -> Kinematics {
        let kinematics = Kinematics::new(geometry);
        if self.weightless { kinematics.without_gravity() } else { kinematics }
    }

    /// The same rows, with the torques of two joints, counted from 0, in each other's place.
    #[must_use]
    pub fn swapped(mut self, [a, b]: [usize; 2]) -> Self {
        let m = self.len();
        (0..m).for_each(|row| self.torque.swap(a * m + row, b * m + row));
        self
    }

    /// The rows named by `rows`, in that order.
    ///
    /// # Panics
    /// If there is no such row.
    pub fn select(&self, rows: &[usize]) -> Self {
        let (m, n) = (self.len(), self.n_joints());
        let place = |k: usize| (k / rows.len()) * m + rows[k % rows.len()];
        let places: Vec<usize> = (0..rows.len() * n).map(place).collect();
        Self {
            states: self.states.each_ref().map(|x| picked(x, rows, 0..n)),
            torque: places.iter().map(|&place| self.torque[place]).collect(),
            extras: picked(&self.extras, &places, 0..self.extras.ncols()),
            loaded: self.loaded.clone(),
            shares: places.iter().map(|&place| self.shares[place]).collect(),
            known: None,
            ..*self
        }
    }

    /// At most `count` rows, evenly spread.
    pub fn thinned(&self, count: usize) -> Self {
        self.select(&evenly(self.len(), count))
    }
}

/// Places of at most `count` of m rows, evenly spread.
pub fn evenly(m: usize, count: usize) -> Vec<usize> {
    let count = m.min(count);
    (0..count).map(|k| k * m / count).collect()
}

/// Puts the values of so many lanes into the rows of a joint from `first` on.
pub(crate) fn put(rows: &mut [f64], (first, count): (usize, usize), value: Lanes) {
    let values: [f64; N_LANES] = value.into();
    match rows[first..first + count].first_chunk_mut() {
        Some(whole) => *whole = values,
        None => put_few(&mut rows[first..first + count], &values),
    }
}

/// Apart, so that the usual copy, whose length is known, is no call.
#[cold]
#[inline(never)]
fn put_few(rows: &mut [f64], values: &[f64]) {
    rows.iter_mut().zip(values).for_each(|(row, value)| *row = *value);
}
