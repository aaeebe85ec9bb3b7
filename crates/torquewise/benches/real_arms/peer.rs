//! From arm, motion to the peer: a rigid-body regressor with the true kinematics, by least squares.

use crate::Errors;
use faer::Mat;
use faer::linalg::solvers::Svd;
use std::error::Error;
use torquewise::dynamics::Arm;
use torquewise::model::FrictionTerm;
use torquewise::model::friction::{Direction, FrictionLaw};
use torquewise::motion::Motion;

/// Weighings of the joints by their residual.
const ROUNDS: usize = 3;
/// Singular values below this part of the largest are zero: base parameters only.
const LEAST_SINGULAR: f64 = 1e-8;
/// Half width of the smooth sign, as a part of the peak speed.
const WIDTH: f64 = 0.01;
/// Rows fitted on at most.
const MOST_ROWS: usize = 4_000;

/// Rigid bodies at known places, rotors, and offset, viscous and dry friction of each joint.
pub(crate) struct Peer<'a> {
    arm: &'a Arm,
    friction: Vec<FrictionTerm>,
    shafts: Vec<Vec<f64>>,
    /// Joints that a spring balances.
    balanced: Vec<usize>,
    coefficients: Vec<f64>,
}

impl<'a> Peer<'a> {
    pub(crate) fn fit(
        arm: &'a Arm,
        shared: &[[usize; 2]],
        balanced: &[&str],
        motion: &Motion,
    ) -> Result<Self, Box<dyn Error + Send + Sync>> {
        let n = motion.n_joints();
        let unit = |joint: usize| (0..n).map(|j| f64::from(u8::from(j == joint))).collect();
        let mut shafts: Vec<Vec<f64>> = (0..n).map(unit).collect();
        for pair in shared {
            shafts.push((0..n).map(|j| f64::from(u8::from(pair.contains(&j)))).collect());
        }
        let peak = |joint: usize| {
            motion.dq().col(joint).iter().fold(0.0_f64, |peak, dq| peak.max(dq.abs()))
        };
        let mut friction = Vec::new();
        for shaft in &shafts {
            let slowest = shaft.iter().enumerate().filter(|(_, s)| **s != 0.0);
            let width = WIDTH * slowest.map(|(joint, _)| peak(joint)).fold(f64::INFINITY, f64::min);
            for law in [FrictionLaw::Offset, FrictionLaw::Viscous, FrictionLaw::Coulomb { width }] {
                let (shaft, direction) = (shaft.clone(), Direction::Both);
                friction.push(FrictionTerm { shaft, law, direction, load: false });
            }
        }
        let place = |name: &&str| motion.joints().iter().position(|joint| joint == name);
        let balanced = balanced.iter().filter_map(place).collect();
        let mut peer = Self { arm, friction, shafts, balanced, coefficients: Vec::new() };
        let rows: Vec<usize> = {
            let count = motion.n_rows().min(MOST_ROWS);
            (0..count).map(|k| k * motion.n_rows() / count).collect()
        };
        peer.solve(&motion.select(&rows))?;
        Ok(peer)
    }

    fn solve(&mut self, motion: &Motion) -> Result<(), Box<dyn Error + Send + Sync>> {
        let (m, n) = (motion.n_rows(), motion.n_joints());
        let (columns, tau) = (self.columns(motion), motion.require_tau()?);
        let mut weights: Vec<f64> =
            (0..n).map(|joint| 1.0 / deviation(motion, joint).max(1e-12)).collect();
        for _ in 0..ROUNDS {
            let mut rows =
                Mat::from_fn(m * n, columns.ncols(), |k, j| weights[k / m] * columns[(k, j)]);
            let scales: Vec<f64> = (0..rows.ncols())
                .map(|j| Some(rows.col(j).norm_l2()).filter(|s| *s > 0.0).unwrap_or(1.0))
                .collect();
            for (j, scale) in scales.iter().enumerate() {
                rows.col_as_slice_mut(j).iter_mut().for_each(|x| *x /= scale);
            }
            let target = Mat::from_fn(m * n, 1, |k, _| weights[k / m] * tau[(k % m, k / m)]);
            let svd = Svd::new_thin(rows.as_ref()).map_err(|_| "the peer cannot be solved")?;
            let across = svd.U().transpose() * &target;
            let singular = svd.S().column_vector();
            let least = LEAST_SINGULAR * singular[0];
            let divided = Mat::from_fn(singular.nrows(), 1, |k, _| {
                if singular[k] > least { across[(k, 0)] / singular[k] } else { 0.0 }
            });
            let found = svd.V() * &divided;
            self.coefficients = scales.iter().enumerate().map(|(j, s)| found[(j, 0)] / s).collect();
            let fitted = self.torque(motion);
            for (joint, weight) in weights.iter_mut().enumerate() {
                let squares: f64 =
                    (0..m).map(|row| (tau[(row, joint)] - fitted[(row, joint)]).powi(2)).sum();
                *weight = 1.0 / (squares / m as f64).sqrt().max(1e-12);
            }
        }
        Ok(())
    }

