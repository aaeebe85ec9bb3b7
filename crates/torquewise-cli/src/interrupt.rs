//! An orderly end on Ctrl-C: files on their way are removed, finished ones stay.

use std::process;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

static PRESSED: AtomicBool = AtomicBool::new(false);
static SHIELDS: AtomicUsize = AtomicUsize::new(0);

/// What a shell calls the end by Ctrl-C: 128 and the number of the signal.
pub(crate) const INTERRUPTED: u8 = 130;

/// While one of these lives, Ctrl-C waits for the next block of rows; pressed again it does not.
pub(crate) struct Shield;

impl Shield {
    /// Begins to shield.
    pub(crate) fn new() -> Self {
        SHIELDS.fetch_add(1, Ordering::SeqCst);
        Self
    }
}

impl Drop for Shield {
    fn drop(&mut self) {
        SHIELDS.fetch_sub(1, Ordering::SeqCst);
    }
}

/// Listens to Ctrl-C and to what ends a process politely.
pub(crate) fn listen() {
    // Where nobody can listen, the end is abrupt, as it would be without.
    let _ = ctrlc::set_handler(|| {
        let again = PRESSED.swap(true, Ordering::SeqCst);
        if again || SHIELDS.load(Ordering::SeqCst) == 0 {
            process::exit(INTERRUPTED.into());
        }
    });
}

/// Whether Ctrl-C was pressed.
pub(crate) fn pressed() -> bool {
    PRESSED.load(Ordering::SeqCst)
}
