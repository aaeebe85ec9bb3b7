//! From role to colour and font: one look for all figures, and the light theme of the page.

use plotters::style::RGBColor;

/// The generic name, which each viewer fills with its own font.
pub(crate) const FONT: &str = "sans-serif";

/// Titles and names.
pub(crate) const INK: RGBColor = RGBColor(31, 41, 55);
/// Numbers and units at the axes.
pub(crate) const FADED_INK: RGBColor = RGBColor(107, 114, 128);
/// Lines behind the curves.
pub(crate) const GRID: RGBColor = RGBColor(229, 231, 235);
/// The page.
pub(crate) const PAPER: RGBColor = RGBColor(255, 255, 255);

/// What was measured: pale, so that a curve on top of it can be told from it.
pub(crate) const MEASURED: RGBColor = RGBColor(178, 186, 197);

/// Colours of M. Okabe and K. Ito, told apart by colour-blind eyes too.
pub(crate) const SERIES: [RGBColor; 6] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
];
