//! The tree of links and joints of a URDF: which links move as one, and the joint that leaves them.
#![expect(non_snake_case, reason = "frames are written quantity_fromTo, as in `spatial`")]

use crate::arm::{check_body, check_finite, direction};
use crate::spatial::with_z_along;
use crate::urdf::robot::{Joint, Link, Robot};
use crate::{Body, Pose, Result, SimError};
use std::collections::{HashMap, HashSet};

/// A URDF that is one tree: names resolved, one root, no loop.
pub(crate) struct Tree<'a> {
    links: HashMap<&'a str, &'a Link>,
    below: HashMap<&'a str, Vec<&'a Joint>>,
    root: &'a str,
    locked: HashSet<&'a str>,
}

/// Links that move as one body, and the moving joints that leave it.
pub(crate) struct Welded<'a> {
    /// Each link and its frame, and whether all joints between it and the first are fixed.
    pub(crate) links: Vec<(&'a Link, Pose, bool)>,
    exits: Vec<(&'a Joint, Pose)>,
}

/// A link of a file that is welded to another.
#[derive(Clone, Debug)]
pub(crate) struct WeldedLink {
    pub(crate) name: String,
    /// In the frame of the first link; `None` where the file has no body that can be.
    pub(crate) body: Option<Body>,
    /// Whether its joint is fixed, rather than locked.
    pub(crate) is_fixed: bool,
}

/// A joint that moves, and what hangs on it.
pub(crate) struct Hinge<'a> {
    pub(crate) joint: &'a Joint,
    /// Its frame, turned so that z is the axis, in that of the joint before and in that of its link.
    pub(crate) X_PJ: Pose,
    pub(crate) X_LJ: Pose,
    pub(crate) after: Welded<'a>,
}

impl<'a> Tree<'a> {
    /// Resolves names and checks that the joints make one tree and that those left unlocked turn or slide.
    pub(crate) fn new(robot: &'a Robot, locked: &'a [String]) -> Result<Self> {
        let links = by_name("link", robot.links.iter().map(|link| (link.name.as_str(), link)))?;
        let joints = by_name("joint", robot.joints.iter().map(|j| (j.name.as_str(), j)))?;
        if let Some(unknown) = locked.iter().find(|name| !joints.contains_key(name.as_str())) {
            let moving = robot.joints.iter().filter(|j| j.kind != "fixed");
            let known = moving.map(|j| j.name.as_str()).collect::<Vec<_>>().join(", ");
            return Err(SimError::UnknownJoint { what: "a lock", joint: unknown.clone(), known });
        }

        let root = only_root(robot, &links)?;
        let mut below: HashMap<&str, Vec<&Joint>> = HashMap::new();
        for joint in &robot.joints {
            below.entry(joint.parent.as_str()).or_default().push(joint);
        }
        let locked = locked.iter().map(String::as_str).collect();
        let tree = Self { links, below, root, locked };
        let joints = tree.all_below(tree.joints_below(tree.root).to_vec());
        let children = joints.iter().map(|joint| joint.child.as_str());
        let reached: HashSet<&str> = children.chain([tree.root]).collect();
        if let Some(link) = robot.links.iter().find(|link| !reached.contains(link.name.as_str())) {
            return Err(SimError::Loop { link: link.name.clone() });
        }
        let unsupported = |joint: &Joint| {
            let why = match joint.kind {
                "floating" | "planar" | "spherical" => Some(joint.kind),
                _ => joint.mimics.then_some("mimic"),
            };
            Some(format!("`{}` ({})", joint.name, why.filter(|_| tree.moves(joint))?))
        };
        let unsupported: Vec<String> = robot.joints.iter().filter_map(unsupported).collect();
        let refused = || SimError::UnsupportedJoints { joints: unsupported.join(", ") };
        unsupported.is_empty().then_some(tree).ok_or_else(refused)
    }

