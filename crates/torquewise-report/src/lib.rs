//! Figures and reports of motions and reconstructed torque models, each returned as one text.
//!
//! [`fit_report()`] tells all about a fit; [`html`] is the kit it is made with, [`mathml`] its
//! equations; [`chart_figure`] draws charts by themselves, [`torque_figure`] those of torques.
//!
//! Nothing here touches a file or rasterises a font: a figure is SVG whose words stay words, in the
//! sans-serif font of whoever looks at it, so that it can be saved, or pasted into a page.
//!
//! ```
//! use faer::Mat;
//! use torquewise_report::torque_figure;
//!
//! let t = [0.0, 0.1, 0.2];
//! let measured = Mat::from_fn(3, 1, |row, _| row as f64);
//! let predicted = Mat::from_fn(3, 1, |row, _| 1.1 * row as f64);
//!
//! let joints = ["shoulder".to_owned()];
//! let predictions = [("model", predicted.as_ref())];
//! let figure = torque_figure("A test", &joints, &t, measured.as_ref(), &predictions)?;
//! assert!(figure.starts_with("<svg") && figure.contains("shoulder"));
//! # Ok::<(), torquewise_report::ReportError>(())
//! ```

pub mod error;
mod palette;
pub mod html;
pub mod figure;
pub mod torque;
pub mod mathml;
pub mod orders;
pub mod fit_report;

pub use error::ReportError;
pub use figure::chart_figure;
pub use fit_report::call_cost::CallCost;
pub use fit_report::origin::{LogFile, Origin};
pub use fit_report::{Findings, fit_report};
pub use orders::order_charts;
pub use torque::torque_figure;
