//! From words to lines: how they look, how much room they take, and where they are broken.

use crate::error::ReportError;
use crate::figure::DOTS;
use crate::palette::FONT;
use plotters::backend::SVGBackend;
use plotters::coord::Shift;
use plotters::drawing::DrawingArea;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{IntoFont, RGBColor, TextStyle};

/// Part of a page, measured from its upper left corner.
pub(crate) type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// Size of numbers and names, in pixels.
pub(crate) const SMALL: i32 = 12;

/// Words of a size in pixels; the position is the place of their `h` and `v`.
pub(crate) fn style(size: i32, colour: RGBColor, h: HPos, v: VPos) -> TextStyle<'static> {
    // The library makes letters smaller by this factor.
    let font = (FONT, 1.24 * f64::from(size * DOTS)).into_font();
    font.color(&colour).pos(Pos::new(h, v))
}

/// About the width of a text: the letters of an unknown font.
pub(crate) fn width(text: &str, size: i32) -> i32 {
    let letters = i32::try_from(text.chars().count()).unwrap_or(i32::MAX).min(10_000);
    letters * size * DOTS * 11 / 20
}

/// From one line to the next.
pub(crate) fn line_height(size: i32) -> i32 {
    size * DOTS * 13 / 10
}

/// Height of some lines.
pub(crate) fn height_of(lines: &[String], size: i32) -> i32 {
    i32::try_from(lines.len()).unwrap_or(1_000).min(1_000) * line_height(size)
}

/// A text broken between words where it is longer than `room`.
pub(crate) fn wrapped(text: &str, size: i32, room: i32) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if width(line, size) + width(word, size) + size <= room => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

/// Writes lines of a size below each other, the first at `at`.
pub(crate) fn write(
    area: &Area<'_>,
    lines: &[String],
    size: i32,
    style: &TextStyle<'_>,
    at: (i32, i32),
) -> Result<(), ReportError> {
    let mut y = at.1;
    for line in lines {
        area.draw_text(line, style, (at.0, y)).map_err(drawing)?;
        y += line_height(size);
    }
    Ok(())
}

/// The drawing library's own error, in words.
pub(crate) fn drawing(error: impl std::fmt::Display) -> ReportError {
    ReportError::Drawing { reason: error.to_string() }
}
