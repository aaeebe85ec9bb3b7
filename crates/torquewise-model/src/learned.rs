//! What was learned of an arm, as tables: where its axes lie, its links, its rotors and springs.

use crate::error::ModelError;
use crate::model::{GeometryFound, Model, Training};
use crate::print::with_error;
use crate::rigid_chain::{Drive, JointKind, RigidChain};
use crate::selection::Selection;
use crate::shaft_friction::Estimated;
use serde::Serialize;
use torquewise_rigid::base_parameters::base_parameters;
use torquewise_rigid::recursion::PER_BODY;

/// Rows of cells under headings.
pub type Table = Vec<Vec<String>>;

/// For what a log does not determine.
const DASH: &str = "–";
/// A parameter with a larger part of it uncertain is not determined.
const LEAST_T: f64 = 2.0;

/// An axis at q = 0, in a frame at the base with z up, against gravity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axis {
    /// A point on it \[m\].
    pub point: [f64; 3],
    /// Its direction, a unit vector.
    pub direction: [f64; 3],
}

/// The axes of a chain at q = 0, base to tip, in a frame with its origin on the first and z up.
///
/// # Errors
/// [`ModelError::Chain`] if its geometry is none.
pub fn axes(chain: &RigidChain) -> Result<Vec<Axis>, ModelError> {
    let frames = chain.axes()?.upright();
    let axis = |(direction, point): ([f64; 3], [f64; 3])| Axis { point, direction };
    Ok(frames.into_iter().map(axis).collect())
}

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
    /// Distance of both as lines \[m\]; none of the first, nor where one of them slides.
    pub distance_to_previous_m: Option<Estimated>,
    /// Whether the log tells where it lies: the search found it often enough, its torque on held-out
    /// rows is followed, no other right angle does nearly as well, and its distance is certain.
    pub resolved: bool,
}

/// A distance \[m\] that is less certain is not resolved.
const RESOLVED: f64 = 0.1;

/// Where the axes of the chain of a model lie; nothing of a model without one.
///
/// # Errors
/// As [`axes`].
pub fn joint_geometry(model: &Model) -> Result<Vec<JointGeometry>, ModelError> {
    let Some(chain) = &model.chain else { return Ok(Vec::new()) };
    let lines = axes(chain)?;
    let found = model.training.geometry_found.as_ref();
    let errors = model.training.held_out_errors().unwrap_or_default();
    let of = |(joint, axis): (usize, &Axis)| -> Result<JointGeometry, ModelError> {
        let relative = |of: fn(&Axis, &Axis) -> f64| -> Result<Option<Estimated>, ModelError> {
            let Some(before) = joint.checked_sub(1) else { return Ok(None) };
            let value = of(&lines[before], axis).abs();
            let std_error = geometry_error(chain, |axes| of(&axes[before], &axes[joint]))?;
            Ok(Some(Estimated { value, std_error }))
        };
        // A slide has a direction alone, and no place.
        let has_distance = chain.kinds.of(joint).turns()
            && joint.checked_sub(1).is_none_or(|before| chain.kinds.of(before).turns());
        let distance_to_previous_m = if has_distance { relative(distance)? } else { None };
        let is_found = found.is_none_or(GeometryFound::is_certain);
        let is_named = found.is_some_and(|found| found.unresolved.contains(&joint));
        let is_followed = errors.get(joint).is_none_or(|error| *error < Training::POOR);
        let is_near = distance_to_previous_m.is_none_or(|found| found.std_error < RESOLVED);
        Ok(JointGeometry {
            joint: model.joints[joint].clone(),
            kind: chain.kinds.of(joint).name(),
            axis: axis.direction,
            point: axis.point,
            angle_to_previous_deg: relative(angle)?,
            distance_to_previous_m,
            resolved: is_found && !is_named && is_followed && is_near,
        })
    };
    lines.iter().enumerate().map(of).collect()
}

/// The same as a table.
///
/// # Errors
/// As [`axes`].
pub fn geometry(model: &Model, selection: &Selection) -> Result<Table, ModelError> {
    let headings = [
        "joint",
        "axis at q = 0 (x y z)",
        "through (x y z) [m]",
        "angle to axis before [°]",
        "distance from it [m]",
        "",
    ];
    let mut table = vec![headings.map(str::to_owned).to_vec()];
    for (joint, found) in joint_geometry(model)?.into_iter().enumerate() {
        if !selection.has_joint(joint) {
            continue;
        }
        let relative = |measured: Option<Estimated>| match measured {
            None => DASH.to_owned(),
            Some(Estimated { value, std_error }) if std_error < 1e-12 => {
                format!("{}", (1e6 * value).round() / 1e6)
            }
            Some(Estimated { value, std_error }) => with_error(value, std_error),
        };
        let triple = |triple: [f64; 3]| {
            // No minus before what rounds to zero.
            triple.map(|x| format!("{:.3}", if x.abs() < 5e-4 { 0.0 } else { x })).join(" ")
        };
        let slides = (found.kind == JointKind::Prismatic.name()).then_some("slides");
        let open = (!found.resolved).then_some("not resolved");
        let note: Vec<&str> = slides.into_iter().chain(open).collect();
        let point = if slides.is_some() { DASH.to_owned() } else { triple(found.point) };
        table.push(vec![
            found.joint,
            triple(found.axis),
            point,
            relative(found.angle_to_previous_deg),
            relative(found.distance_to_previous_m),
            note.join(", "),
        ]);
    }
    Ok(table)
}

