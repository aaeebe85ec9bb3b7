//! From a load of known mass to what a unit of each torque column is worth (E25).

use super::{Pass, STRENGTH, chain_of};
use crate::clustered::scatter;
use faer::{ColRef, Mat};
use serde::Serialize;
use torquewise_model::Model;
use torquewise_model::shaft_friction::Estimated;
use torquewise_motion::Recording;
use torquewise_rigid::feasible::{Prior, Quadratic, curvature, minimise};
use torquewise_rigid::recursion::PER_BODY;
use torquewise_stepwise::error::IdentifyError;

/// Torque for a unit of each torque column, such as N·m/A where it is a current.
#[derive(Clone, Debug, Serialize)]
pub struct Gains {
    /// K of each joint, n.
    pub gains: Vec<Estimated>,
    /// The mass that they rest on \[kg\].
    pub known_mass: f64,
    /// The mass that the torque columns would say \[kg\], if they were in N·m.
    pub apparent_mass: f64,
    /// Rows that they were found on.
    pub rows: usize,
}

/// A gain is told where its standard error is below this part of it.
const TOLD: f64 = 0.1;
/// How much more than by all rows a known mass is held.
const HELD: f64 = 1e6;
/// Load and gains are found in turn, so often at most, until no gain changes by this part.
const ROUNDS: (usize, f64) = (500, 1e-9);

impl Gains {
    /// Finds gains Kⱼ of drives, and the load as far as it is not known, by what a model of the bare
    /// arm, learned from the same columns, leaves of them: iⱼ − îⱼ = Yⱼ π / Kⱼ, with π₀ the known
    /// mass \[E25\]. Errors count the scatter over blocks of time and what is uncertain of the arm.
    ///
    /// - `mass`: of the load \[kg\]
    /// - `recording`: rows of the arm with the load, filtered as those of the model were
    ///
    /// # Errors
    /// Those of [`super::Payload::find`].
    pub fn find(
        model: &Model,
        recording: &(impl Recording + ?Sized),
        mass: f64,
    ) -> Result<Self, IdentifyError> {
        let chain = chain_of(model)?;
        model.check_joints(recording.joints())?;
        let pass = Pass::over(model, chain, recording)?;
        let n = model.n_joints();
        let whole = pass.total();
        let free = pass.nominal(&whole.gram, whole.right.col_as_slice(0));
        let apparent_mass = free[0];
        // One over K, all alike at first.
        let mut per = vec![apparent_mass / mass; n];
        let nominal: [f64; PER_BODY] = std::array::from_fn(|k| free[k] * mass / apparent_mass);
        let prior = Prior { bodies: vec![nominal], ..Prior::default() };
        let sums: Vec<_> = pass.sums.iter().map(crate::clustered::Stretches::total).collect();
        let (mut load, mut hessian) = (nominal.to_vec(), Mat::zeros(PER_BODY, PER_BODY));
        for _ in 0..ROUNDS.0 {
            hessian.fill(0.0);
            let mut right = vec![0.0; PER_BODY];
            for (own, per) in sums.iter().zip(&per) {
                hessian += faer::Scale(per * per) * &own.gram;
                right.iter_mut().zip(own.right.col(0).iter()).for_each(|(sum, x)| *sum += per * x);
            }
            let hold = HELD * hessian[(0, 0)];
            hessian[(0, 0)] += hold;
            right[0] += hold * mass;
            let cost = Quadratic { hessian: &hessian, right: &right };
            load = minimise(cost, &prior, STRENGTH, &load)?;
            let of_load = ColRef::from_slice(&load);
            let mut most = 0.0_f64;
            for (own, per) in sums.iter().zip(&mut per) {
                let squares = of_load.transpose() * &own.gram * of_load;
                let found = of_load.transpose() * own.right.col(0) / squares.max(f64::MIN_POSITIVE);
                most = most.max((found - *per).abs() / per.abs().max(f64::MIN_POSITIVE));
                *per = found;
            }
            if most < ROUNDS.1 {
                break;
            }
        }

        // Scores and curvature of (load, one over K).
        let p = PER_BODY + n;
        let mut whole = Mat::zeros(p, p);
        prior.add_slopes(&load, STRENGTH, &mut [0.0; PER_BODY], &mut hessian);
        whole.submatrix_mut(0, 0, PER_BODY, PER_BODY).copy_from(&hessian);
        let of_load = ColRef::from_slice(&load).as_mat();
        for (joint, own) in sums.iter().enumerate() {
            let across = faer::Scale(per[joint]) * &own.gram * of_load;
            for k in 0..PER_BODY {
                whole[(k, PER_BODY + joint)] = across[(k, 0)];
                whole[(PER_BODY + joint, k)] = across[(k, 0)];
            }
            let square = (of_load.transpose() * &own.gram * of_load)[(0, 0)];
            whole[(PER_BODY + joint, PER_BODY + joint)] = square.max(f64::MIN_POSITIVE);
        }
        let stretches: Vec<Vec<_>> = pass.sums.iter().map(|own| own.all().collect()).collect();
        let count = stretches.first().map_or(0, Vec::len);
        let scores = (0..count).map(|stretch| {
            let mut score = Mat::zeros(p, 1);
            for joint in 0..n {
                let own =
                    stretches[joint][stretch].score((faer::Scale(per[joint]) * of_load).as_ref());
                for k in 0..PER_BODY {
                    score[(k, 0)] += per[joint] * own[(k, 0)];
                    score[(PER_BODY + joint, 0)] += load[k] * own[(k, 0)];
                }
            }
            score
        });
        let mut middle = scatter(scores);
        if !chain.covariance.is_empty() {
            let arm = Mat::from_fn(p, pass.arm[0].ncols(), |i, j| match i.checked_sub(PER_BODY) {
                None => pass.arm.iter().zip(&per).map(|(arm, per)| per * arm[(i, j)]).sum::<f64>(),
                Some(joint) => (0..PER_BODY).map(|k| load[k] * pass.arm[joint][(k, j)]).sum(),
            });
            middle += &arm * chain.covariance_matrix() * arm.transpose();
        }
        let cost = Quadratic { hessian: &whole, right: &[] };
        let factor = curvature(cost, &Prior::default(), 0.0, &vec![0.0; p])?;
        let half = factor.solve_matrix(&middle);
        let covariance = factor.solve_matrix(&half.transpose().to_owned());
        let gain = |joint: usize| {
            let error = covariance[(PER_BODY + joint, PER_BODY + joint)].max(0.0).sqrt();
            Estimated { value: 1.0 / per[joint], std_error: error / per[joint].powi(2) }
        };
        let gains = (0..n).map(gain).collect();
        Ok(Self { gains, known_mass: mass, apparent_mass, rows: pass.rows })
    }

    /// Joints whose gain the log tells.
    pub fn told(&self) -> Vec<bool> {
        self.gains.iter().map(|gain| gain.std_error < TOLD * gain.value).collect()
    }
}
