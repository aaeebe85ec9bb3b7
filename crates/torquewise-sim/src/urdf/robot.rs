//! The links and joints of a URDF, as far as the motion of an arm depends on them.

use crate::{Body, Pose, Result, SimError, shifted_turned};
use roxmltree::{Document, Node};
use torquewise_rigid::JointKind;

pub(crate) struct Robot {
    pub(crate) name: String,
    pub(crate) links: Vec<Link>,
    pub(crate) joints: Vec<Joint>,
}

pub(crate) struct Link {
    pub(crate) name: String,
    /// Its body, about a centre of mass at zero, and the frame of that.
    pub(crate) inertial: Option<(Body, Pose)>,
}

pub(crate) struct Joint {
    pub(crate) name: String,
    pub(crate) kind: &'static str,
    pub(crate) parent: String,
    pub(crate) child: String,
    pub(crate) origin: Pose,
    pub(crate) axis: [f64; 3],
    /// Range \[rad, m\]; zeros where none is given.
    pub(crate) range: [f64; 2],
    /// Greatest speed \[rad/s, m/s\] and acceleration \[rad/s²\]; zero or infinity where none is given.
    pub(crate) peaks: [f64; 2],
    /// Inertia of its rotor as felt at the joint \[kg·m²\]; zero where none is given.
    pub(crate) rotor: f64,
    pub(crate) mimics: bool,
}

/// What a URDF has beside the kinds of joints; `continuous` is a revolute joint without limits.
const OTHER_KINDS: [&str; 5] = ["continuous", "fixed", "floating", "planar", "spherical"];

impl Robot {
    /// Reads the text of a URDF; elements that say nothing of links and joints are passed over.
    pub(crate) fn read(text: &str) -> Result<Self> {
        let document = Document::parse(text).map_err(|source| SimError::Urdf { source })?;
        let root = document.root_element();
        if root.tag_name().name() != "robot" {
            return Err(refused(root, "is not <robot>"));
        }
        let link = |link| -> Result<Link> {
            let inertial = child(link, "inertial").map(inertial).transpose()?;
            Ok(Link { name: attribute(link, "name")?, inertial })
        };
        Ok(Self {
            name: attribute(root, "name")?,
            links: children(root, "link").map(link).collect::<Result<_, _>>()?,
            joints: children(root, "joint").map(Joint::read).collect::<Result<_, _>>()?,
        })
    }
}

fn inertial(inertial: Node<'_, '_>) -> Result<(Body, Pose)> {
    let inertia = required(inertial, "inertia")?;
    let mut moments = [0.0; 6];
    for (moment, name) in moments.iter_mut().zip(["ixx", "iyy", "izz", "ixy", "ixz", "iyz"]) {
        [*moment] = numbers(inertia, name, None)?;
    }
    let [mass] = numbers(required(inertial, "mass")?, "value", None)?;
    Ok((Body::new(mass, [0.0; 3], moments), origin(inertial)?))
}

fn origin(element: Node<'_, '_>) -> Result<Pose> {
    let Some(origin) = child(element, "origin") else { return Ok(Pose::identity()) };
    let [xyz, rpy] = ["xyz", "rpy"].map(|name| numbers(origin, name, Some([0.0; 3])));
    Ok(shifted_turned(xyz?, rpy?))
}

impl Joint {
    /// How it moves, if it does.
    pub(crate) fn moves(&self) -> JointKind {
        JointKind::named(self.kind).unwrap_or_default()
    }

    fn read(joint: Node<'_, '_>) -> Result<Self> {
        let written = attribute(joint, "type")?;
        let other = || OTHER_KINDS.into_iter().find(|kind| *kind == written);
        let kind = JointKind::named(&written).map(|kind| kind.name).or_else(other);
        let link = |name| attribute(required(joint, name)?, "link");
        let number = |tag, name, none: f64| {
            let given = child(joint, tag).map(|element| numbers(element, name, Some([none])));
            given.map_or(Ok(none), |given| given.map(|[number]| number))
        };
        let limit = |name, none| number("limit", name, none);
        Ok(Self {
            name: attribute(joint, "name")?,
            kind: kind.ok_or_else(|| refused(joint, "has a type that no joint has"))?,
            parent: link("parent")?,
            child: link("child")?,
            origin: origin(joint)?,
            axis: child(joint, "axis")
                .map_or(Ok([1.0, 0.0, 0.0]), |axis| numbers(axis, "xyz", None))?,
            range: [limit("lower", 0.0)?, limit("upper", 0.0)?],
            peaks: [limit("velocity", 0.0)?, limit("acceleration", f64::INFINITY)?],
            rotor: number("dynamics", "armature", 0.0)?,
            mimics: child(joint, "mimic").is_some(),
        })
    }
}

fn children<'a, 'i>(parent: Node<'a, 'i>, tag: &'static str) -> impl Iterator<Item = Node<'a, 'i>> {
    parent.children().filter(move |node| node.has_tag_name(tag))
}

fn child<'a, 'i>(parent: Node<'a, 'i>, name: &'static str) -> Option<Node<'a, 'i>> {
    children(parent, name).next()
}

fn required<'a, 'i>(parent: Node<'a, 'i>, name: &'static str) -> Result<Node<'a, 'i>> {
    child(parent, name).ok_or_else(|| refused(parent, &format!("has no <{name}>")))
}

fn attribute(element: Node<'_, '_>, name: &str) -> Result<String> {
    let value = element.attribute(name).map(str::to_owned);
    value.ok_or_else(|| refused(element, &format!("has no {name}")))
}

/// Numbers of an attribute, with blanks between them; `default` where it is missing.
fn numbers<const N: usize>(
    element: Node<'_, '_>,
    name: &str,
    default: Option<[f64; N]>,
) -> Result<[f64; N]> {
    if let (None, Some(default)) = (element.attribute(name), default) {
        return Ok(default);
    }
    let text = attribute(element, name)?;
    let numbers: Option<Vec<f64>> = text.split_whitespace().map(|x| x.parse().ok()).collect();
    numbers
        .and_then(|numbers| numbers.try_into().ok())
        .ok_or_else(|| refused(element, &format!("has {name}=\"{text}\", expected {N} numbers")))
}

fn refused(element: Node<'_, '_>, what: &str) -> SimError {
    let at = element.document().text_pos_at(element.range().start);
    let element = element.tag_name().name().to_owned();
    SimError::UrdfElement { line: at.row, element, what: what.to_owned() }
}
