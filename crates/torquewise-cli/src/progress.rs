//! Recording → the same recording, with a bar on the terminal that shows how far its reader is.

use indicatif::{ProgressBar, ProgressFinish, ProgressStyle};
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

    /// A handle to say what the rows are read for.
    pub(crate) fn bar(&self) -> ProgressBar {
        self.bar.clone()
    }
}

impl<R: Recording + ?Sized> Recording for Watched<'_, R> {
    fn joints(&self) -> &[String] {
        self.recording.joints()
    }

    fn read(
        &self,
        visit: &mut dyn FnMut(usize, &Motion) -> Result<(), ReadError>,
    ) -> Result<(), ReadError> {
        self.bar.set_position(0);
        self.recording.read(&mut |trajectory, block| {
            visit(trajectory, block)?;
            self.bar.inc(block.n_rows() as u64);
            Ok(())
        })
    }
}

/// A bar for rows of which nobody knows how many there are.
fn bar(doing: &str) -> ProgressBar {
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
