//! What was learned of an arm, as tables: where its axes lie, its links, its rotors and springs.

use crate::print::{DASH, with_error};
use crate::selection::Selection;
use crate::shaft_friction::Estimated;
use crate::{Drive, GeometryFound, LEAST_T, Model, ModelError, RigidChain, Training};
use faer::Mat;
use serde::Serialize;
use torquewise_rigid::base_parameters::base_parameters;
use torquewise_rigid::{PER_BODY, Placement};

/// Where an axis lies at q = 0, and how in respect of the one before.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct JointGeometry {
    /// Name of the joint.
    pub joint: String,
    /// What it does: `revolute` or `prismatic`.
    pub kind: &'static str,
    /// Its direction, a unit vector, in a frame at the base with z up.
    pub axis: [f64; 3],
    /// A point on it \[m\].
    pub point: [f64; 3],
    /// Angle to the axis before \[°\], certain where it was put to a right angle; none of the first.
    pub angle_to_previous_deg: Option<Estimated>,
    /// Distance of both as lines \[m\]; for axes within 6° of parallel, that of the point of the axis
    /// before from this axis. None of the first, nor where one of them slides.
    pub distance_to_previous_m: Option<Estimated>,
    /// Distance \[m\], along the axis before, of the places where this one and the last one that is not
    /// parallel to it come nearest to it: the length of a link whose axes meet. None where there is no
    /// such axis, this one is within 6° of parallel to the axis before, or one from there on slides.
    pub along_previous_m: Option<Estimated>,
    /// Whether the log tells where it lies: the search found it often enough, its torque on held-out
    /// rows is followed, no other right angle does nearly as well, and its distances are certain.
    pub resolved: bool,
}

/// What is more certain \[m, °\] was given, or found without noise: rounding is all its error.
const GIVEN: f64 = 1e-6;
/// A distance \[m\] that is less certain is not resolved.
const RESOLVED: f64 = 0.1;

/// Where the axes of the chain of a model lie; nothing of a model without one.
///
/// # Errors
/// [`ModelError::Chain`] if its geometry is none.
pub fn joint_geometry(model: &Model) -> Result<Vec<JointGeometry>, ModelError> {
    let Some(chain) = &model.chain else { return Ok(Vec::new()) };
    let lines = chain.axes()?.upright();
    let found = model.training.geometry_found.as_ref();
    let errors = model.training.held_out_errors().unwrap_or_default();
    let of = |(joint, axis): (usize, &Placement)| -> Result<JointGeometry, ModelError> {
        let measured = |of: &dyn Fn(&[Placement]) -> f64| -> Result<Option<Estimated>, ModelError> {
            let std_error = geometry_error(chain, of)?;
            Ok(Some(Estimated { value: of(&lines).abs(), std_error }))
        };
        let relative = |of: fn(&Placement, &Placement) -> f64| match joint.checked_sub(1) {
            None => Ok(None),
            Some(before) => measured(&|axes| of(&axes[before], &axes[joint])),
        };
        // A slide has a direction alone, and no place.
        let turns = |joint: usize| chain.kinds.of(joint).turns();
        let has_distance = turns(joint) && joint.checked_sub(1).is_none_or(turns);
        let distance_to_previous_m = if has_distance { relative(distance)? } else { None };
        let before = joint.saturating_sub(1);
        let is_across = |k: &usize| lines[*k].axis().cross(&lines[before].axis()).norm() > NEARLY;
        let across = (0..before).rev().find(is_across).filter(|_| is_across(&joint));
        let along_previous_m = match across.filter(|&first| (first..=joint).all(turns)) {
            None => None,
            Some(first) => measured(&|axes| {
                foot(&axes[joint], &axes[before]) - foot(&axes[first], &axes[before])
            })?,
        };
        let is_found = found.is_none_or(GeometryFound::is_certain);
        let is_named = found.is_some_and(|found| found.unresolved.contains(&joint));
        let is_followed = errors.get(joint).is_none_or(|error| *error < Training::POOR);
        let is_near = [distance_to_previous_m, along_previous_m]
            .into_iter()
            .flatten()
            .all(|found| found.std_error < RESOLVED);
        let angle_to_previous_deg = relative(angle)?;
        let all = [angle_to_previous_deg, distance_to_previous_m, along_previous_m];
        let mut all = all.into_iter().flatten();
        let is_given = joint > 0 && found.is_none() && all.all(|own| own.std_error < GIVEN);
        Ok(JointGeometry {
            joint: model.joints[joint].clone(),
            kind: chain.kinds.of(joint).name,
            axis: axis.axis().into(),
            point: axis.origin.into(),
            angle_to_previous_deg,
            distance_to_previous_m,
            along_previous_m,
            resolved: is_given || is_found && !is_named && is_followed && is_near,
        })
    };
    lines.iter().enumerate().map(of).collect()
}

