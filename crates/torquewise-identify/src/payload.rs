//! The load on a link, from a log and a model of the bare arm (E15).

mod gains;
mod rows;

use crate::clustered::{Stretches, scatter, score};
use faer::{ColRef, Mat};
use serde::Serialize;
use torquewise_model::shaft_friction::Estimated;
use torquewise_model::{LinkFrame, Model, ModelError, RigidChain};
use torquewise_motion::Recording;
use torquewise_regression::normal_equations::NormalEquations;
use torquewise_rigid::feasible::{Prior, Quadratic, curvature, minimise};
use torquewise_rigid::geometry::Placement;
use torquewise_rigid::inertia::{plain_link, seen_from};
use torquewise_rigid::recursion::PER_BODY;
use torquewise_stepwise::error::IdentifyError;

pub use gains::Gains;
use rows::{Columns, Weights, WithLoad, state_of, visit};

/// A body on a link of an arm.
///
/// It is in the frame of that link: as the URDF has it, where one gave the geometry; else z is the
/// axis of its joint and the origin where that is next to the axis before.
#[derive(Clone, Debug, Serialize)]
pub struct Payload {
    /// The link, as a URDF calls it.
    pub link: Option<String>,
    /// \[kg\]
    pub mass: Estimated,
    /// Centre of mass \[m\].
    pub center: [Estimated; 3],
    /// Moments about the centre of mass xx, yy, zz, xy, xz, yz \[kg·m²\].
    pub inertia: [Estimated; 6],
    /// Rows it was found on.
    pub rows: usize,
    /// What joints say of it apart, over what their errors allow: its errors are scaled by it. At
    /// least 1.
    pub disagreement: f64,
    /// The link on which a load explains significantly more: as a URDF calls it, or its joint.
    pub elsewhere: Option<String>,
    /// RMS of what the model without it leaves of the torque of each joint \[N·m\], n.
    pub residual_without: Vec<f64>,
    /// The same with it.
    pub residual_with: Vec<f64>,
    /// The link, from 0.
    #[serde(skip)]
    on: usize,
    #[serde(skip)]
    inertial: [f64; PER_BODY],
    /// Covariance that the log makes, 10×10.
    #[serde(skip)]
    own: Mat<f64>,
    /// How the load follows from errors of the parameters of the arm, 10×p.
    #[serde(skip)]
    followed: Mat<f64>,
}

/// Stretches of time at most, and rows of each at least: a log for a load is short.
const STRETCHES: (usize, usize) = (256, 128);
/// Spread of a nominal load \[m\], and its least mass \[kg\].
const NOMINAL: (f64, f64) = (0.05, 1e-3);
/// How strongly a load is held at the nominal one, in squares of the noise: alone it leaves a mass
/// uncertain by more than half of it.
const STRENGTH: f64 = 0.1;
/// A mass is told where its standard error is below this part of it, a centre where it is below so
/// many \[m\].
const TOLD: (f64, f64) = (0.3, 0.02);
/// Joints disagree, or a load is elsewhere, beyond so many standard errors.
const DISAGREE: f64 = 2.0;
const ELSEWHERE: f64 = 4.0;
/// A step of the inertial parameters to differentiate by, in standard errors.
const STEP: f64 = 1e-4;

