//! Raw signals of one trajectory, shapes checked.

use crate::error::{MotionError, Result};
use crate::signals::spline::check_increasing;
use faer::Mat;

pub(crate) const NAMES: [&str; 4] = ["q", "dq", "ddq", "tau"];
/// Place of each signal in [`NAMES`].
pub(crate) const Q: usize = 0;
pub(crate) const DQ: usize = 1;
pub(crate) const TAU: usize = 3;

/// What was measured of one trajectory of an arm with n joints, m rows.
#[derive(Clone, Debug)]
pub struct Raw {
    /// Names of the n joints, base to tip.
    pub joints: Vec<String>,
    /// Time stamps \[s\], m, strictly increasing.
    pub t: Vec<f64>,
    /// Joint positions \[rad\], m×n.
    pub q: Mat<f64>,
    /// Joint velocities \[rad/s\], m×n.
    pub dq: Option<Mat<f64>>,
    /// Joint accelerations \[rad/s²\], m×n.
    pub ddq: Option<Mat<f64>>,
    /// Joint torques \[N·m\], m×n.
    pub tau: Option<Mat<f64>>,
}

/// The same signals as columns that can grow and shrink.
#[derive(Clone, Debug, Default)]
pub(crate) struct Columns {
    pub(crate) joints: Vec<String>,
    pub(crate) t: Vec<f64>,
    /// q, dq, ddq, tau; each n columns of m values.
    pub(crate) signals: [Option<Vec<Vec<f64>>>; 4],
}

impl Raw {
    /// Checks shapes, finiteness and time order, and takes the columns apart.
    pub(crate) fn columns(&self) -> Result<Columns> {
        let (rows, n) = (self.t.len(), self.joints.len());
        if n == 0 {
            return Err(MotionError::NoJoints);
        }
        check_increasing(&self.t).map_err(|e| match e {
            order @ MotionError::TimeOrder { .. } => order,
            other => other.of("t", "every joint"),
        })?;
        let all = [Some(&self.q), self.dq.as_ref(), self.ddq.as_ref(), self.tau.as_ref()];
        let mut signals = [const { None }; 4];
        for ((signal, values), columns) in NAMES.into_iter().zip(all).zip(&mut signals) {
            let Some(values) = values else { continue };
            MotionError::check_shape(signal, values.as_ref(), [rows, n])?;
            for (joint, name) in self.joints.iter().enumerate() {
                let column = values.col_as_slice(joint);
                if let Some(row) = column.iter().position(|x| !x.is_finite()) {
                    return Err(MotionError::NotFiniteAt { row }.of(signal, name));
                }
            }
            *columns = Some((0..n).map(|joint| values.col_as_slice(joint).to_vec()).collect());
        }
        Ok(Columns { joints: self.joints.clone(), t: self.t.clone(), signals })
    }
}

impl Columns {
    pub(crate) fn present(&self) -> impl Iterator<Item = (usize, &Vec<Vec<f64>>)> {
        let signals = self.signals.iter().enumerate();
        signals.filter_map(|(place, columns)| columns.as_ref().map(|columns| (place, columns)))
    }

    pub(crate) fn head(&self, rows: usize) -> Self {
        let rows = rows.min(self.t.len());
        let cut = |columns: &Vec<Vec<f64>>| columns.iter().map(|x| x[..rows].to_vec()).collect();
        let signals = self.signals.each_ref().map(|columns| columns.as_ref().map(cut));
        Self { joints: self.joints.clone(), t: self.t[..rows].to_vec(), signals }
    }

    pub(crate) fn forget(&mut self, rows: usize) {
        let rows = rows.min(self.t.len());
        self.t.drain(..rows);
        for column in self.signals.iter_mut().flatten().flatten() {
            column.drain(..rows);
        }
    }

    /// Every column through `work`, which is told the place of the signal and the joint.
    pub(crate) fn map(
        &self,
        t: Vec<f64>,
        mut work: impl FnMut(usize, usize, &[f64]) -> Result<Vec<f64>>,
    ) -> Result<Self> {
        let mut signals = [const { None }; 4];
        for (place, columns) in self.present() {
            let mut mapped = Vec::with_capacity(columns.len());
            for (joint, column) in columns.iter().enumerate() {
                let done = work(place, joint, column);
                mapped.push(done.map_err(|e| e.of(NAMES[place], &self.joints[joint]))?);
            }
            signals[place] = Some(mapped);
        }
        Ok(Self { joints: self.joints.clone(), t, signals })
    }
}

pub(crate) fn matrix(columns: &[Vec<f64>]) -> Mat<f64> {
    let rows = columns.first().map_or(0, Vec::len);
    Mat::from_fn(rows, columns.len(), |row, joint| columns[joint][row])
}
