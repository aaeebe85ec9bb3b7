//! One HTML text of tables, charts and equations: opened anywhere, printed, kept.
//!
//! A [`Page`] is plain data; [`Page::to_html`] writes it. The text holds its style and its script,
//! asks for nothing over the network, follows the light or dark theme of its reader and fits wide
//! and narrow screens and paper. All words and numbers are escaped, whoever wrote them.
//!
//! ```
//! use torquewise_report::html::{Axis, Chart, Item, Page, Section, Series};
//!
//! let decay = (0..50).map(|k| [0.1 * f64::from(k), (-0.1 * f64::from(k)).exp()]).collect();
//! let chart = Chart {
//!     title: "A decay".into(),
//!     x: Axis::named("time [s]"),
//!     y: Axis::named("torque [N·m]"),
//!     series: vec![Series::line("measured", decay)],
//!     ..Chart::default()
//! };
//! let section = Section { heading: "Torque".into(), items: vec![Item::Charts(vec![chart])] };
//! let page = Page { title: "A test".into(), sections: vec![section], ..Page::default() };
//! assert!(page.to_html()?.starts_with("<!doctype html>"));
//! # Ok::<(), torquewise_report::ReportError>(())
//! ```

pub mod colour;
pub mod number;
pub mod markup;
pub mod equation;
pub mod chart;
pub mod thin;
mod spec;
pub mod table;
pub mod bars;
pub mod skeleton;
pub mod item;
pub mod page;

pub use bars::Bars;
pub use chart::{Axis, Chart, Guide, Mark, Series, Stretches};
pub use colour::Colour;
pub use item::{Item, Tone};
pub use markup::Label;
pub use page::{Page, Section};
pub use table::{Heading, Table};
pub use thin::Growing;
