//! Role → colour: the palette of the report on white paper.

use torquewise_motion::Pattern;
use torquewise_report::html::Colour;

/// Titles and names.
pub(crate) const INK: &str = "#1f2937";
/// Numbers and units at the axes.
pub(crate) const FADED: &str = "#6b7280";
/// Lines behind the curves.
pub(crate) const GRID: &str = "#e5e7eb";

const MEASURED: &str = "#b2bac5";
const SERIES: [&str; 6] = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9"];

/// The colour of a series.
pub(crate) fn hex(colour: Colour) -> &'static str {
    match colour {
        Colour::Measured => MEASURED,
        Colour::Series(place) => SERIES[place % SERIES.len()],
        Colour::Pattern(Pattern::Standstill) => SERIES[5],
        Colour::Pattern(Pattern::UniformVelocity) => SERIES[2],
        Colour::Pattern(Pattern::VariableVelocity) => SERIES[4],
        Colour::Faded => FADED,
    }
}