/// What errors do not count where an axis may lie elsewhere; nothing where none is named.
pub fn taken_as_found(model: &Model) -> Option<String> {
    let open = &model.training.geometry_found.as_ref()?.unresolved;
    let before = &model.joints[open.iter().min()?.saturating_sub(1)];
    let open: Vec<&str> = open.iter().map(|joint| model.joints[*joint].as_str()).collect();
    Some(format!(
        "The log does not tell where these axes point: {}. Errors of links, rotors and terms of {before} and \
         the joints beyond are those of the axes that were found, and they may be others.",
        open.join(", ")
    ))
}

/// The same as a table.
///
/// - `found`: what [`joint_geometry`] says of the model
pub fn geometry(model: &Model, found: &[JointGeometry], selection: &Selection) -> Vec<Vec<String>> {
    let headings = [
        "joint",
        "axis at q = 0 (x y z)",
        "through (x y z) [m]",
        "angle to axis before [°]",
        "distance from it [m]",
        "length along it [m]",
        "",
    ];
    let mut table = vec![headings.map(str::to_owned).to_vec()];
    for (joint, found) in found.iter().enumerate().filter(|(k, _)| selection.has_joint(*k)) {
        let relative = |measured: Option<Estimated>| match measured {
            None => DASH.to_owned(),
            Some(Estimated { value, std_error }) if std_error < GIVEN => {
                format!("{}", (1e6 * value).round() / 1e6)
            }
            Some(Estimated { value, std_error }) => with_error(value, std_error),
        };
        let triple = |triple: [f64; 3]| {
            // No minus before what rounds to zero.
            triple.map(|x| format!("{:.3}", if x.abs() < 5e-4 { 0.0 } else { x })).join(" ")
        };
        let slides = model.kinds().slides(joint).then_some("slides");
        let open = (!found.resolved).then_some("not resolved");
        let note: Vec<&str> = slides.into_iter().chain(open).collect();
        let point = if slides.is_some() { DASH.to_owned() } else { triple(found.point) };
        table.push(vec![
            found.joint.clone(),
            triple(found.axis),
            point,
            relative(found.angle_to_previous_deg),
            relative(found.distance_to_previous_m),
            relative(found.along_previous_m),
            note.join(", "),
        ]);
    }
    table
}

/// Angle between two axes \[°\].
fn angle(a: &Placement, b: &Placement) -> f64 {
    let (a, b) = (a.axis(), b.axis());
    a.cross(&b).norm().atan2(a.dot(&b)).to_degrees()
}

/// Distance of two axes as lines \[m\], with a sign where they are not parallel.
fn distance(a: &Placement, b: &Placement) -> f64 {
    let between = b.origin - a.origin;
    let normal = a.axis().cross(&b.axis());
    if normal.norm() > NEARLY {
        between.dot(&normal) / normal.norm()
    } else {
        between.cross(&b.axis()).norm()
    }
}

/// Where along `axis`, from the point that it is given by, another that is not parallel comes nearest
/// to it \[m\].
fn foot(other: &Placement, axis: &Placement) -> f64 {
    let between = other.origin - axis.origin;
    let (other, axis) = (other.axis(), axis.axis());
    let cos = other.dot(&axis);
    (between.dot(&axis) - cos * between.dot(&other)) / (1.0 - cos * cos)
}

/// Sine of the angle below which two axes are nearly parallel: where they come nearest to each other
/// says nothing, and may be far off.
const NEARLY: f64 = 0.1;

/// Step of a difference by a parameter of the geometry \[rad, m\].
const STEP: f64 = 1e-6;

