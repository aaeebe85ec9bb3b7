//! The joints of a URDF that move, base to tip, and the links that hang on them.
#![expect(non_snake_case, reason = "frames are written quantity_fromTo, as in `spatial`")]

use crate::arm::{STANDARD_GRAVITY, check_finite};
use crate::urdf::robot::{Joint, Robot};
use crate::urdf::tree::{Hinge, Tree, WeldedLink};
use crate::{Body, Pose, Result, SimError, placement, pose};
use torquewise_rigid::inertia::is_feasible;
use torquewise_rigid::{Geometry, JointKind, PER_BODY, Placement};

/// Where the axes of an arm lie, as its URDF says it, with its masses where they can be.
///
/// It gives a fit the geometry that would else be searched, and takes back what was found of the
/// links in the frames of the file.
#[derive(Clone, Debug)]
pub struct UrdfChain {
    /// What the robot is called.
    pub name: String,
    /// The links that do not move.
    pub base: Vec<String>,
    /// The joints that move, base to tip, n.
    pub joints: Vec<UrdfJoint>,
    /// Where their axes lie.
    pub geometry: Geometry,
    /// Turns components in the base of the geometry into those in the base of the file, row by row.
    pub base_of_geometry: [[f64; 3]; 3],
}

/// A joint of a [`UrdfChain`].
#[derive(Clone, Debug)]
pub struct UrdfJoint {
    /// Its name.
    pub name: String,
    /// The link that it turns, then those that are welded to it.
    pub links: Vec<String>,
    /// Inertial parameters of these links together, as the file has them, in the frame of the
    /// geometry; `None` where it has none that can be.
    pub inertial_of_file: Option<[f64; PER_BODY]>,
    /// The frame of the geometry in that of the first link.
    X_LG: Pose,
    /// Bodies of the file that are welded to the first link, in its frame; those whose joint could
    /// move, then those whose joint is fixed.
    welded: Vec<WeldedLink>,
}

impl UrdfChain {
    /// The chain of the named joints: all others are locked. Where the file has none of the names,
    /// as of a log whose columns have numbers alone, joints are taken in the order of the file, but
    /// for those to lock and those that mimic others.
    ///
    /// - `gravity`: where things fall in the frame of the base, of any length; −z without
    ///
    /// # Errors
    /// As [`crate::Arm::from_urdf`], but for masses; [`SimError::UnknownJoints`] if some of the names
    /// are not joints, [`SimError::JointOrder`] if they do not follow each other from base to tip.
    pub fn of_joints(
        text: &str,
        joints: &[String],
        locked: &[String],
        gravity: Option<[f64; 3]>,
    ) -> Result<Self> {
        let robot = Robot::read(text)?;
        let known: Vec<String> = robot.joints.iter().map(|joint| joint.name.clone()).collect();
        let is_numbered = !joints.iter().any(|name| known.contains(name));
        let unknown = joints.iter().find(|name| !known.contains(name));
        if let Some(unknown) = unknown.filter(|_| !is_numbered) {
            let (unknown, known) = (unknown.clone(), known.join(", "));
            return Err(SimError::UnknownJoints { unknown, known });
        }
        // Of numbered joints, all but those to lock.
        let (listed, moving) = if is_numbered { (locked, false) } else { (joints, true) };
        let moves = |name: &String| listed.contains(name) == moving;
        let chain = Self::of(&robot, moves, locked, gravity)?;
        let expected: Vec<String> = chain.joints.iter().map(|joint| joint.name.clone()).collect();
        if expected == joints || is_numbered && expected.len() == joints.len() {
            return Ok(chain);
        }
        let (expected, found) = (expected.join(", "), joints.join(", "));
        Err(if is_numbered {
            SimError::UnknownJoints { unknown: found, known: expected }
        } else {
            SimError::JointOrder { expected, found }
        })
    }