impl Payload {
    /// Estimates the load by what a model leaves of the torque: τ − τ̂ = Yₖ(q, q̇, q̈) β, linear in
    /// the ten inertial parameters β of the load on link k, solved as \[E11\] among the bodies that
    /// can be \[E14\]. Errors count the scatter over blocks of time, what is uncertain of the arm,
    /// and how far joints disagree about the load.
    ///
    /// - `recording`: rows filtered as those of the model were
    /// - `link`: that carries the load, from 0
    ///
    /// # Errors
    /// [`IdentifyError::Model`] if the model is no rigid chain or of another arm,
    /// [`IdentifyError::Chain`] if the rows do not suffice, and those of reading.
    pub fn find(
        model: &Model,
        recording: &(impl Recording + ?Sized),
        link: usize,
    ) -> Result<Self, IdentifyError> {
        let chain = chain_of(model)?;
        model.check_joints(recording.joints())?;
        let passes = Pass::over(model, chain, recording)?;
        let pass = &passes[link];
        let (solution, prior, information) = pass.solved()?;
        let nominal = prior.bodies[0];
        // At the solution the divergence would hold a load that hardly can be, and hide its errors.
        let cost = Quadratic { hessian: &information, right: &[] };
        let factor = curvature(cost, &prior, STRENGTH, &nominal)?;
        let mut middle = pass.scatter(&solution);
        prior.add_slopes(&nominal, STRENGTH, &mut [0.0; PER_BODY], &mut middle);
        let ones = vec![1.0; model.n_joints()];
        let with = WithLoad::over(model, chain, recording, (link, &solution, &ones))?;
        let p = chain.n_parameters(model.friction.len());
        let arm = with.arm.iter().fold(Mat::zeros(PER_BODY, p), |sum, own| sum + own);
        let followed = factor.solve_matrix(&arm);
        let of_arm = chain.covariance_matrix();
        let is_uncertain = !chain.covariance.is_empty();
        let seen = |joint: usize| {
            is_uncertain.then(|| &with.arm[joint] * &of_arm * with.arm[joint].transpose())
        };
        let disagreement = pass.disagreement(&solution, &seen);
        let own = factor.sandwiched(&middle) * faer::Scale(disagreement.powi(2));
        let mut covariance = own.clone();
        if is_uncertain {
            let arm = &followed * of_arm * followed.transpose();
            covariance += arm * faer::Scale(disagreement.powi(2));
        }
        let robot = chain.robot.as_ref();
        let frame = robot.and_then(|robot| robot.frames.get(link).copied());
        let inertial: [f64; PER_BODY] = std::array::from_fn(|k| solution[k]);
        let [mass, center, inertia] = central(&inertial, &covariance, frame);
        let rms = |squares: &[f64]| -> Vec<f64> {
            squares.iter().map(|sum| (sum / pass.rows.max(1) as f64).sqrt()).collect()
        };
        let name = |link: usize| robot.map_or(&model.joints[link], |robot| &robot.links[link]);
        Ok(Self {
            link: robot.map(|_| name(link).clone()),
            mass: mass[0],
            center: std::array::from_fn(|k| center[k]),
            inertia: std::array::from_fn(|k| inertia[k]),
            rows: pass.rows,
            disagreement,
            elsewhere: Pass::better(&passes, link, &solution).map(|link| name(link).clone()),
            residual_without: rms(&pass.squares),
            residual_with: rms(&with.squares),
            on: link,
            inertial,
            own,
            followed,
        })
    }

    /// What the log does not determine, and which motion would.
    pub fn hints(&self) -> Vec<String> {
        let mut hints = Vec::new();
        if let Some(link) = &self.elsewhere {
            hints.push(format!(
                "a load on {link} explains the torque better: name what carries it by --link"
            ));
        }
        if self.disagreement > DISAGREE {
            hints.push(format!(
                "joints disagree about the load by {:.1} times their errors, by which ± is scaled: \
                 it may hang elsewhere, or the arm differ from its model",
                self.disagreement
            ));
        }
        let is_told = self.mass.std_error < TOLD.0 * self.mass.value;
        if !is_told {
            hints.push(
                "the mass is not told from zero: hold the load in many poses, with the arm \
                 stretched and folded"
                    .to_owned(),
            );
        }
        if is_told && self.center.iter().any(|center| center.std_error > TOLD.1) {
            hints.push(
                "the centre of mass is uncertain by more than 2 cm: turn the last joints, so that \
                 gravity pulls at the load from three sides"
                    .to_owned(),
            );
        }
        hints
    }

    /// The model of the arm that carries the load; its equations to read are those of the arm alone.
    ///
    /// # Errors
    /// [`IdentifyError::Model`] if the model is no rigid chain.
    pub fn added_to(&self, model: &Model) -> Result<Model, IdentifyError> {
        let mut model = model.clone();
        chain_of(&model)?;
        let Some(chain) = &mut model.chain else { return Ok(model) };
        let first = PER_BODY * self.on;
        if let Some(link) = chain.links.get_mut(self.on) {
            link.iter_mut().zip(self.inertial).for_each(|(own, load)| *own += load);
        }
        if !chain.covariance.is_empty() {
            let covariance = chain.covariance_matrix();
            let p = covariance.nrows();
            // What the load is taken for too large, the arm is too small.
            let change = Mat::from_fn(p, p, |i, j| {
                let is_own = f64::from(u8::from(i == j));
                let load = i.checked_sub(first).filter(|k| *k < PER_BODY);
                is_own - load.map_or(0.0, |k| self.followed[(k, j)])
            });
            let mut whole = &change * covariance * change.transpose();
            for i in 0..PER_BODY {
                for j in 0..PER_BODY {
                    whole[(first + i, first + j)] += self.own[(i, j)];
                }
            }
            chain.set_covariance(&whole);
        }
        Ok(model)
    }
}