/// Standard error of a function of the axes; zero where they are exact.
fn geometry_error(chain: &RigidChain, of: &dyn Fn(&[Placement]) -> f64) -> Result<f64, ModelError> {
    let before = chain.covariance_root.len().saturating_sub(chain.fitted.len());
    let mut weights = vec![0.0; chain.covariance_root.len()];
    for (&parameter, weight) in chain.fitted.iter().zip(weights.iter_mut().skip(before)) {
        let at = |step: f64| {
            let mut moved = chain.clone();
            moved.geometry[parameter] += step;
            moved.axes().map(|axes| of(&axes.upright()))
        };
        *weight = (at(STEP)? - at(-STEP)?) / (2.0 * STEP);
    }
    Ok(chain.std_error_of(&weights))
}

/// A number that torque determines of an arm.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ArmParameter {
    /// Joint whose link, rotor or spring it is of; several where they turn one shaft.
    pub joint: String,
    /// What it is: a first moment \[kg·m\], a moment of inertia \[kg·m²\], a mass \[kg\], the rotor,
    /// or the function of a spring.
    pub name: String,
    /// Its value.
    pub value: f64,
    /// Standard error; zero where it is not known.
    pub std_error: f64,
    /// Whether it can be told from zero.
    pub resolved: bool,
}

/// What torque determines of the links (Gautier and Khalil): first moments across the axis
/// \[kg·m\] and moments about the origin of the joint \[kg·m²\], the rest counted into the link
/// before, and of a slide its mass; a list for each joint.
fn link_parameters(
    chain: &RigidChain,
    joints: &[String],
) -> Result<Vec<Vec<ArmParameter>>, ModelError> {
    const OF_TURNS: [(usize, &str); 7] =
        [(1, "m·x"), (2, "m·y"), (4, "Ixx-Iyy"), (6, "Izz"), (7, "Ixy"), (8, "Ixz"), (9, "Iyz")];
    const OF_SLIDES: [(usize, &str); 2] = [(0, "m"), (3, "m·z")];
    let slides = if chain.kinds.all_turn() { &[][..] } else { &OF_SLIDES[..] };
    let cells: Vec<(usize, &str)> = slides.iter().chain(&OF_TURNS).copied().collect();
    let axes = chain.axes()?;
    let inertial = chain.inertial();
    let base = base_parameters(&axes, &inertial);
    // The map is linear: its columns are what unit parameters come to.
    let units = Mat::<f64>::identity(inertial.len(), inertial.len());
    let columns: Vec<Vec<f64>> =
        (0..inertial.len()).map(|k| base_parameters(&axes, units.col_as_slice(k))).collect();
    let of = |(joint, name): (usize, &String)| {
        let cell = |&(k, what): &(usize, &str)| {
            let at = PER_BODY * joint + k;
            let mut weights: Vec<f64> = columns.iter().map(|column| column[at]).collect();
            weights.resize(chain.covariance_root.len(), 0.0);
            ArmParameter::new(name, what, (base[at], chain.std_error_of(&weights)))
        };
        cells.iter().map(cell).collect()
    };
    Ok(joints.iter().enumerate().map(of).collect())
}

impl ArmParameter {
    fn new(joint: &str, name: &str, (value, std_error): (f64, f64)) -> Self {
        let resolved = std_error > 0.0 && value.abs() >= LEAST_T * std_error;
        Self { joint: joint.to_owned(), name: name.to_owned(), value, std_error, resolved }
    }

    /// Its value with its error; a dash where it cannot be told from zero.
    fn shown(&self, selection: &Selection) -> String {
        if self.resolved || selection.all {
            with_error(self.value, self.std_error)
        } else {
            DASH.to_owned()
        }
    }
}

/// What torque determines of the links as a table, a line for each link.
///
/// # Errors
/// As [`joint_geometry`].
pub fn links(
    chain: &RigidChain,
    joints: &[String],
    selection: &Selection,
) -> Result<Vec<Vec<String>>, ModelError> {
    let found = link_parameters(chain, joints)?;
    let names = found.first().into_iter().flatten().map(|own| own.name.clone());
    let mut table = vec![std::iter::once("link".to_owned()).chain(names).collect()];
    let chosen = joints.iter().zip(&found).enumerate();
    let chosen = chosen.filter(|(joint, _)| selection.has_joint(*joint));
    table.extend(chosen.map(|(_, (name, own))| {
        let cells = own.iter().map(|own| own.shown(selection));
        std::iter::once(name.clone()).chain(cells).collect()
    }));
    Ok(table)
}

