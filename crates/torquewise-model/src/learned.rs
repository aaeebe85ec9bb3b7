//! What was learned of an arm, as tables: where its axes lie, its links, its rotors and springs.

use crate::error::ModelError;
use crate::print::with_error;
use crate::rigid_chain::{Drive, RigidChain};
use crate::selection::Selection;
use torquewise_rigid::geometry::{PER_BASE, PER_JOINT};
use torquewise_rigid::recursion::PER_BODY;

/// Rows of cells under headings.
pub type Table = Vec<Vec<String>>;

/// For what a log does not determine.
const DASH: &str = "–";
/// A parameter with a larger part of it uncertain is not determined.
const LEAST_T: f64 = 2.0;

/// An axis at q = 0, in the frame of the base.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axis {
    /// A point on it \[m\].
    pub point: [f64; 3],
    /// Its direction, a unit vector.
    pub direction: [f64; 3],
}

/// The axes of a chain at q = 0, base to tip: the base has its z along the first.
///
/// # Errors
/// [`ModelError::Chain`] if its geometry is none.
pub fn axes(chain: &RigidChain) -> Result<Vec<Axis>, ModelError> {
    let placements = chain.axes()?.placements();
    let mut axes: Vec<Axis> = Vec::with_capacity(placements.len());
    let mut frame: Option<(_, _)> = None;
    for placement in placements {
        let (rotation, origin) = match frame {
            None => (placement.rotation, placement.origin),
            Some((rotation, origin)) => {
                (rotation * placement.rotation, origin + rotation * placement.origin)
            }
        };
        axes.push(Axis { point: origin.into(), direction: rotation.column(2).into_owned().into() });
        frame = Some((rotation, origin));
    }
    Ok(axes)
}

/// Where the axes lie, and each in respect of the one before, with standard errors where it was
/// fitted rather than put to a right angle or onto the axis before.
///
/// # Errors
/// As [`axes`].
pub fn geometry(
    chain: &RigidChain,
    joints: &[String],
    selection: &Selection,
) -> Result<Table, ModelError> {
    let geometry = chain.axes()?;
    let headings = [
        "joint",
        "axis at q = 0 (x y z)",
        "through (x y z) [m]",
        "angle to axis before [°]",
        "distance [m]",
    ];
    let mut table = vec![headings.map(str::to_owned).to_vec()];
    for (joint, (name, axis)) in joints.iter().zip(axes(chain)?).enumerate() {
        if !selection.has_joint(joint) {
            continue;
        }
        let first = (PER_BASE + PER_JOINT * joint).saturating_sub(PER_JOINT);
        let of = |pair: [f64; 2], from: usize, unit: f64| {
            let size = pair[0].hypot(pair[1]);
            match geometry_error(chain, from, pair, size) {
                0.0 => format!("{}", (1e6 * unit * size).round() / 1e6),
                error => with_error(unit * size, unit * error),
            }
        };
        let relative = if joint == 0 {
            [DASH.to_owned(), DASH.to_owned()]
        } else {
            [
                of(geometry.direction(joint), first, 180.0 / std::f64::consts::PI),
                of(geometry.place(joint), first + 2, 1.0),
            ]
        };
        let [angle, distance] = relative;
        let triple = |[x, y, z]: [f64; 3]| {
            // No minus before what rounds to zero.
            let shown = [x, y, z].map(|x| format!("{:.3}", if x.abs() < 5e-4 { 0.0 } else { x }));
            shown.join(" ")
        };
        let place = [triple(axis.direction), triple(axis.point)];
        let [direction, point] = place;
        table.push(vec![name.clone(), direction, point, angle, distance]);
    }
    Ok(table)
}

/// Standard error of the length of a pair of parameters of the geometry; zero where they are exact.
fn geometry_error(chain: &RigidChain, first: usize, pair: [f64; 2], size: f64) -> f64 {
    let before = chain.covariance.len().saturating_sub(chain.fitted.len());
    let mut weights = vec![0.0; chain.covariance.len()];
    for (k, value) in pair.into_iter().enumerate() {
        let place = chain.fitted.iter().position(|&fitted| fitted == first + k);
        if let Some(weight) = place.and_then(|place| weights.get_mut(before + place)) {
            *weight = if size > 0.0 { value / size } else { 1.0 };
        }
    }
    chain.variance_of(&weights).sqrt()
}

/// Mass, first moments and moments of inertia of each link about the origin of its frame, where the
/// log determines them; only sums of several may be determined where these are not.
pub fn links(chain: &RigidChain, joints: &[String], selection: &Selection) -> Table {
    let names = ["m", "m·x", "m·y", "m·z", "Ixx", "Iyy", "Izz", "Ixy", "Ixz", "Iyz"];
    let mut table: Table = vec![std::iter::once("link").chain(names).map(str::to_owned).collect()];
    for (joint, (name, link)) in joints.iter().zip(&chain.links).enumerate() {
        if !selection.has_joint(joint) {
            continue;
        }
        let cell = |(k, &value): (usize, &f64)| {
            let error = std_error(chain, PER_BODY * joint + k);
            let is_known = error > 0.0 && value.abs() >= LEAST_T * error || selection.all;
            if is_known { with_error(value, error) } else { DASH.to_owned() }
        };
        let cells = link.iter().enumerate().map(cell);
        table.push(std::iter::once(name.clone()).chain(cells).collect());
    }
    table
}

/// Rotors and springs; headings alone where there are none.
pub fn drives(chain: &RigidChain, joints: &[String]) -> Table {
    let mut table = vec![vec!["on".to_owned(), "what".to_owned(), "value".to_owned()]];
    for (k, drive) in chain.drives.iter().enumerate() {
        let error = std_error(chain, PER_BODY * chain.links.len() + k);
        let (on, what, value) = match drive {
            Drive::Rotor { shaft, inertia } => {
                let turned = joints.iter().zip(shaft).filter(|(_, share)| **share != 0.0);
                let on: Vec<&str> = turned.map(|(name, _)| name.as_str()).collect();
                (on.join(", "), "rotor inertia [kg·m²]".to_owned(), *inertia)
            }
            Drive::Energy { term, coefficient } => {
                (term.place.name(), term.function.name(), *coefficient)
            }
        };
        table.push(vec![on, what, with_error(value, error)]);
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
