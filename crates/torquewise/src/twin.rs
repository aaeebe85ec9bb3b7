//! A learned model as the arm of a simulation: a twin of the robot that was logged.

use crate::Result;
use torquewise_model::shaft_friction::ShaftFriction;
use torquewise_model::{Drive, Model, ModelError, Torque};
use torquewise_motion::{Motion, ReadResult, Recording, Signals, Visit};
use torquewise_sim::excite::{JointValues, State, Torques};
use torquewise_sim::{Arm, Friction, MotionPlan, SimulatedLog, Stribeck};

/// The rigid part of a model as an arm: links, and rotors of single joints; positions and speeds are
/// those of the log it was learned from.
///
/// # Errors
/// `Error::Model` if the model is no chain of rigid bodies, `Error::Arm` if a link is none that
/// can be.
pub fn arm(model: &Model) -> Result<Arm> {
    let chain = model.chain.as_ref().ok_or(ModelError::NoChain)?;
    let n = model.n_joints();
    let mut rotors = vec![0.0; n];
    for drive in &chain.drives {
        if let Drive::Rotor { shaft, inertia } = drive
            && let [joint] = (0..n).filter(|&j| shaft[j] != 0.0).collect::<Vec<_>>()[..]
        {
            rotors[joint] += inertia * shaft[joint] * shaft[joint];
        }
    }
    let training = &model.training;
    let limits = training.q_range.iter().copied().zip(training.dq_peak.iter().copied());
    let arm = Arm::of_chain(&model.joints, &chain.axes()?, &chain.inertial(), limits)?;
    Ok(arm.with_rotors(&rotors)?)
}

/// Limits of the torque of a model, friction included, for a plan; `None` if none is given.
///
/// # Errors
/// `Error::Arm` if a limit is of no joint or out of bounds.
pub fn torques(model: &Model, most: &JointValues<f64>) -> Result<Option<Torques>> {
    let (torque, none) = (Torque::new(model), vec![f64::NAN; model.n_joints()]);
    let of = move |state: &State| {
        torque.at(&state.q, &state.dq, &state.ddq).unwrap_or_else(|_| none.clone())
    };
    Ok(Torques::new(&model.joints, most, of)?)
}

/// The friction of single joints of a model, dry and viscous, nearest to the learned curves: for
/// closed loops, whose integrator asks for curves without memory. Shafts that several joints turn
/// have none.
///
/// # Errors
/// `Error::Arm` if a number is out of bounds.
pub fn friction(model: &Model) -> Result<Friction> {
    let mut joints = vec![Stribeck::NONE; model.n_joints()];
    for shaft in ShaftFriction::all(model) {
        if let Some(joint) = shaft.joint() {
            let [viscous, dry] = shaft.line();
            joints[joint] = Stribeck { coulomb: dry, stiction: dry, speed: 1.0, viscous };
        }
    }
    Ok(Friction::new(&joints)?)
}

/// A log of the twin: motion as planned within the range of the log the model was learned from,
/// torque as the model says it, friction with its memory included.
#[derive(Clone, Debug)]
pub struct TwinLog {
    motion: SimulatedLog,
    torque: Torque,
}

impl TwinLog {
    /// The log of a plan.
    ///
    /// # Errors
    /// As [`arm`]; `Error::Arm` for a plan out of bounds.
    pub fn new(model: &Model, plan: &MotionPlan) -> Result<Self> {
        Ok(Self { motion: SimulatedLog::new(&arm(model)?, plan)?, torque: Torque::new(model) })
    }
}

impl Recording for TwinLog {
    fn joints(&self) -> &[String] {
        self.motion.joints()
    }

    fn read(&self, visit: Visit<'_>) -> ReadResult {
        let mut path = self.torque.path();
        self.motion.read(&mut |trajectory, block| {
            let tau = Some(self.torque.over(&path.follow(trajectory, block))?);
            visit(trajectory, &Motion::new(Signals { tau, ..block.clone().into_signals() })?)
        })
    }
}