    fn welded(&self, first: &'a str) -> Result<Welded<'a>> {
        let (mut links, mut exits) = (Vec::new(), Vec::new());
        let mut open = vec![(first, Pose::identity(), true)];
        while let Some((link, X_GL, is_fixed)) = open.pop() {
            links.extend(self.links.get(link).map(|&link| (link, X_GL, is_fixed)));
            for &joint in self.joints_below(link) {
                let X_GJ = X_GL * checked(&joint.name, joint.origin)?;
                if self.moves(joint) {
                    exits.push((joint, X_GJ));
                } else {
                    open.push((joint.child.as_str(), X_GJ, is_fixed && joint.kind == "fixed"));
                }
            }
        }
        Ok(Welded { links, exits })
    }

    fn only_exit(&self, welded: &Welded<'a>) -> Result<Option<(&'a Joint, Pose)>> {
        if welded.exits.len() < 2 {
            return Ok(welded.exits.first().copied());
        }
        let moving_from = |joint: &'a Joint| -> Vec<&'a str> {
            let below = self.all_below(vec![joint]).into_iter();
            below.filter(|joint| self.moves(joint)).map(|joint| joint.name.as_str()).collect()
        };
        let mut branches: Vec<Vec<&str>> =
            welded.exits.iter().map(|(joint, _)| moving_from(joint)).collect();
        // The branch with the most joints is taken for the arm.
        branches.sort_by_key(|names| std::cmp::Reverse(names.len()));
        let lock = branches[1..].concat().join(", ");
        let link = welded.names().next().unwrap_or_default();
        Err(SimError::Branches { link, lock })
    }

    /// What does not move, then each joint base to tip.
    pub(crate) fn chain(&self) -> Result<(Welded<'a>, Vec<Hinge<'a>>)> {
        let base = self.welded(self.root)?;
        let (mut exit, mut joints) = (self.only_exit(&base)?, Vec::new());
        let mut X_PL = Pose::identity();
        while let Some((joint, X_LL)) = exit {
            let after = self.welded(&joint.child)?;
            exit = self.only_exit(&after)?;
            let X_LJ = with_z_along(&direction(&joint.name, joint.axis)?);
            joints.push(Hinge { joint, X_PJ: X_PL * X_LL * X_LJ, X_LJ, after });
            X_PL = X_LJ.inverse();
        }
        Ok((base, joints))
    }

    fn joints_below(&self, link: &str) -> &[&'a Joint] {
        self.below.get(link).map_or(&[], Vec::as_slice)
    }

    fn moves(&self, joint: &Joint) -> bool {
        joint.kind != "fixed" && !self.locked.contains(joint.name.as_str())
    }

    /// All joints that hang on some, and these.
    fn all_below(&self, mut open: Vec<&'a Joint>) -> Vec<&'a Joint> {
        let mut all = Vec::new();
        while let Some(joint) = open.pop() {
            all.push(joint);
            open.extend(self.joints_below(&joint.child));
        }
        all
    }
}

impl Welded<'_> {
    pub(crate) fn names(&self) -> impl Iterator<Item = String> {
        self.links.iter().map(|(link, ..)| link.name.clone())
    }

    /// Links with a body beside the first.
    pub(crate) fn others(&self) -> impl Iterator<Item = WeldedLink> {
        let with_body = self.links.iter().skip(1).filter(|(link, ..)| link.inertial.is_some());
        with_body.map(|(link, X_GL, is_fixed)| {
            let body = body_of(link).ok().map(|body| body.seen_from(X_GL));
            WeldedLink { name: link.name.clone(), body, is_fixed: *is_fixed }
        })
    }

    pub(crate) fn body(&self) -> Result<Body> {
        self.links.iter().try_fold(Body::default(), |sum, (link, X_GL, _)| {
            Ok(sum.welded_to(&body_of(link)?.seen_from(X_GL)))
        })
    }
}

/// Looks up by name; refuses a name that comes twice.
fn by_name<'a, T>(
    kind: &'static str,
    items: impl Iterator<Item = (&'a str, &'a T)>,
) -> Result<HashMap<&'a str, &'a T>> {
    let mut found = HashMap::new();
    for (name, item) in items {
        if found.insert(name, item).is_some() {
            return Err(SimError::DuplicateName { kind, name: name.into() });
        }
    }
    Ok(found)
}

/// The link without parent joint, after checking that every joint hangs between known links.
fn only_root<'a>(robot: &'a Robot, links: &HashMap<&str, &Link>) -> Result<&'a str> {
    let mut parents: HashMap<&str, &Joint> = HashMap::new();
    for joint in &robot.joints {
        for link in [&joint.parent, &joint.child] {
            if !links.contains_key(link.as_str()) {
                let (joint, link) = (joint.name.clone(), link.clone());
                return Err(SimError::UnknownLink { joint, link });
            }
        }
        if let Some(first) = parents.insert(&joint.child, joint) {
            let (first, second) = (first.name.clone(), joint.name.clone());
            return Err(SimError::TwoParents { link: joint.child.clone(), first, second });
        }
    }
    let names = robot.links.iter().map(|link| link.name.as_str());
    let roots: Vec<&str> = names.filter(|name| !parents.contains_key(name)).collect();
    match roots[..] {
        [root] => Ok(root),
        _ => Err(SimError::Roots { roots: roots.into_iter().map(String::from).collect() }),
    }
}

/// Mass of a link in the link's frame; a link without `<inertial>` has none.
fn body_of(link: &Link) -> Result<Body> {
    let Some((body, origin)) = &link.inertial else { return Ok(Body::default()) };
    check_body(&link.name, body)?;
    Ok(body.seen_from(&checked(&link.name, *origin)?))
}

fn checked(name: &str, origin: Pose) -> Result<Pose> {
    check_finite("origin", name, origin.to_matrix().as_slice()).map(|()| origin)
}