    fn of(
        robot: &Robot,
        moves: impl Fn(&String) -> bool,
        named: &[String],
        gravity: Option<[f64; 3]>,
    ) -> Result<Self> {
        let mut locked = named.to_vec();
        for Joint { name, kind, mimics, .. } in &robot.joints {
            if *kind != "fixed" && (*mimics || !moves(name)) && !named.contains(name) {
                locked.push(name.clone());
            }
        }
        let (base, chain) = Tree::new(robot, &locked)?.chain()?;
        if chain.is_empty() {
            return Err(SimError::NoJoints);
        }
        let gravity = gravity.unwrap_or(STANDARD_GRAVITY);
        check_finite("gravity", &robot.name, &gravity)?;
        if gravity.iter().all(|g| *g == 0.0) {
            return Err(SimError::NoDirection { what: "gravity".into() });
        }
        let kinds: Vec<JointKind> = chain.iter().map(|hinge| hinge.joint.moves()).collect();
        let placements: Vec<_> = chain.iter().map(|hinge| placement(&hinge.X_PJ)).collect();
        let first = placements[0].rotation;
        let base_of_geometry = [0, 1, 2].map(|i| [0, 1, 2].map(|j| first[(i, j)]));
        let (geometry, frames) = Geometry::of_joints(&placements, &kinds.into(), gravity);
        let joint = |(Hinge { joint, X_LJ, after, .. }, frame): (Hinge<'_>, Placement)| {
            let (X_LG, name) = (X_LJ * pose(&frame), joint.name.clone());
            let X_GL = X_LG.inverse();
            let of_file = after.body().ok().map(|body| body.inertial_parameters());
            let seen = of_file.map(|own| Body::of_parameters(&own).seen_from(&X_GL));
            let inertial_of_file = seen.map(|body| body.inertial_parameters());
            let inertial_of_file = inertial_of_file.filter(|own| is_feasible(own));
            let (links, welded) = (after.names().collect(), after.others().collect());
            UrdfJoint { name, links, inertial_of_file, X_LG, welded }
        };
        let joints = chain.into_iter().zip(frames).map(joint).collect();
        let (name, base) = (robot.name.clone(), base.names().collect());
        Ok(Self { name, base, joints, geometry, base_of_geometry })
    }
}

impl UrdfJoint {
    /// The frame of the geometry in that of the link.
    pub fn frame(&self) -> Placement {
        placement(&self.X_LG)
    }

    /// A body shared out among the links that are welded together: what is to be changed of each, and
    /// whether all others keep what they have. They do where what is left for the first is a body;
    /// else those whose joint could move do; else the first carries all.
    ///
    /// - `inertial`: m, m·c, and the moments about the origin, as [`torquewise_rigid::recursion`] has
    ///   them, in the frame of the geometry
    pub fn distributed(&self, inertial: &[f64; PER_BODY]) -> (Vec<(String, Option<Body>)>, bool) {
        let whole = Body::of_parameters(inertial).seen_from(&self.X_LG);
        let others = &self.welded;
        let stays: [&dyn Fn(&WeldedLink) -> bool; 3] =
            [&|_| true, &|link| !link.is_fixed, &|_| false];
        for stay in stays {
            let kept = others.iter().filter(|link| stay(link)).filter_map(|link| link.body);
            let kept = kept.fold(Body::default(), |sum, body| sum.welded_to(&body));
            let rest = whole.without(&kept);
            let is_last = !others.iter().any(stay);
            if !(is_last || is_feasible(&rest.inertial_parameters())) {
                continue;
            }
            let first = self.links.first().cloned().unwrap_or_default();
            let mut changes = vec![(first, Some(rest))];
            let emptied = others.iter().filter(|link| !stay(link));
            changes.extend(emptied.map(|link| (link.name.clone(), None)));
            let all_stay = changes.len() == 1;
            return (changes, all_stay);
        }
        (Vec::new(), true)
    }
}