    /// Columns of all joints, (m·n)×p, all rows of joint 1 first.
    fn columns(&self, motion: &Motion) -> Mat<f64> {
        let (m, n) = (motion.n_rows(), motion.n_joints());
        let bodies = 10 * n;
        let springs = bodies + self.friction.len() + self.shafts.len();
        let width = springs + 4 * self.balanced.len();
        let mut columns = Mat::zeros(m * n, width);
        for row in 0..m {
            let of = |x: faer::MatRef<'_, f64>| -> Vec<f64> {
                (0..n).map(|joint| x[(row, joint)]).collect()
            };
            let (q, dq, ddq) = (of(motion.q()), of(motion.dq()), of(motion.ddq()));
            let regressor = self.arm.regressor(&q, &dq, &ddq);
            for joint in 0..n {
                let k = joint * m + row;
                for j in 0..bodies {
                    columns[(k, j)] = regressor[(joint, j)];
                }
                for (j, term) in self.friction.iter().enumerate() {
                    columns[(k, bodies + j)] = term.torque(joint, &dq);
                }
                for (j, shaft) in self.shafts.iter().enumerate() {
                    let turning: f64 = shaft.iter().zip(&ddq).map(|(s, a)| s * a).sum();
                    columns[(k, bodies + self.friction.len() + j)] = shaft[joint] * turning;
                }
                if let Some(place) = self.balanced.iter().position(|own| *own == joint) {
                    let spring = [q[joint].sin_cos(), (2.0 * q[joint]).sin_cos()];
                    for (j, value) in spring.iter().flat_map(|(sin, cos)| [sin, cos]).enumerate() {
                        columns[(k, springs + 4 * place + j)] = *value;
                    }
                }
            }
        }
        columns
    }

    fn torque(&self, motion: &Motion) -> Mat<f64> {
        let (m, n) = (motion.n_rows(), motion.n_joints());
        let weights = Mat::from_fn(self.coefficients.len(), 1, |j, _| self.coefficients[j]);
        let torque = self.columns(motion) * weights;
        Mat::from_fn(m, n, |row, joint| torque[(joint * m + row, 0)])
    }

    pub(crate) fn errors(&self, motion: &Motion) -> Result<Errors, Box<dyn Error + Send + Sync>> {
        let (tau, fitted) = (motion.require_tau()?, self.torque(motion));
        let m = motion.n_rows();
        let rmse: Vec<f64> = (0..motion.n_joints())
            .map(|joint| {
                let squares = (0..m).map(|row| (tau[(row, joint)] - fitted[(row, joint)]).powi(2));
                (squares.sum::<f64>() / m as f64).sqrt()
            })
            .collect();
        let nrmse =
            rmse.iter().enumerate().map(|(joint, rmse)| rmse / deviation(motion, joint)).collect();
        Ok(Errors { rmse, nrmse })
    }
}

fn deviation(motion: &Motion, joint: usize) -> f64 {
    let Some(tau) = motion.tau() else { return 0.0 };
    let m = motion.n_rows() as f64;
    let mean = tau.col(joint).iter().sum::<f64>() / m;
    (tau.col(joint).iter().map(|tau| (tau - mean).powi(2)).sum::<f64>() / m).sqrt()
}
