//! Inertial parameters of a given geometry, by least squares, and the residual.

use crate::recursion::each_four;
use crate::rows::put;
use crate::{ChainError, ChainRows, Geometry, Moved, PER_BODY, Result};
use faer::linalg::solvers::{Llt, Solve};
use faer::{ColRef, Mat, MatRef, Side};
use torquewise_regression::products::{add_gram_at, product};

/// The linear half of the fit: parameters that the torque is proportional to, at a fixed geometry.
#[derive(Clone, Debug)]
pub(crate) struct InertialFit {
    pub(crate) geometry: Geometry,
    /// Of each joint, n.
    columns: Vec<JointColumns>,
    /// One over the RMS of each column, zero for one that is nothing, p.
    per_rms: Vec<f64>,
    /// Of the normal equations of columns of unit RMS.
    factor: Llt<f64>,
    /// Coefficients in the units of the torque's columns, p.
    pub(crate) coefficients: Vec<f64>,
    /// Weighted residual, m·n.
    pub(crate) residual: Vec<f64>,
    /// Mean square of the weighted residual, ridge and prior of the geometry counted in.
    pub(crate) cost: f64,
}

/// Columns that load a joint: of the bodies from it outward, and of what stands beside the
/// chain.
#[derive(Clone, Debug)]
pub(crate) struct JointColumns {
    /// Which of all p columns they are, ascending.
    pub(crate) places: Vec<usize>,
    /// One row each instant, m×(number of places).
    pub(crate) columns: Mat<f64>,
}

/// Columns below this fraction of the largest RMS are ignored.
const NOTHING: f64 = 1e-9;

/// Weighted columns of a chain and those beside it, n.
///
/// - `counted`: what each equation counts, [`ChainRows::counted`]
pub(crate) fn weighted_columns(
    geometry: &Geometry,
    rows: &ChainRows,
    counted: &[f64],
) -> Vec<JointColumns> {
    let mut all = columns_at(geometry, rows);
    for (own, counted) in all.iter_mut().zip(counted.chunks(rows.len().max(1))) {
        scale_rows(&mut own.columns, counted);
    }
    all
}

/// The same before they are weighed.
pub(crate) fn columns_at(geometry: &Geometry, rows: &ChainRows) -> Vec<JointColumns> {
    if let Some((known, columns)) = &rows.known
        && known == geometry
    {
        return columns.to_vec();
    }
    let (m, n) = (rows.len(), rows.n_joints());
    let kinematics = rows.kinematics(geometry);
    let mut moved = Moved::default();
    let of_bodies = PER_BODY * n;
    let loading = |joint: usize| {
        let loads = |k: &usize| rows.loaded[*k].contains(&joint);
        let beside = (0..rows.loaded.len()).filter(loads).map(|k| of_bodies + k);
        let places: Vec<usize> = (PER_BODY * joint..of_bodies).chain(beside).collect();
        let mut columns = Mat::zeros(m, places.len());
        for (column, &place) in places.iter().enumerate() {
            if let Some(beside) = place.checked_sub(of_bodies) {
                columns.col_mut(column).copy_from(rows.extras.col(beside).subrows(joint * m, m));
            }
        }
        JointColumns { places, columns }
    };
    let mut all: Vec<JointColumns> = (0..n).map(loading).collect();
    each_four(n, rows.signals(), |state, first, count| {
        kinematics.move_into(state, &mut moved);
        moved.regressor(|joint, parameter, value| {
            let column = all[joint].columns.col_as_slice_mut(parameter - PER_BODY * joint);
            put(column, (first, count), value);
        });
    });
    all
}

/// Multiplies each row by a number.
pub(crate) fn scale_rows(x: &mut Mat<f64>, scales: &[f64]) {
    for column in 0..x.ncols() {
        let own = x.col_as_slice_mut(column).iter_mut().zip(scales);
        own.for_each(|(x, scale)| *x *= scale);
    }
}

impl JointColumns {
    /// Adds YᵀX to sums of p rows.
    fn add_across(&self, x: MatRef<'_, f64>, sums: &mut Mat<f64>) {
        let own = product(self.columns.transpose(), x);
        for j in 0..own.ncols() {
            self.places.iter().enumerate().for_each(|(i, &row)| sums[(row, j)] += own[(i, j)]);
        }
    }

