//! An arm from the text of a URDF: the serial chain left when the locked joints are welded.

mod chain;
pub mod edit;
mod robot;
mod tree;

use crate::arm::{Joint, STANDARD_GRAVITY, motion_range};
use crate::{Arm, JointLimits, Result};
use robot::Robot;
use tree::{Hinge, Tree};

pub use chain::{UrdfChain, UrdfJoint};

impl Arm {
    /// Reads an arm from URDF text, its base fixed in the world, gravity −9.81 m/s² along z.
    ///
    /// Revolute, continuous and prismatic joints move. Fixed joints and the joints named in `locked` (held at
    /// position 0, whatever their type) weld their links together: no mass is lost. Limits of a
    /// joint become the range of simulated motions and its [`Arm::limits`], the attribute `armature`
    /// of its dynamics its rotor; damping and friction are not read.
    ///
    /// # Errors
    /// `SimError::Urdf` and its neighbours if the text is no URDF;
    /// `SimError::UnsupportedJoints` for moving planar, floating, spherical or
    /// mimic joints and `SimError::Branches` for a tree, both with the joints to lock;
    /// otherwise the variant that names the link, joint or number at fault.
    pub fn from_urdf(text: &str, locked: &[String]) -> Result<Self> {
        let robot = Robot::read(text)?;
        let (base, chain) = Tree::new(&robot, locked)?.chain()?;
        // The base does not move, its mass must be one all the same.
        base.body()?;
        let mut joints = Vec::with_capacity(chain.len());
        for Hinge { joint, X_PJ, X_LJ, after } in chain {
            let range = if joint.kind == "continuous" { [0.0, 0.0] } else { joint.range };
            let [velocity, acceleration] = joint.peaks;
            let kind = joint.moves();
            let body = after.body()?.seen_from(&X_LJ.inverse());
            let limits = JointLimits::new(range, velocity, acceleration);
            let range = motion_range(kind, range);
            let moved = Joint { X_PJ, kind, body, rotor: joint.rotor, range, limits };
            joints.push((joint.name.clone(), moved));
        }
        Self::new(robot.name.clone(), STANDARD_GRAVITY, joints)
    }
}

#[cfg(test)]
pub(crate) mod tests;
