//! Gains of the torque columns, from a load of known mass (E15).

use super::pass::Pass;
use super::rows::WithLoad;
use super::{LoadPlace, Payload, STRENGTH, chain_of, is_given};
use crate::Disagreement;
use crate::clustered::{Stretches, scatter, score};
use crate::warning::list;
use faer::{ColRef, Mat};
use serde::Serialize;
use torquewise_model::shaft_friction::Estimated;
use torquewise_model::{Model, ModelError};
use torquewise_motion::Recording;
use torquewise_regression::NormalEquations;
use torquewise_rigid::PER_BODY;
use torquewise_rigid::feasible::{Factored, Prior, Quadratic, minimise};
use torquewise_stepwise::IdentifyError;

/// Torque for a unit of each torque column, such as N·m/A where it is a current.
#[derive(Clone, Debug, Serialize)]
pub struct DriveGains {
    /// K of each joint, n.
    pub gains: Vec<Estimated>,
    /// The mass that they rest on \[kg\].
    pub known_mass: f64,
    /// The mass that the torque columns would say \[kg\], if they were in N·m.
    pub apparent_mass: f64,
    /// Rows that they were found on.
    pub rows: usize,
    /// Logs that do not carry the same load.
    #[serde(skip)]
    pub at_odds: Vec<Disagreement>,
    #[serde(skip)]
    joints: Vec<String>,
    /// Whether the axes of the model were given.
    #[serde(skip)]
    is_given: bool,
}

/// A gain is resolved where its standard error is below this part of it.
const TOLD: f64 = 0.1;
/// Torques whose gains differ by more than this factor are not those of one arm: a model learned from
/// such columns is bent.
const APART: f64 = 1.05;
/// A mass below so many of its standard errors is no load, unless it takes this part of what is left of
/// some joint: mass and place of a load that turns about a point are told together better than apart.
const LEAST_T: f64 = 3.0;
const TAKEN: f64 = 0.5;
/// How much more than by all rows a known mass is held.
const HELD: f64 = 1e6;
/// Steps at most, until the cost falls by no more than this part; a step is halved so often at most.
const STEPS: (usize, f64) = (100, 1e-12);
const HALVINGS: i32 = 20;

/// Sums of each joint at a load, with the gains that are best there.
struct AtLoad {
    /// Its inertial parameters, 10.
    load: Vec<f64>,
    /// One over K, n.
    per: Vec<f64>,
    /// Half the weighted squares that are left, but for a constant.
    cost: f64,
    /// Of that cost, 10×1.
    slope: Mat<f64>,
    /// Its curvature, 10×10.
    hessian: Mat<f64>,
}

impl AtLoad {
    fn new(sums: &[NormalEquations], load: Vec<f64>) -> Self {
        let x = ColRef::from_slice(&load).as_mat();
        let (mut slope, mut hessian) = (Mat::zeros(PER_BODY, 1), Mat::zeros(PER_BODY, PER_BODY));
        let (mut per, mut cost) = (Vec::new(), 0.0);
        for own in sums {
            let pulled = &own.gram * x;
            let squares = (x.transpose() * &pulled)[(0, 0)].max(f64::MIN_POSITIVE);
            let along = (x.transpose() * &own.cross)[(0, 0)];
            let gain = along / squares;
            cost -= 0.5 * along * gain;
            slope += faer::Scale(gain) * (faer::Scale(gain) * &pulled - &own.cross);
            let free = &own.gram - faer::Scale(1.0 / squares) * &pulled * pulled.transpose();
            hessian += faer::Scale(gain * gain) * free;
            per.push(gain);
        }
        Self { load, per, cost, slope, hessian }
    }

    /// What joints add up to, 10×m each, as the load and each gain feel it: (10 + n)×m.
    fn felt(&self, of: &dyn Fn(usize) -> Mat<f64>) -> Mat<f64> {
        let all: Vec<Mat<f64>> = (0..self.per.len()).map(of).collect();
        let rows = PER_BODY + self.per.len();
        Mat::from_fn(rows, all[0].ncols(), |i, j| match i.checked_sub(PER_BODY) {
            None => all.iter().zip(&self.per).map(|(own, per)| per * own[(i, j)]).sum::<f64>(),
            Some(joint) => (0..PER_BODY).map(|k| self.load[k] * all[joint][(k, j)]).sum(),
        })
    }

