//! Bars on the terminal that show what is done and how far it is.

use indicatif::{ProgressBar, ProgressFinish, ProgressState, ProgressStyle};
use std::ops::ControlFlow;
use std::sync::{Mutex, PoisonError};
use std::time::Duration;
use torquewise::{Event, Progress};

/// Shows each stage with a bar of its own: how far it is and the time left where that is known, else
/// the time it took so far.
pub(crate) fn watch() -> impl Fn(Event) -> ControlFlow<()> + Sync {
    let shown = Mutex::new(Shown { bar: stage("reading"), rows: None });
    move |event| {
        shown.lock().unwrap_or_else(PoisonError::into_inner).show(event);
        ControlFlow::Continue(())
    }
}

struct Shown {
    bar: ProgressBar,
    /// Rows of a pass, where that is known.
    rows: Option<u64>,
}

impl Shown {
    fn show(&mut self, event: Event) {
        match event {
            Event::Stage(Progress::Working) => {}
            Event::Reading { doing, rows } => (self.bar, self.rows) = (stage(doing), rows),
            Event::Stage(told) => {
                self.bar = stage(&told.to_string());
                if let Some((done, most)) = told.share() {
                    self.measure(most as u64, "{spinner} {msg} {wide_bar}");
                    self.bar.set_position(done as u64);
                }
            }
            Event::Rows(rows) => {
                if let Some(all) = self.rows.filter(|all| self.bar.length() != Some(*all)) {
                    self.measure(
                        all,
                        "{spinner} {msg} {wide_bar} {percent} %, {per_sec}, {eta} left",
                    );
                }
                self.bar.inc(rows as u64);
            }
        }
    }

    fn measure(&self, length: u64, template: &str) {
        self.bar.set_length(length);
        if let Ok(style) = ProgressStyle::with_template(template) {
            let rate = |state: &ProgressState, out: &mut dyn std::fmt::Write| {
                // A bar that cannot be written to is none.
                let _ = write!(out, "{:.0} rows/s", state.per_sec());
            };
            self.bar.set_style(style.with_key("per_sec", rate));
        }
    }
}

/// What is done, where nobody knows how long it takes.
fn stage(doing: &str) -> ProgressBar {
    shown(ProgressBar::no_length(), "{spinner} {msg}, {elapsed}").with_message(doing.to_owned())
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
