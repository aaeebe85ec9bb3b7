//! Figures and reports of motions and reconstructed torque models, each returned as one text.
//!
//! [`fit_report()`] tells all about a fit; [`html`] is the kit it is made with; [`chart_figure`] draws
//! charts by themselves, as a picture that does not move.
//!
//! Nothing here touches a file or rasterises a font: a figure is SVG whose words stay words, in the
//! sans-serif font of whoever looks at it, so that it can be saved, or pasted into a page.

pub mod error;
pub mod html;
#[cfg(not(target_family = "wasm"))]
mod still;
pub mod orders;
mod torques;
pub mod fit_report;

pub use error::{ReportError, Result};
pub(crate) use fit_report::clock::Clock;
pub use fit_report::clock::pattern_bands;
pub use fit_report::origin::{LogFile, Origin};
pub use fit_report::{Findings, fit_report};
pub(crate) use html::markup::{safe, script_json};
pub use html::number::{count, significant};
pub use html::{
    Axis, Bars, Chart, Colour, Guide, Heading, Item, Label, Mark, Section, Series, Stretches,
    Table, Tone,
};
pub use orders::order_charts;
#[cfg(not(target_family = "wasm"))]
pub use still::chart_figure;
pub use torques::torque_charts;
