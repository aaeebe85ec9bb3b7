//! The load on a link, from a log and a model of the bare arm (E15).

mod gains;
mod pass;
mod rows;

use crate::Disagreement;
use crate::fitted::loaded_equations;
use faer::Mat;
use nalgebra::Vector3;
use serde::Serialize;
use torquewise_model::shaft_friction::Estimated;
use torquewise_model::{Form, LinkFrame, Model, ModelError, RigidChain, number};
use torquewise_motion::Recording;
use torquewise_rigid::feasible::{Quadratic, curvature};
use torquewise_rigid::inertia::seen_from;
use torquewise_rigid::{PER_BODY, Placement};
use torquewise_stepwise::IdentifyError;

pub use gains::DriveGains;
use pass::Pass;
use rows::WithLoad;

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
    /// Mass \[kg\] that the log seems to lack, where gravity says that it is lighter than the model.
    pub lighter: Option<f64>,
    /// RMS of what the model without it leaves of the torque of each joint \[N·m\], n.
    pub residual_without: Vec<f64>,
    /// The same with it.
    pub residual_with: Vec<f64>,
    /// Logs that do not carry the same load.
    #[serde(skip)]
    pub at_odds: Vec<Disagreement>,
    /// Whether the verdict of the fit of the model is that it should not be used.
    #[serde(skip)]
    of_useless: bool,
    /// Whether the axes of the model were given.
    #[serde(skip)]
    is_given: bool,
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

/// Where a load is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoadPlace {
    link: usize,
    center: Option<[f64; 3]>,
}

impl LoadPlace {
    /// On the link of a name, as the URDF that gave the geometry calls it or its joint; the last if
    /// none. `None` if the model has no such link.
    ///
    /// - `center`: of mass in the frame of the link \[m\], where that is known: nothing else tells the
    ///   mass of a load that turns about a point and is not lifted
    pub fn named(model: &Model, name: Option<&str>, center: Option<[f64; 3]>) -> Option<Self> {
        let robot = model.chain.as_ref().and_then(|chain| chain.robot.as_ref());
        let mut links = robot.iter().flat_map(|robot| robot.links.iter().enumerate());
        let mut joints = model.joints.iter().enumerate();
        let link = match name {
            None => model.n_joints().checked_sub(1)?,
            Some(name) => {
                links
                    .find(|(_, link)| *link == name)
                    .or_else(|| joints.find(|(_, joint)| *joint == name))?
                    .0
            }
        };
        Some(Self { link, center })
    }
}

/// How strongly a load is held at the nominal one, in squares of the noise: alone it leaves a mass
/// uncertain by more than half of it.
const STRENGTH: f64 = 0.1;
/// A mass is told where its standard error is below this part of it, a centre where it is below so
/// many \[m\].
const TOLD: (f64, f64) = (0.3, 0.02);
/// Joints that disagree about a load by more than so many of their errors are told of.
const DISAGREE: f64 = 2.0;
/// A step of the inertial parameters to differentiate by, in standard errors.
const STEP: f64 = 1e-4;

impl Payload {
    /// Estimates the load by what a model leaves of the torque: τ − τ̂ = Yₖ(q, q̇, q̈) β, linear in
    /// the ten inertial parameters β of the load on link k, solved as \[E11\] among the bodies that
    /// can be \[E14\]. Errors count the scatter over blocks of time, what is uncertain of the arm,
    /// and how far joints disagree about the load.
    ///
    /// - `recording`: rows filtered as those of the model were
    /// - `place`: where the load is
    ///
    /// # Errors
    /// [`IdentifyError::Model`] if the model is no rigid chain or of another arm,
    /// [`IdentifyError::Chain`] if the rows do not suffice, and those of reading.
    pub fn find(
        model: &Model,
        recording: &(impl Recording + ?Sized),
        place: LoadPlace,
    ) -> Result<Self, IdentifyError> {
        let chain = chain_of(model)?;
        Self::of_passes(&Pass::over(model, chain, recording)?, (model, chain), recording, place)
    }