/// Angle between two axes \[°\].
fn angle(a: &Axis, b: &Axis) -> f64 {
    let across = norm(cross(a.direction, b.direction));
    across.atan2(dot(a.direction, b.direction)).to_degrees()
}

/// Distance of two axes as lines \[m\], with a sign where they are not parallel.
fn distance(a: &Axis, b: &Axis) -> f64 {
    let between = [0, 1, 2].map(|k| b.point[k] - a.point[k]);
    let normal = cross(a.direction, b.direction);
    if norm(normal) > PARALLEL {
        dot(between, normal) / norm(normal)
    } else {
        norm(cross(between, a.direction))
    }
}

/// Sine of the angle below which two axes are parallel.
const PARALLEL: f64 = 1e-6;

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn norm(a: [f64; 3]) -> f64 {
    dot(a, a).sqrt()
}

fn cross([a, b, c]: [f64; 3], [x, y, z]: [f64; 3]) -> [f64; 3] {
    [b * z - c * y, c * x - a * z, a * y - b * x]
}

/// Step of a difference by a parameter of the geometry \[rad, m\].
const STEP: f64 = 1e-6;

/// Standard error of a function of the axes; zero where they are exact.
fn geometry_error(chain: &RigidChain, of: impl Fn(&[Axis]) -> f64) -> Result<f64, ModelError> {
    let before = chain.covariance.len().saturating_sub(chain.fitted.len());
    let mut weights = vec![0.0; chain.covariance.len()];
    for (&parameter, weight) in chain.fitted.iter().zip(weights.iter_mut().skip(before)) {
        let at = |step: f64| {
            let mut moved = chain.clone();
            moved.geometry[parameter] += step;
            axes(&moved).map(|axes| of(&axes))
        };
        *weight = (at(STEP)? - at(-STEP)?) / (2.0 * STEP);
    }
    Ok(chain.variance_of(&weights).sqrt())
}

/// What torque determines of the links (Gautier and Khalil): first moments across the axis
/// \[kg·m\] and moments about the origin of the joint \[kg·m²\], the rest counted into the link
/// before, and of a slide its mass; a dash where they cannot be told from zero.
///
/// # Errors
/// As [`axes`].
pub fn links(
    chain: &RigidChain,
    joints: &[String],
    selection: &Selection,
) -> Result<Table, ModelError> {
    const OF_TURNS: [(usize, &str); 7] =
        [(1, "m·x"), (2, "m·y"), (4, "Ixx-Iyy"), (6, "Izz"), (7, "Ixy"), (8, "Ixz"), (9, "Iyz")];
    const OF_SLIDES: [(usize, &str); 2] = [(0, "m"), (3, "m·z")];
    let slides = if chain.kinds.all_turn() { &[][..] } else { &OF_SLIDES[..] };
    let cells: Vec<(usize, &str)> = slides.iter().chain(&OF_TURNS).copied().collect();
    let axes = chain.axes()?;
    let inertial = chain.inertial();
    let base = base_parameters(&axes, &inertial);
    // The map is linear: its columns are what unit parameters come to.
    let columns: Vec<Vec<f64>> = (0..inertial.len())
        .map(|k| {
            let unit: Vec<f64> = (0..inertial.len()).map(|j| f64::from(u8::from(j == k))).collect();
            base_parameters(&axes, &unit)
        })
        .collect();
    let names = cells.iter().map(|(_, name)| (*name).to_owned());
    let mut table: Table = vec![std::iter::once("link".to_owned()).chain(names).collect()];
    for (joint, name) in joints.iter().enumerate().filter(|(joint, _)| selection.has_joint(*joint))
    {
        let cell = |&(k, _): &(usize, &str)| {
            let at = PER_BODY * joint + k;
            let mut weights: Vec<f64> = columns.iter().map(|column| column[at]).collect();
            weights.resize(chain.covariance.len(), 0.0);
            shown(base[at], chain.variance_of(&weights).sqrt(), selection)
        };
        table.push(std::iter::once(name.clone()).chain(cells.iter().map(cell)).collect());
    }
    Ok(table)
}

/// A value with its error; a dash where it does not differ from zero significantly.
fn shown(value: f64, error: f64, selection: &Selection) -> String {
    let is_resolved = error > 0.0 && value.abs() >= LEAST_T * error;
    if is_resolved || selection.all { with_error(value, error) } else { DASH.to_owned() }
}

