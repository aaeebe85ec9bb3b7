//! The links of a rigid chain, ready to give their torque, whole or in parts.

use crate::{Kind, RigidChain};
use torquewise_motion::Motion;
use torquewise_rigid::recursion::MOST_JOINTS;
use torquewise_rigid::{Kinematics, MotionState};

/// Rigid links, moved by the recursion.
#[derive(Clone, Debug)]
pub(crate) struct Links {
    pub(crate) kinematics: Kinematics,
    weightless: Kinematics,
    pub(crate) inertial: Vec<f64>,
}

impl Links {
    /// The links of a chain; `None` where its geometry is none.
    pub(crate) fn of(chain: &RigidChain) -> Option<Self> {
        let kinematics = Kinematics::new(&chain.axes().ok()?);
        let weightless = kinematics.clone().without_gravity();
        let inertial = chain.inertial();
        let fits = chain.n_joints() <= MOST_JOINTS && kinematics.n_joints() == chain.n_joints();
        fits.then_some(Self { kinematics, weightless, inertial })
    }

    /// Adds the torque of the links at one state \[N·m\], n, whole or a part of it.
    pub(crate) fn add_torque(
        &self,
        part: Option<Kind>,
        state: MotionState<'_, f64>,
        torque: &mut [f64],
    ) {
        let n = torque.len();
        let rest = &[0.0; MOST_JOINTS][..n];
        let (kinematics, state) = match part {
            None => (&self.kinematics, state),
            Some(Kind::Gravity) => (&self.kinematics, MotionState { dq: rest, ddq: rest, ..state }),
            Some(Kind::Coriolis) => (&self.weightless, MotionState { ddq: rest, ..state }),
            Some(Kind::Inertia) => (&self.weightless, MotionState { dq: rest, ..state }),
            Some(Kind::Friction) => return,
        };
        let mut own = [0.0; MOST_JOINTS];
        kinematics.torque(state, &self.inertial, &mut own[..n]);
        torque.iter_mut().zip(own).for_each(|(torque, own)| *torque += own);
    }

    /// Hands over the parts of the torque at each row of a motion: row, joint, part, \[N·m\].
    pub(crate) fn visit_parts(
        &self,
        motion: &Motion,
        mut put: impl FnMut(usize, usize, Kind, f64),
    ) {
        let (q, dq, ddq) = (motion.q(), motion.dq(), motion.ddq());
        let parts = [
            (Kind::Gravity, &self.kinematics, [Some(q), None, None]),
            (Kind::Coriolis, &self.weightless, [Some(q), Some(dq), None]),
            (Kind::Inertia, &self.weightless, [Some(q), None, Some(ddq)]),
        ];
        for (kind, kinematics, signals) in parts {
            kinematics.torques(signals, &self.inertial, |row, joint, torque| {
                put(row, joint, kind, torque);
            });
        }
    }
}
