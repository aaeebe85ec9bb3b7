//! Recording → the same recording, with a bar on the terminal that shows how far its reader is.

use crate::interrupt::{Shield, check};
use indicatif::{ProgressBar, ProgressFinish, ProgressState, ProgressStyle};
use std::time::Duration;
use torquewise::motion::{Motion, ReadError, Recording};

/// A recording whose reader is watched.
pub(crate) struct Watched<'a, R: Recording + ?Sized> {
    recording: &'a R,
    bar: ProgressBar,
}

impl<'a, R: Recording + ?Sized> Watched<'a, R> {
    /// Watches the readers of `recording`; the bar goes away with this value.
    pub(crate) fn new(recording: &'a R, doing: &str) -> Self {
        Self { recording, bar: bar(doing) }
    }

    /// Tells how many rows there are, if that is known, and how often they will be read: the bar
    /// then shows the rate and the time left.
    pub(crate) fn of(self, rows: Option<u64>, passes: u64) -> Self {
        if let Some(rows) = rows {
            self.bar.set_length(rows * passes);
            let template = "{spinner} {msg} {wide_bar} {percent} %, {per_sec}, {eta} left";
            if let Ok(style) = ProgressStyle::with_template(template) {
                self.bar.set_style(style.with_key("per_sec", rate));
            }
        }
        self
    }

    fn watch(
        &self,
        read: impl FnOnce(Visit<'_>) -> Result<(), ReadError>,
        visit: Visit<'_>,
    ) -> Result<(), ReadError> {
        let _shield = Shield::new();
        read(&mut |trajectory, block| {
            check()?;
            visit(trajectory, block)?;
            self.bar.inc(block.n_rows() as u64);
            Ok(())
        })
    }

    /// A handle to say what the rows are read for.
    pub(crate) fn bar(&self) -> ProgressBar {
        self.bar.clone()
    }
}

impl<R: Recording + ?Sized> Recording for Watched<'_, R> {
    fn joints(&self) -> &[String] {
        self.recording.joints()
    }

    fn is_filtered(&self) -> bool {
        self.recording.is_filtered()
    }

    fn read(
        &self,
        visit: &mut dyn FnMut(usize, &Motion) -> Result<(), ReadError>,
    ) -> Result<(), ReadError> {
        self.watch(|visit| self.recording.read(visit), visit)
    }

    fn n_logs(&self) -> usize {
        self.recording.n_logs()
    }

    fn read_log(
        &self,
        log: usize,
        visit: &mut dyn FnMut(usize, &Motion) -> Result<(), ReadError>,
    ) -> Result<(), ReadError> {
        self.watch(|visit| self.recording.read_log(log, visit), visit)
    }

    fn read_log_with_noise(
        &self,
        log: usize,
        seed: u64,
        visit: &mut dyn FnMut(usize, &Motion, &Motion) -> Result<(), ReadError>,
    ) -> Result<bool, ReadError> {
        let _shield = Shield::new();
        self.recording.read_log_with_noise(log, seed, &mut |trajectory, block, noise| {
            check()?;
            visit(trajectory, block, noise)?;
            self.bar.inc(block.n_rows() as u64);
            Ok(())
        })
    }
}

/// Who is shown the blocks.
type Visit<'v> = &'v mut dyn FnMut(usize, &Motion) -> Result<(), ReadError>;

/// Rows per second, in words.
fn rate(state: &ProgressState, out: &mut dyn std::fmt::Write) {
    // A bar that cannot be written to is none.
    let _ = write!(out, "{:.0} rows/s", state.per_sec());
}

/// A bar for rows of which nobody knows how many there are.
pub(crate) fn bar(doing: &str) -> ProgressBar {
    let bar = shown(ProgressBar::no_length(), "{spinner} {msg}: {human_pos} rows, {elapsed}");
    bar.set_message(doing.to_owned());
    bar
}

/// A bar for work whose amount is known.
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