/// Rotors and springs; headings alone where there are none.
pub fn drives(chain: &RigidChain, joints: &[String], selection: &Selection) -> Table {
    let mut table = vec![vec!["on".to_owned(), "what".to_owned(), "value".to_owned()]];
    for (k, drive) in chain.drives.iter().enumerate() {
        let error = std_error(chain, PER_BODY * chain.links.len() + k);
        let (on, what, value) = match drive {
            Drive::Rotor { shaft, inertia } => {
                let turned = joints.iter().zip(shaft).filter(|(_, share)| **share != 0.0);
                let on: Vec<&str> = turned.map(|(name, _)| name.as_str()).collect();
                let slides =
                    shaft.iter().enumerate().any(|(k, s)| *s != 0.0 && chain.kinds.slides(k));
                let what = if slides { "rotor as a mass [kg]" } else { "rotor inertia [kg·m²]" };
                (on.join(", "), what.to_owned(), *inertia)
            }
            Drive::Energy { term, coefficient } => {
                (term.place.name(), term.function.name(), *coefficient)
            }
        };
        table.push(vec![on, what, shown(value, error, selection)]);
    }
    table
}

fn std_error(chain: &RigidChain, parameter: usize) -> f64 {
    let variance = chain.covariance.get(parameter).and_then(|row| row.get(parameter));
    variance.map_or(0.0, |variance| variance.max(0.0).sqrt())
}

/// Letters across and lines down a drawing.
const DRAWING: [usize; 2] = [36, 14];

/// The axes at q = 0 seen from the front (x to the right, z up) and from the side (y to the right):
/// numbers are the joints, dots the links between them, and strokes lie along the axes.
///
/// # Errors
/// As [`axes`].
pub fn drawing(chain: &RigidChain) -> Result<String, ModelError> {
    let axes = axes(chain)?;
    let [x, y, z] = [0, 1, 2].map(|k| {
        let [low, high] = range(&axes, k);
        (high - low).max(1e-3)
    });
    let scale = ((DRAWING[1] as f64 - 5.0) / z).min((0.5 * DRAWING[0] as f64 - 3.0) / x.max(y));
    let views = [[0, 2], [1, 2]].map(|view| view_of(&axes, view, scale));
    let [front, side] = &views;
    let width = DRAWING[0];
    let mut text = format!("{:<width$}    {}\n", "front: x right, z up", "side: y right, z up");
    for (left, right) in front.iter().zip(side) {
        let [left, right]: [String; 2] = [left, right].map(|line| line.iter().collect());
        text.push_str(format!("{left:<width$}    {right}").trim_end());
        text.push('\n');
    }
    Ok(text)
}

/// The least and the greatest of a coordinate.
fn range(axes: &[Axis], k: usize) -> [f64; 2] {
    let values = axes.iter().map(|axis| axis.point[k]);
    values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)])
}

/// One view as letters: `view` names the coordinates that go right and up.
///
/// - `scale`: lines per metre; a letter is twice as high as it is wide
fn view_of(axes: &[Axis], view: [usize; 2], scale: f64) -> Vec<Vec<char>> {
    let [width, height] = DRAWING;
    let seen = |vector: [f64; 3]| view.map(|k| vector[k]);
    let middle = view.map(|k| {
        let [low, high] = range(axes, k);
        0.5 * (low + high)
    });
    let mut grid = vec![vec![' '; width]; height];
    let mut put = |[x, z]: [f64; 2], letter: char| {
        let column = cell(0.5 * width as f64 + 2.0 * scale * (x - middle[0]));
        let row = cell(0.5 * height as f64 - scale * (z - middle[1]));
        let found = row.and_then(|row| grid.get_mut(row)).zip(column);
        if let Some(cell) = found.and_then(|(line, column)| line.get_mut(column)) {
            *cell = letter;
        }
    };
    let between =
        |a: [f64; 2], b: [f64; 2], t: f64| [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])];
    for pair in axes.windows(2) {
        let ends = [seen(pair[0].point), seen(pair[1].point)];
        (0..=60).for_each(|k| put(between(ends[0], ends[1], f64::from(k) / 60.0), '·'));
    }
    for axis in axes {
        let ([x, z], [dx, dz]) = (seen(axis.point), seen(axis.direction));
        let letter = match (dx.abs(), dz.abs()) {
            (dx, dz) if dx.max(dz) < 0.4 => 'o',
            (dx, dz) if dx < 0.4 * dz => '|',
            (dx, dz) if dz < 0.4 * dx => '-',
            _ if dx * dz > 0.0 => '/',
            _ => '\\',
        };
        if letter != 'o' {
            for step in [-2.0, -1.0, 1.0, 2.0] {
                put([x + step * dx / scale, z + step * dz / scale], letter);
            }
        }
    }
    for (axis, number) in axes.iter().zip(('1'..='9').cycle()) {
        put(seen(axis.point), number);
    }
    grid
}

/// The cell that a place lies in, if it is not before the first.
fn cell(place: f64) -> Option<usize> {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a place within or beyond a small grid"
    )]
    let cell = place.round() as usize;
    (place > -0.5).then_some(cell)
}