    /// Scatter of the scores of stretches of load and gains together.
    fn scatter(&self, pass: &Pass) -> Mat<f64> {
        let x = ColRef::from_slice(&self.load).as_mat();
        let stretches: Vec<Vec<&NormalEquations>> =
            pass.sums.iter().map(|own| own.all().collect()).collect();
        let of = |stretch: usize| {
            self.felt(&|joint| {
                score(stretches[joint][stretch], (faer::Scale(self.per[joint]) * x).as_ref())
            })
        };
        scatter((0..stretches[0].len()).map(of))
    }

    /// Curvature of the cost of load and gains together.
    fn curvature(&self, sums: &[NormalEquations], prior: &Prior) -> Mat<f64> {
        let p = PER_BODY + self.per.len();
        let x = ColRef::from_slice(&self.load).as_mat();
        let mut of_load = Mat::zeros(PER_BODY, PER_BODY);
        prior.add_hessian(&self.load, STRENGTH, &mut of_load);
        for (own, per) in sums.iter().zip(&self.per) {
            of_load += faer::Scale(per * per) * &own.gram;
        }
        of_load[(0, 0)] *= HELD;
        let mut whole = Mat::zeros(p, p);
        whole.submatrix_mut(0, 0, PER_BODY, PER_BODY).copy_from(&of_load);
        for (joint, own) in sums.iter().enumerate() {
            let (pulled, place) = (&own.gram * x, PER_BODY + joint);
            for k in 0..PER_BODY {
                whole[(k, place)] = self.per[joint] * pulled[(k, 0)];
                whole[(place, k)] = whole[(k, place)];
            }
            let squares = (x.transpose() * &pulled)[(0, 0)];
            whole[(place, place)] = squares.max(f64::MIN_POSITIVE);
        }
        whole
    }
}

impl DriveGains {
    /// Finds gains Kⱼ of drives, and the load as far as it is not known, by what a model of the bare
    /// arm, learned from the same columns, leaves of them: iⱼ − îⱼ = Yⱼ π / Kⱼ, with π₀ the known
    /// mass \[E15\]. Errors count the scatter over blocks of time and what is uncertain of the arm.
    ///
    /// - `recording`: rows of the arm with the load, filtered as those of the model were
    /// - `place`: where the load is
    /// - `mass`: of the load \[kg\]
    ///
    /// # Errors
    /// [`IdentifyError::NoLoad`] if the log tells of none, and those of [`Payload::find`].
    pub fn find(
        model: &Model,
        recording: &(impl Recording + ?Sized),
        place: LoadPlace,
        mass: f64,
    ) -> Result<Self, IdentifyError> {
        let chain = chain_of(model)?;
        let passes = Pass::over(model, chain, recording)?;
        let load = Payload::of_passes(&passes, (model, chain), recording, place)?;
        let apparent = load.mass;
        let mut left = load.residual_with.iter().zip(&load.residual_without);
        let is_felt = left.any(|(with, without)| *with < (1.0 - TAKEN) * without);
        if apparent.value < LEAST_T * apparent.std_error && !is_felt {
            return Err(IdentifyError::NoLoad { found: apparent.value, error: apparent.std_error });
        }
        let pass = passes.get(place.link).ok_or(ModelError::NoChain)?;
        let (_, prior, _) = pass.solved(None)?;
        let free = prior.bodies[0];
        let nominal = free.map(|own| own * mass / free[0]);
        let prior = Prior { bodies: vec![nominal], ..Prior::default() };
        let sums: Vec<NormalEquations> = pass.sums.iter().map(Stretches::total).collect();
        let at = best(&sums, &prior, mass)?;
        let mut middle = at.scatter(pass);
        if !chain.covariance_root.is_empty() {
            let with = WithLoad::over(model, chain, recording, (place.link, &at.load, &at.per))?;
            let arm = at.felt(&|joint| with.arm[joint].clone());
            middle += chain.covariance_of(&arm);
        }
        let covariance = Factored::new(at.curvature(&sums, &prior))?.sandwiched(&middle);
        let gain = |(joint, per): (usize, &f64)| {
            let error = covariance[(PER_BODY + joint, PER_BODY + joint)].max(0.0).sqrt();
            Estimated { value: 1.0 / per, std_error: error / per.powi(2) }
        };
        let gains = at.per.iter().enumerate().map(gain).collect();
        Ok(Self {
            gains,
            known_mass: mass,
            apparent_mass: apparent.value,
            rows: pass.rows,
            at_odds: Vec::new(),
            joints: model.joints.clone(),
            is_given: is_given(chain),
        })
    }

