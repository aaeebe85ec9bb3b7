//! Bars on the terminal that show what is done and how far it is.

use indicatif::{ProgressBar, ProgressFinish, ProgressState, ProgressStyle};
use std::cell::RefCell;
use std::ops::ControlFlow;
use std::time::Duration;
use torquewise::Event;

pub(crate) fn watch() -> impl Fn(Event) -> ControlFlow<()> {
    let shown = RefCell::new(bar("reading"));
    move |event| {
        match event {
            Event::Reading { doing, rows } => *shown.borrow_mut() = reading(doing, rows),
            Event::Stage(stage) => shown.borrow().set_message(stage.to_string()),
            Event::Rows(rows) => shown.borrow().inc(rows as u64),
        }
        ControlFlow::Continue(())
    }
}

/// A bar with the rate and the time left, where it is known how many rows there are.
fn reading(doing: &str, rows: Option<u64>) -> ProgressBar {
    let bar = bar(doing);
    if let Some(rows) = rows {
        bar.set_length(rows);
        let template = "{spinner} {msg} {wide_bar} {percent} %, {per_sec}, {eta} left";
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style.with_key("per_sec", rate));
        }
    }
    bar
}

fn rate(state: &ProgressState, out: &mut dyn std::fmt::Write) {
    // A bar that cannot be written to is none.
    let _ = write!(out, "{:.0} rows/s", state.per_sec());
}

/// A bar for rows of which nobody knows how many there are.
fn bar(doing: &str) -> ProgressBar {
    let bar = shown(ProgressBar::no_length(), "{spinner} {msg}: {human_pos} rows, {elapsed}");
    bar.set_message(doing.to_owned());
    bar
}

pub(crate) fn share_bar() -> ProgressBar {
    shown(ProgressBar::new(1), "{spinner} {msg} {wide_bar} {percent} %, {elapsed}, {eta} left")
}

/// A bar on stderr, gone when it is done; indicatif hides it where that is no terminal.
fn shown(bar: ProgressBar, template: &str) -> ProgressBar {
    let bar = bar.with_finish(ProgressFinish::AndClear);
    if let Ok(style) = ProgressStyle::with_template(template) {
        bar.set_style(style);
    }
    if !bar.is_hidden() {
        bar.enable_steady_tick(Duration::from_millis(100));
    }
    bar
}
