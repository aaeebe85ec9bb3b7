//! Reports, read as text and opened in a real browser.

mod arm;
mod browser;
mod call_cost;
mod chromium;
mod friction;