    /// Whether the gain of each joint is resolved.
    pub fn told(&self) -> Vec<bool> {
        self.gains.iter().map(|gain| gain.std_error < TOLD * gain.value).collect()
    }

    /// Why gains may be wrong, or are not resolved, and what to do.
    pub fn hints(&self) -> Vec<String> {
        let mut hints: Vec<String> = self.at_odds.iter().map(ToString::to_string).collect();
        if !self.is_given {
            hints.push(
                "the axes of the model were learned: lengths of a wrist, and with them its gains, \
                 may be off by more than the errors say; fit with a URDF"
                    .to_owned(),
            );
        }
        let told = self.told();
        let of_told = self.gains.iter().zip(&told).filter(|(_, told)| **told);
        let of_told = of_told.map(|(gain, _)| gain.value);
        let least = of_told.clone().fold(f64::INFINITY, f64::min);
        if of_told.fold(0.0, f64::max) > APART * least {
            hints.push(
                "gains differ, so that the model, which takes its columns for torques of one arm, was \
                 bent by them: they may be a quarter off; fit the bare arm again with these gains, and \
                 find them again by that model, until they stay"
                    .to_owned(),
            );
        }
        let untold = self.joints.iter().zip(&told).filter(|(_, told)| !**told);
        let untold: Vec<String> = untold.map(|(joint, _)| joint.clone()).collect();
        if !untold.is_empty() {
            hints.push(format!(
                "the load hardly loads {}: their gains are not told to a tenth, and a profile leaves \
                 their columns as they are; hold the load further out, and swing it",
                list(&untold)
            ));
        }
        hints
    }
}

/// The load of a known mass that explains most, with the best gains at each.
fn best(sums: &[NormalEquations], prior: &Prior, mass: f64) -> Result<AtLoad, IdentifyError> {
    let total = |at: &AtLoad| {
        prior.value(&at.load).map_or(f64::INFINITY, |prior| at.cost + STRENGTH * prior)
    };
    let mut at = AtLoad::new(sums, prior.bodies[0].to_vec());
    for _ in 0..STEPS.0 {
        let mut right = &at.hessian * ColRef::from_slice(&at.load).as_mat() - &at.slope;
        let hold: f64 =
            sums.iter().zip(&at.per).map(|(own, per)| HELD * per * per * own.gram[(0, 0)]).sum();
        at.hessian[(0, 0)] += hold;
        right[(0, 0)] += hold * mass;
        let cost = Quadratic { hessian: &at.hessian, right: right.col_as_slice(0) };
        let next = minimise(cost, prior, STRENGTH, &at.load)?;
        let least = total(&at);
        let step = |halved: i32| {
            let part = 0.5_f64.powi(halved);
            let way = at.load.iter().zip(&next).map(|(from, to)| from + part * (to - from));
            let at = AtLoad::new(sums, way.collect());
            (total(&at) < least).then_some(at)
        };
        let Some(better) = (0..HALVINGS).find_map(step) else { break };
        at = better;
        let left = total(&at);
        if least - left <= STEPS.1 * left.abs() {
            break;
        }
    }
    Ok(at)
}