    /// Subtracts the torque of all p coefficients.
    pub(crate) fn subtract(&self, coefficients: &[f64], from: &mut [f64]) {
        let own: Vec<f64> = self.places.iter().map(|&k| coefficients[k]).collect();
        let torque = &self.columns * ColRef::from_slice(&own);
        from.iter_mut().zip(torque.iter()).for_each(|(from, torque)| *from -= torque);
    }
}

impl InertialFit {
    /// Ridge regression of the torque at a geometry.
    ///
    /// `ridge` is relative to the mean square of a column; `weights` is one over the noise of each
    /// joint, n. The cost may not be finite, and counts no prior yet.
    pub(crate) fn fit(
        geometry: &Geometry,
        rows: &ChainRows,
        weights: &[f64],
        ridge: f64,
    ) -> Result<Self> {
        let (m, n) = (rows.len(), rows.n_joints());
        let size = rows.torque.len() as f64;
        let counted = rows.counted(weights);
        let columns = weighted_columns(geometry, rows, &counted);
        let p = PER_BODY * n + rows.extras.ncols();
        let mut residual: Vec<f64> = counted.iter().zip(&rows.torque).map(|(w, t)| w * t).collect();
        let (mut gram, mut right) = (Mat::zeros(p, p), Mat::zeros(p, 1));
        for (own, target) in columns.iter().zip(residual.chunks(m.max(1))) {
            add_gram_at(&mut gram, &own.places, own.columns.as_ref(), 1.0);
            own.add_across(MatRef::from_column_major_slice(target, m, 1), &mut right);
        }
        let rms: Vec<f64> = (0..p).map(|j| (gram[(j, j)] / size).sqrt()).collect();
        let least = NOTHING * rms.iter().fold(0.0_f64, |most, &s| most.max(s));
        let per = |rms: f64| if rms > least { 1.0 / rms } else { 0.0 };
        let per_rms: Vec<f64> = rms.into_iter().map(per).collect();
        for j in 0..p {
            let column = gram.col_as_slice_mut(j).iter_mut().zip(&per_rms);
            column.for_each(|(x, own)| *x *= own * per_rms[j]);
            gram[(j, j)] += ridge * size;
        }
        let factor = gram.llt(Side::Lower).map_err(|_| ChainError::Singular)?;
        scale_rows(&mut right, &per_rms);
        let scaled = factor.solve(&right);
        let mut coefficients = scaled.clone();
        scale_rows(&mut coefficients, &per_rms);
        let coefficients = coefficients.col_as_slice(0).to_vec();
        for (own, residual) in columns.iter().zip(residual.chunks_mut(m.max(1))) {
            own.subtract(&coefficients, residual);
        }
        let squares: f64 = residual.iter().map(|r| r * r).sum();
        let scaled = scaled.col_as_slice(0);
        let penalty: f64 = ridge * scaled.iter().map(|c| c * c).sum::<f64>();
        let (geometry, cost) = (geometry.clone(), squares / size + penalty);
        Ok(Self { geometry, columns, per_rms, factor, coefficients, residual, cost })
    }

    /// What a change of the weighted torque at fixed coefficients leaves of itself once the
    /// coefficients follow: DᵀD − (YᵀD)ᵀ(YᵀY + λ)⁻¹(YᵀD), g×g, for the changes D, (m·n)×g.
    pub(crate) fn projected(&self, changes: &Mat<f64>) -> Mat<f64> {
        let m = changes.nrows() / self.columns.len();
        let mut across = Mat::zeros(self.coefficients.len(), changes.ncols());
        for (joint, own) in self.columns.iter().enumerate() {
            own.add_across(changes.subrows(joint * m, m), &mut across);
        }
        scale_rows(&mut across, &self.per_rms);
        let followed = self.factor.solve(&across);
        product(changes.transpose(), changes.as_ref())
            - product(across.transpose(), followed.as_ref())
    }

    /// Mean square residual of each joint \[(N·m)²\], rows weighted by their squared shares.
    pub(crate) fn variances(&self, rows: &ChainRows, weights: &[f64]) -> Vec<f64> {
        let m = rows.len();
        let parts = self.residual.chunks(m).zip(rows.shares.chunks(m)).zip(weights);
        let of = |((part, shares), weight): ((&[f64], &[f64]), &f64)| {
            let counted: f64 = shares.iter().map(|s| s * s).sum();
            part.iter().map(|r| r * r).sum::<f64>() / (counted.max(1.0) * weight * weight)
        };
        parts.map(of).collect()
    }
}
