//! Inertial parameters of a given geometry, by least squares, and the residual.

use crate::error::ChainError;
use crate::geometry::Geometry;
use crate::recursion::{Moved, PER_BODY};
use crate::rows::{Rows, put};
use faer::linalg::solvers::{Llt, Solve};
use faer::{Mat, MatRef, Side};
use torquewise_regression::products::{add_gram_of_equations, product};

/// The linear half of the fit: parameters that the torque is proportional to, at a fixed geometry.
#[derive(Clone, Debug)]
pub(crate) struct InertialFit {
    /// Weighted columns, (m·n)×p.
    columns: Mat<f64>,
    /// One over the RMS of each column, zero for one that is nothing, p.
    per_rms: Vec<f64>,
    /// Of the normal equations of columns of unit RMS.
    factor: Llt<f64>,
    /// Coefficients in the units of the torque's columns, p.
    pub(crate) coefficients: Vec<f64>,
    /// Weighted residual, m·n.
    pub(crate) residual: Vec<f64>,
    /// Mean square of the weighted residual, the ridge counted in.
    pub(crate) cost: f64,
}

/// Columns below this fraction of the largest RMS are ignored.
const NOTHING: f64 = 1e-9;

/// Weighted columns of a chain and those beside it, (m·n)×p.
pub(crate) fn weighted_columns(geometry: &Geometry, rows: &Rows, weights: &[f64]) -> Mat<f64> {
    let (m, n) = (rows.len(), rows.n_joints());
    let kinematics = rows.kinematics(geometry);
    let mut moved = Moved::default();
    let of_bodies = PER_BODY * n;
    let mut columns = Mat::zeros(m * n, of_bodies + rows.extras.ncols());
    rows.visit_lanes(|state, first, count| {
        kinematics.move_into(state, &mut moved);
        moved.regressor(|joint, parameter, value| {
            put(columns.col_as_slice_mut(parameter), (joint * m + first, count), value);
        });
    });
    for parameter in 0..of_bodies {
        // A body does not load the joints beyond it.
        let weights = &weights[..=parameter / PER_BODY];
        weigh(columns.col_as_slice_mut(parameter), rows, weights);
    }
    for (j, joints) in rows.loaded.iter().enumerate() {
        let (from, column) = (rows.extras.col_as_slice(j), columns.col_as_slice_mut(of_bodies + j));
        for &joint in joints {
            let own = joint * m..(joint + 1) * m;
            column[own.clone()].copy_from_slice(&from[own.clone()]);
            weigh_joint(&mut column[own.clone()], &rows.shares[own], weights[joint]);
        }
    }
    columns
}

/// Multiplies equations, all rows of joint 1 first, by what they count.
pub(crate) fn weigh(column: &mut [f64], rows: &Rows, weights: &[f64]) {
    let m = rows.len().max(1);
    let joints = column.chunks_mut(m).zip(rows.shares.chunks(m)).zip(weights);
    joints.for_each(|((column, shares), weight)| weigh_joint(column, shares, *weight));
}

fn weigh_joint(column: &mut [f64], shares: &[f64], weight: f64) {
    column.iter_mut().zip(shares).for_each(|(x, share)| *x *= share * weight);
}

fn scale_rows(x: &mut Mat<f64>, scales: &[f64]) {
    for column in 0..x.ncols() {
        let own = x.col_as_slice_mut(column).iter_mut().zip(scales);
        own.for_each(|(x, scale)| *x *= scale);
    }
}

impl InertialFit {
    /// Ridge regression of the torque at a geometry.
    ///
    /// `ridge` is relative to the mean square of a column; `weights` is one over the noise of each
    /// joint, n.
    pub(crate) fn fit(
        geometry: &Geometry,
        rows: &Rows,
        weights: &[f64],
        ridge: f64,
    ) -> Result<Self, ChainError> {
        let (m, n) = (rows.len(), rows.n_joints());
        let size = rows.torque.len() as f64;
        let columns = weighted_columns(geometry, rows, weights);
        let p = columns.ncols();
        let weighted = |(k, tau): (usize, &f64)| rows.shares[k] * weights[k / m] * tau;
        let target: Vec<f64> = rows.torque.iter().enumerate().map(weighted).collect();
        let mut gram = Mat::zeros(p, p);
        add_gram_of_equations(&mut gram, columns.as_ref(), n, 1.0);
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
        let mut right =
            product(columns.transpose(), MatRef::from_column_major_slice(&target, m * n, 1));
        scale_rows(&mut right, &per_rms);
        let scaled = factor.solve(&right);
        let mut coefficients = scaled.clone();
        scale_rows(&mut coefficients, &per_rms);
        let fitted = product(columns.as_ref(), coefficients.as_ref());
        let pairs = target.iter().zip(fitted.col_as_slice(0));
        let residual: Vec<f64> = pairs.map(|(t, f)| t - f).collect();
        let squares: f64 = residual.iter().map(|r| r * r).sum();
        let scaled = scaled.col_as_slice(0);
        let penalty: f64 = ridge * scaled.iter().map(|c| c * c).sum::<f64>();
        let coefficients = coefficients.col_as_slice(0).to_vec();
        let cost = squares / size + penalty;
        if !cost.is_finite() {
            return Err(ChainError::Singular);
        }
        Ok(Self { columns, per_rms, factor, coefficients, residual, cost })
    }

    /// What a change of the weighted torque at fixed coefficients leaves of itself once the
    /// coefficients follow: DᵀD − (YᵀD)ᵀ(YᵀY + λ)⁻¹(YᵀD), g×g, for the changes D, (m·n)×g.
    pub(crate) fn projected(&self, changes: &Mat<f64>) -> Mat<f64> {
        let mut across = product(self.columns.transpose(), changes.as_ref());
        scale_rows(&mut across, &self.per_rms);
        let followed = self.factor.solve(&across);
        product(changes.transpose(), changes.as_ref())
            - product(across.transpose(), followed.as_ref())
    }

    /// Mean square residual of each joint \[(N·m)²\], weights taken out.
    pub(crate) fn variances(&self, rows: &Rows, weights: &[f64]) -> Vec<f64> {
        let m = rows.len();
        let parts = self.residual.chunks(m).zip(rows.shares.chunks(m)).zip(weights);
        let of = |((part, shares), weight): ((&[f64], &[f64]), &f64)| {
            let counted: f64 = shares.iter().map(|s| s * s).sum();
            part.iter().map(|r| r * r).sum::<f64>() / (counted.max(1.0) * weight * weight)
        };
        parts.map(of).collect()
    }
}