fn chain_of(model: &Model) -> Result<&RigidChain, IdentifyError> {
    Ok(model.chain.as_ref().ok_or(ModelError::NoChain)?)
}

/// What one pass over the rows adds up to, for a load on one link.
#[derive(Clone)]
struct Pass {
    /// Of Y β = what the model leaves, ten columns, for each joint, n.
    sums: Vec<Stretches>,
    /// Squares of what the model leaves of each joint, n.
    squares: Vec<f64>,
    rows: usize,
}

impl Pass {
    /// For a load on each link, n.
    fn over(
        model: &Model,
        chain: &RigidChain,
        recording: &(impl Recording + ?Sized),
    ) -> Result<Vec<Self>, IdentifyError> {
        let n = model.n_joints();
        let (weights, mut columns) = (Weights::of(model), Columns::of(chain)?);
        let (most, rows) = STRETCHES;
        let sums = vec![Stretches::new(PER_BODY, most, rows); n];
        let mut passes = vec![Self { sums, squares: vec![0.0; n], rows: 0 }; n];
        let mut y = Mat::zeros(n, PER_BODY * n);
        visit(model, recording, &mut |block, left, _| {
            for row in 0..block.n_rows() {
                let state = state_of(block, row);
                columns.at(state.each_ref().map(Vec::as_slice), &mut y);
                for (link, pass) in passes.iter_mut().enumerate() {
                    for joint in 0..n {
                        let weight = weights.square(joint, state[1][joint]);
                        let error = left[(row, joint)];
                        pass.squares[joint] += error * error;
                        let own: [f64; PER_BODY] =
                            std::array::from_fn(|k| y[(joint, PER_BODY * link + k)]);
                        pass.sums[joint].add(&own, error, weight);
                    }
                    pass.rows += 1;
                }
            }
            Ok(())
        })?;
        Ok(passes)
    }

    /// The load among bodies that can be, with what it is held at, and the information.
    fn solved(&self) -> Result<(Vec<f64>, Prior, Mat<f64>), IdentifyError> {
        let NormalEquations { gram, cross, .. } = self.total();
        let right = cross.col_as_slice(0);
        let prior = Prior { bodies: vec![self.nominal(&gram, right)], ..Prior::default() };
        let cost = Quadratic { hessian: &gram, right };
        let solution = minimise(cost, &prior, STRENGTH, &prior.bodies[0])?;
        Ok((solution, prior, gram))
    }

    /// How far joints disagree about how heavy the load is, over what their errors allow (Birge):
    /// √(χ² / (n − 1)), at least 1.
    ///
    /// - `arm`: what the uncertain arm makes of the scores of a joint, 10×10
    fn disagreement(&self, load: &[f64], arm: &dyn Fn(usize) -> Option<Mat<f64>>) -> f64 {
        let x = ColRef::from_slice(load).as_mat();
        let along = |square: &Mat<f64>| (x.transpose() * square * x)[(0, 0)];
        let (mut squares, mut joints) = (0.0, 0.0);
        for (joint, own) in self.sums.iter().enumerate() {
            let excess = (x.transpose() * score(&own.total(), x))[(0, 0)];
            let allowed = along(&scatter(own.all().map(|own| score(own, x))))
                + arm(joint).map_or(0.0, |arm| along(&arm));
            if allowed > 0.0 {
                squares += excess * excess / allowed;
                joints += 1.0;
            }
        }
        f64::max(squares / f64::max(joints - 1.0, 1.0), 1.0).sqrt()
    }

    /// The link on which a load leaves least, if significantly less than the load on another.
    fn better(passes: &[Self], link: usize, load: &[f64]) -> Option<usize> {
        let left = |pass: &Self, load: &[f64]| -> Vec<f64> {
            let x = ColRef::from_slice(load).as_mat();
            let of = |own: NormalEquations| {
                let twice = &own.cross + score(&own, x);
                own.energy[0] - (x.transpose() * twice)[(0, 0)]
            };
            pass.stretches().map(of).collect()
        };
        let all = passes.iter().enumerate().filter_map(|(link, pass)| {
            let (load, ..) = pass.solved().ok()?;
            Some((link, left(pass, &load)))
        });
        let sum = |left: &[f64]| left.iter().sum::<f64>();
        let (best, least) = all.min_by(|a, b| sum(&a.1).total_cmp(&sum(&b.1)))?;
        let own = left(&passes[link], load);
        let gained: Vec<f64> = own.iter().zip(least).map(|(own, least)| own - least).collect();
        let mean = sum(&gained) / gained.len() as f64;
        let error = gained.iter().map(|gain| (gain - mean).powi(2)).sum::<f64>().sqrt();
        (best != link && sum(&gained) > ELSEWHERE * error).then_some(best)
    }

