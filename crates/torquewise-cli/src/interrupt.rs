//! An orderly end on Ctrl-C: files on their way are removed, finished ones stay.

use crate::files::abandon;
use std::process;

/// What a shell calls the end by Ctrl-C: 128 and the number of the signal.
const INTERRUPTED: i32 = 130;

pub(crate) fn listen() {
    // Where nobody can listen, the end is abrupt, as it would be without.
    let _ = ctrlc::set_handler(|| {
        match abandon() {
            0 => eprintln!("error: interrupted, no file was written: run it again"),
            _ => eprintln!("error: interrupted when the files were written: they are whole"),
        }
        process::exit(INTERRUPTED);
    });
}
