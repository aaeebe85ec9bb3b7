//! Axes and motion of a chain, for the script of a page.

use serde::Serialize;

/// Axes of joints that a motion turns, drawn in space.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Skeleton {
    /// Joint names, base to tip, n.
    pub joints: Vec<String>,
    /// The frame of each joint in the one before, at zero; it turns about its z or slides along it, n.
    pub frames: Vec<BodyFrame>,
    /// Whether the log tells where each axis lies, n; others are dashed.
    pub resolved: Vec<bool>,
    /// Whether each joint slides, n.
    pub slides: Vec<bool>,
    /// Direction of gravity in the base.
    pub gravity: [f64; 3],
    /// Time of each row \[s\], at least two rows.
    pub t: Vec<f64>,
    /// Joint positions of each row \[rad, m\], m×n.
    pub q: Vec<Vec<f64>>,
}

/// A frame in the frame before it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct BodyFrame {
    /// Its origin \[m\].
    pub origin: [f64; 3],
    /// Turns its components into those of the frame before, row by row.
    pub rotation: [f64; 9],
}