/// What torque determines of the links, rotors and springs of a model; nothing of one without a chain.
///
/// # Errors
/// As [`joint_geometry`].
pub fn parameters(model: &Model) -> Result<Vec<ArmParameter>, ModelError> {
    let Some(chain) = &model.chain else { return Ok(Vec::new()) };
    let links = link_parameters(chain, &model.joints)?.into_iter().flatten();
    Ok(links.chain(drive_parameters(chain, &model.joints)).collect())
}

/// Rotors and springs.
fn drive_parameters(chain: &RigidChain, joints: &[String]) -> Vec<ArmParameter> {
    let of = |(k, drive): (usize, &Drive)| {
        let error = std_error(chain, PER_BODY * chain.links.len() + k);
        match drive {
            Drive::Rotor { shaft, inertia } => {
                let turned = joints.iter().zip(shaft).filter(|(_, share)| **share != 0.0);
                let on: Vec<&str> = turned.map(|(name, _)| name.as_str()).collect();
                let slides =
                    shaft.iter().enumerate().any(|(k, s)| *s != 0.0 && chain.kinds.slides(k));
                let what = if slides { "rotor as a mass [kg]" } else { "rotor inertia [kg·m²]" };
                ArmParameter::new(&on.join(", "), what, (*inertia, error))
            }
            Drive::Energy { term, coefficient } => {
                let (on, what) = (term.place.name(), term.function.name());
                ArmParameter::new(&on, &what, (*coefficient, error))
            }
        }
    };
    chain.drives.iter().enumerate().map(of).collect()
}

/// Rotors and springs as a table; headings alone where there are none.
pub fn drives(chain: &RigidChain, joints: &[String], selection: &Selection) -> Vec<Vec<String>> {
    let mut table = vec![vec!["on".to_owned(), "what".to_owned(), "value".to_owned()]];
    let all = drive_parameters(chain, joints);
    table.extend(
        all.iter().map(|own| vec![own.joint.clone(), own.name.clone(), own.shown(selection)]),
    );
    table
}

fn std_error(chain: &RigidChain, parameter: usize) -> f64 {
    let mut unit = vec![0.0; parameter + 1];
    unit[parameter] = 1.0;
    chain.std_error_of(&unit)
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;
    use std::f64::consts::FRAC_PI_2;

    #[test]
    fn a_length_along_an_axis_is_told_where_others_meet_it() {
        // Each axis in the frame before: across and met by it, 0.4 m along and 0.07 m off, parallel.
        let joints = [
            [FRAC_PI_2, 0.0, 0.0, 0.0],
            [-FRAC_PI_2, 0.0, 0.07, 0.4],
            [1e-3, 0.0, 0.1, 0.2],
            [FRAC_PI_2, 0.0, 0.0, 0.3],
        ];
        let geometry = [0.0, 0.0].into_iter().chain(joints.concat()).collect();
        let chain = RigidChain { geometry, links: vec![[1.0; 10]; 5], ..RigidChain::default() };
        let joints = ["a", "b", "c", "d", "e"].map(str::to_owned).to_vec();
        let model = Model { joints, chain: Some(chain), ..Model::default() };

        let found = joint_geometry(&model).unwrap();

        let lengths = found.iter().map(|own| own.along_previous_m.map(|length| length.value));
        let [None, None, Some(length), None, Some(across)] = lengths.collect::<Vec<_>>()[..] else {
            panic!("{found:?}")
        };
        // Past the parallel axis c: from the foot of b.
        assert_abs_diff_eq!(across, 0.3, epsilon = 1e-3);
        assert_abs_diff_eq!(length, 0.4, epsilon = 1e-12);
        let distance = |joint: usize| found[joint].distance_to_previous_m.unwrap().value;
        assert_abs_diff_eq!(distance(2), 0.07, epsilon = 1e-12);
        // Not where lines that are not quite parallel come nearest.
        assert_abs_diff_eq!(distance(3), 0.1_f64.hypot(0.2), epsilon = 1e-3);
    }
}
