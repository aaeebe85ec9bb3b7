//! From places in dots to marks: lines, dots, rings and rectangles in their colours.

use crate::error::ReportError;
use crate::figure::DOTS;
use crate::figure::words::{Area, drawing};
use crate::html::Mark;
use crate::palette::PAPER;
use plotters::element::{Circle, DashedPathElement, PathElement, Rectangle};
use plotters::style::{Color, RGBColor, ShapeStyle};

/// A place on an area, in dots.
pub(crate) type Dot = (i32, i32);

const THIN: u32 = 3;
const BROAD: u32 = 10;
const DASH: i32 = 6 * DOTS;
const GAP: i32 = 4 * DOTS;
/// Dashes of a line, at most about: each is an element of its own.
const MOST_DASHES: i32 = 500;
/// Half the width of the cap of an error bar.
const CAP: i32 = 4 * DOTS;

/// Radii of dots.
const CLOUD: i32 = 3;
const KNOT: i32 = 7;
const RING: i32 = 9;
const LONELY: i32 = 5;

/// What a mark joins its points with; nothing for marks without a line.
pub(crate) fn line(
    area: &Area<'_>,
    mark: Mark,
    colour: RGBColor,
    places: Vec<Dot>,
) -> Result<(), ReportError> {
    match mark {
        Mark::Cloud | Mark::Rings | Mark::Bars => Ok(()),
        // A point between two gaps.
        _ if places.len() == 1 => dot(area, places[0], LONELY, colour.filled()),
        Mark::DashedLine => dashed(area, colour, DASH, places),
        Mark::BroadLine => path(area, colour.stroke_width(BROAD), places),
        Mark::Line | Mark::DottedLine => path(area, colour.stroke_width(THIN), places),
    }
}

/// What a mark puts at a point; nothing for plain lines.
pub(crate) fn point(
    area: &Area<'_>,
    mark: Mark,
    colour: RGBColor,
    place: Dot,
) -> Result<(), ReportError> {
    match mark {
        Mark::DottedLine => dot(area, place, KNOT, colour.filled()),
        Mark::Cloud => dot(area, place, CLOUD, colour.mix(0.55).filled()),
        Mark::Rings => {
            dot(area, place, RING, PAPER.filled())?;
            dot(area, place, RING, colour.stroke_width(4))
        }
        _ => Ok(()),
    }
}

/// A bar between two corners.
pub(crate) fn bar(area: &Area<'_>, colour: RGBColor, corners: [Dot; 2]) -> Result<(), ReportError> {
    rectangle(area, colour.mix(0.8).filled(), corners)
}

/// A tint between two corners.
pub(crate) fn tint(
    area: &Area<'_>,
    colour: RGBColor,
    corners: [Dot; 2],
) -> Result<(), ReportError> {
    rectangle(area, colour.mix(0.25).filled(), corners)
}

/// An error bar from one height to another, with a cap at each end that has one.
pub(crate) fn error_bar(
    area: &Area<'_>,
    colour: RGBColor,
    ends: [Dot; 2],
    has_cap: [bool; 2],
) -> Result<(), ReportError> {
    let style = colour.stroke_width(2);
    path(area, style, ends.to_vec())?;
    for ((x, y), _) in ends.into_iter().zip(has_cap).filter(|(_, has_cap)| *has_cap) {
        path(area, style, vec![(x - CAP, y), (x + CAP, y)])?;
    }
    Ok(())
}

/// A dashed line as thin as the grid.
pub(crate) fn guide(area: &Area<'_>, colour: RGBColor, ends: [Dot; 2]) -> Result<(), ReportError> {
    let style = colour.stroke_width(2);
    let dashes = DashedPathElement::new(ends, 5 * DOTS, 4 * DOTS, style);
    area.draw(&dashes).map_err(drawing)
}

fn dashed(
    area: &Area<'_>,
    colour: RGBColor,
    dash: i32,
    places: Vec<Dot>,
) -> Result<(), ReportError> {
    let steps = places.windows(2).map(|pair| {
        let [(x, y), (next_x, next_y)] = [pair[0], pair[1]];
        (next_x - x).abs().max((next_y - y).abs())
    });
    let length: i32 = steps.sum();
    // A line that winds a lot would need thousands.
    let dash = dash.max(length / MOST_DASHES);
    let style = colour.stroke_width(THIN);
    area.draw(&DashedPathElement::new(places, dash, GAP, style)).map_err(drawing)
}

fn path(area: &Area<'_>, style: ShapeStyle, places: Vec<Dot>) -> Result<(), ReportError> {
    area.draw(&PathElement::new(places, style)).map_err(drawing)
}

fn dot(area: &Area<'_>, at: Dot, radius: i32, style: ShapeStyle) -> Result<(), ReportError> {
    area.draw(&Circle::new(at, radius, style)).map_err(drawing)
}

fn rectangle(area: &Area<'_>, style: ShapeStyle, corners: [Dot; 2]) -> Result<(), ReportError> {
    area.draw(&Rectangle::new(corners, style)).map_err(drawing)
}
