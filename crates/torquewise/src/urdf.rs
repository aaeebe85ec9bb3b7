//! What a fit takes from the URDF of an arm.

use crate::Result;
use torquewise_identify::plan::KnownGeometry;
use torquewise_model::{LinkFrame, RobotNames};
use torquewise_sim::{UrdfChain, UrdfJoint};

/// Where the axes of the joints of a log lie, by the URDF of its arm: for
/// [`crate::FitOptions::geometry`].
///
/// Joints go by name; where the URDF has none of the names, they are taken in its order. Those that
/// the log does not have are held at 0, and their links welded to the one before.
///
/// - `joints`: those of the log, base to tip, as [`crate::Log::joints`] has them
/// - `locked`: joints that are held at 0, where names do not tell
/// - `gravity`: where things fall in the frame of the base, of any length; −z without
///
/// # Errors
/// `Error::Arm`, with what to change in the file, the names or the order of the joints.
///
/// ```no_run
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// use torquewise::{Fit, FitOptions, Log};
///
/// let log = Log::open("train.csv")?;
/// let text = std::fs::read_to_string("robot.urdf")?;
/// let geometry = Some(torquewise::urdf::known_geometry(&text, log.joints(), &[], None)?);
/// let options = FitOptions { geometry, ..FitOptions::default() };
/// let fit = Fit::new(&log).options(options).run()?;
/// # Ok(())
/// # }
/// ```
pub fn known_geometry(
    text: &str,
    joints: &[String],
    locked: &[String],
    gravity: Option<[f64; 3]>,
) -> Result<KnownGeometry> {
    let chain = UrdfChain::of_joints(text, joints, locked, gravity)?;
    let first = |links: &[String]| links.first().cloned().unwrap_or_default();
    let robot = RobotNames {
        robot: chain.name.clone(),
        base: first(&chain.base),
        joints: chain.joints.iter().map(|joint| joint.name.clone()).collect(),
        links: chain.joints.iter().map(|joint| first(&joint.links)).collect(),
        frames: chain.joints.iter().map(frame).collect(),
    };
    let (geometry, base) = (chain.geometry.clone(), chain.base_of_geometry);
    Ok(KnownGeometry { geometry, robot: Some(robot), base })
}

fn frame(joint: &UrdfJoint) -> LinkFrame {
    let placement = joint.frame();
    let rotation = [0, 1, 2].map(|i| [0, 1, 2].map(|j| placement.rotation[(i, j)]));
    LinkFrame { rotation, origin: placement.origin.into() }
}