    /// All joints together, stretch by stretch.
    fn stretches(&self) -> impl Iterator<Item = NormalEquations> {
        let all: Vec<Vec<&NormalEquations>> =
            self.sums.iter().map(|own| own.all().collect()).collect();
        let count = all.first().map_or(0, Vec::len);
        (0..count).map(move |k| all.iter().map(|stretches| stretches[k]).sum())
    }

    fn total(&self) -> NormalEquations {
        self.stretches().collect::<Vec<_>>().iter().sum()
    }

    fn scatter(&self, load: &[f64]) -> Mat<f64> {
        scatter(self.stretches().map(|own| score(&own, ColRef::from_slice(load).as_mat())))
    }

    /// A load that may well be: of the mass and centre that least squares say, if they say any, and
    /// of no less mass than they are uncertain by.
    fn nominal(&self, information: &Mat<f64>, right: &[f64]) -> [f64; PER_BODY] {
        // Gravity tells mass and first moment; a little of each keeps what it does not tell at zero.
        let ridge = |k: usize| 1e-9 * information[(k, k)] + 1e-12 * information[(0, 0)] + 1e-30;
        let first =
            Mat::from_fn(4, 4, |i, j| information[(i, j)] + if i == j { ridge(i) } else { 0.0 });
        let own = Quadratic { hessian: &first, right: &right[..4] };
        let mut found = vec![0.0; PER_BODY];
        let mut uncertain = 0.0;
        if let Ok(factor) = curvature(own, &Prior::default(), 0.0, &[0.0; 4]) {
            found[..4].copy_from_slice(&factor.solve(&right[..4]));
            let scatter = self.scatter(&found).submatrix(0, 0, 4, 4).to_owned();
            uncertain = factor.sandwiched(&scatter)[(0, 0)].max(0.0).sqrt();
        }
        let mass = found[0].max(uncertain).max(NOMINAL.1);
        let center = |k: usize| (found[k] / mass).clamp(-1.0, 1.0);
        let origin = nalgebra::Vector3::new(center(1), center(2), center(3));
        let spread = NOMINAL.0;
        let round = plain_link(mass, &nalgebra::Vector3::zeros(), spread);
        seen_from(&round, &Placement { rotation: nalgebra::Matrix3::identity(), origin })
    }
}

/// Mass, centre and moments about the centre with their standard errors, seen from a frame.
fn central(
    inertial: &[f64; PER_BODY],
    covariance: &Mat<f64>,
    frame: Option<LinkFrame>,
) -> [Vec<Estimated>; 3] {
    let frame = frame.map(|LinkFrame { rotation, origin }| Placement {
        rotation: nalgebra::Matrix3::from_fn(|i, j| rotation[i][j]),
        origin: origin.into(),
    });
    let values = |p: &[f64]| -> [f64; PER_BODY] {
        let p = frame.as_ref().map_or_else(|| p.to_vec(), |frame| seen_from(p, frame).to_vec());
        let [m, hx, hy, hz] = [p[0], p[1], p[2], p[3]];
        let [x, y, z] = [hx / m, hy / m, hz / m];
        [
            m,
            x,
            y,
            z,
            p[4] - m * (y * y + z * z),
            p[5] - m * (x * x + z * z),
            p[6] - m * (x * x + y * y),
            p[7] + m * x * y,
            p[8] + m * x * z,
            p[9] + m * y * z,
        ]
    };
    let slopes = Mat::from_fn(PER_BODY, PER_BODY, |i, j| {
        let step = STEP * covariance[(j, j)].max(f64::MIN_POSITIVE).sqrt();
        let at = |by: f64| {
            let mut moved = *inertial;
            moved[j] += by;
            values(&moved)[i]
        };
        if step > 0.0 { (at(step) - at(-step)) / (2.0 * step) } else { 0.0 }
    });
    let spread = &slopes * covariance * slopes.transpose();
    let all = values(inertial);
    let one = |k: usize| Estimated { value: all[k], std_error: spread[(k, k)].max(0.0).sqrt() };
    [vec![one(0)], (1..4).map(one).collect(), (4..PER_BODY).map(one).collect()]
}