    fn of_passes(
        passes: &[Pass],
        (model, chain): (&Model, &RigidChain),
        recording: &(impl Recording + ?Sized),
        LoadPlace { link, center }: LoadPlace,
    ) -> Result<Self, IdentifyError> {
        let pass = passes.get(link).ok_or(ModelError::NoChain)?;
        let robot = chain.robot.as_ref();
        let frame = robot.and_then(|robot| robot.frames.get(link)).map(placed);
        let center = center
            .map(Vector3::from)
            .map(|center| frame.map_or(center, |own| own.rotation.tr_mul(&(center - own.origin))));
        let ones = vec![1.0; model.n_joints()];
        let is_uncertain = !chain.covariance_root.is_empty();
        let with = |load: &[f64]| WithLoad::over(model, chain, recording, (link, load, &ones));
        let seen = |with: &WithLoad, joint: usize, counts: f64| {
            is_uncertain.then(|| chain.covariance_of(&(faer::Scale(counts) * &with.arm[joint])))
        };
        // How certain each joint is takes a load to say.
        let (first, ..) = pass.solved(center)?;
        let at_first = with(&first)?;
        let counts = pass.counts(&first, &|joint| seen(&at_first, joint, 1.0));
        let pass = pass.weighted(&counts);
        let (solution, prior, information) = pass.solved(center)?;
        let with = with(&solution)?;
        let nominal = prior.bodies[0];
        // At the solution the divergence would hold a load that hardly can be, and hide its errors.
        let cost = Quadratic { hessian: &information, right: &[] };
        let factor = curvature(cost, &prior, STRENGTH, &nominal)?;
        let mut middle = pass.scatter(&solution);
        prior.add_hessian(&nominal, STRENGTH, &mut middle);
        let p = chain.n_parameters(model.friction.len());
        let arm = with.arm.iter().zip(&counts);
        let arm = arm.fold(Mat::zeros(PER_BODY, p), |sum, (own, by)| sum + faer::Scale(*by) * own);
        let followed = factor.solve_matrix(&arm);
        let seen = |joint: usize| seen(&with, joint, counts[joint]);
        let disagreement = pass.disagreement(&solution, &seen);
        let own = factor.sandwiched(&middle) * faer::Scale(disagreement.powi(2));
        let of_arm = is_uncertain.then(|| chain.covariance_of(&arm));
        let mut covariance = own.clone();
        if is_uncertain {
            covariance += chain.covariance_of(&followed) * faer::Scale(disagreement.powi(2));
        }
        let inertial: [f64; PER_BODY] = std::array::from_fn(|k| solution[k]);
        let central = central(&inertial, &covariance, frame);
        let rms = |squares: &[f64]| -> Vec<f64> {
            squares.iter().map(|sum| (sum / pass.rows.max(1) as f64).sqrt()).collect()
        };
        let name = |link: usize| robot.map_or(&model.joints[link], |robot| &robot.links[link]);
        Ok(Self {
            link: robot.map(|_| name(link).clone()),
            mass: central[0],
            center: std::array::from_fn(|k| central[1 + k]),
            inertia: std::array::from_fn(|k| central[4 + k]),
            rows: pass.rows,
            disagreement,
            lighter: pass.lighter(of_arm.as_ref(), &model.training.unseen_rms()),
            elsewhere: Pass::better(passes, link).map(|link| name(link).clone()),
            residual_without: rms(&pass.squares),
            residual_with: rms(&with.squares),
            at_odds: Vec::new(),
            of_useless: model.training.useless().is_some(),
            is_given: is_given(chain),
            on: link,
            inertial,
            own,
            followed,
        })
    }

    /// What the log does not determine, and which motion would.
    pub fn hints(&self) -> Vec<String> {
        let mut hints: Vec<String> = self.at_odds.iter().map(ToString::to_string).collect();
        if self.of_useless {
            let said = "the model is unusable by the verdict of its fit, and so may the load be";
            hints.push(said.to_owned());
        }
        if let Some(mass) = self.lighter {
            hints.push(format!(
                "gravity says that the log is {} kg lighter than the model: no load is found on it; \
                 the model may hold a tool or a load that the arm no longer carries",
                number(mass)
            ));
            return hints;
        }
        let is_some = self.mass.value > 2.0 * self.mass.std_error;
        if let Some(link) = self.elsewhere.as_ref().filter(|_| is_some) {
            let learned = "; the axes of the model were learned, those of a wrist may be off by more \
                           than the errors say: a fit with a URDF tells which link it is";
            hints.push(format!(
                "a load on {link} explains the torque better: say which link carries it{}",
                if self.is_given { "" } else { learned }
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
            let how = if is_some { "told roughly only" } else { "not told from zero" };
            let hold = "hold the load in many poses, with the arm stretched and folded";
            hints.push(format!("the mass is {how}: {hold}, or give its centre"));
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

    /// The model of the arm that carries the load, with its equations.
    ///
    /// # Errors
    /// [`IdentifyError::Model`] if the model is no rigid chain.
    pub fn added_to(&self, model: &Model) -> Result<Model, IdentifyError> {
        let mut chain = chain_of(model)?.clone();
        let first = PER_BODY * self.on;
        if let Some(link) = chain.links.get_mut(self.on) {
            link.iter_mut().zip(self.inertial).for_each(|(own, load)| *own += load);
        }
        if !chain.covariance_root.is_empty() {
            let p = chain.covariance_root.len();
            // What the load is taken for too large, the arm is too small.
            let change = Mat::from_fn(p, p, |i, j| {
                let is_own = f64::from(u8::from(i == j));
                let load = i.checked_sub(first).filter(|k| *k < PER_BODY);
                is_own - load.map_or(0.0, |k| self.followed[(k, j)])
            });
            let mut whole = chain.covariance_of(&change);
            for i in 0..PER_BODY {
                for j in 0..PER_BODY {
                    whole[(first + i, first + j)] += self.own[(i, j)];
                }
            }
            chain.set_covariance(&whole)?;
        }
        let terms = loaded_equations(model, [chain_of(model)?, &chain])?;
        Ok(Model { form: Form::Energy(terms), chain: Some(chain), ..model.clone() })
    }
}

/// Whether the axes of a chain were given, not learned.
fn is_given(chain: &RigidChain) -> bool {
    chain.robot.is_some() || chain.fitted.is_empty()
}

fn chain_of(model: &Model) -> Result<&RigidChain, IdentifyError> {
    Ok(model.chain.as_ref().ok_or(ModelError::NoChain)?)
}

fn placed(LinkFrame { rotation, origin }: &LinkFrame) -> Placement {
    let rotation = nalgebra::Matrix3::from_fn(|i, j| rotation[i][j]);
    Placement { rotation, origin: (*origin).into() }
}

/// Mass, centre and moments about the centre with their standard errors, seen from a frame.
fn central(
    inertial: &[f64; PER_BODY],
    covariance: &Mat<f64>,
    frame: Option<Placement>,
) -> [Estimated; PER_BODY] {
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
    let error = |k: usize| spread[(k, k)].max(0.0).sqrt();
    std::array::from_fn(|k| Estimated { value: all[k], std_error: error(k) })
}
