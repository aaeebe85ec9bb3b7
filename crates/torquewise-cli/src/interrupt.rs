//! An orderly end on Ctrl-C: files on their way are removed, finished ones stay.

use crate::files::abandon;
use std::process;

/// What a shell calls the end by Ctrl-C: 128 and the number of the signal.
const INTERRUPTED: i32 = 130;

/// - `is_meant`: whether the command has no other end
pub(crate) fn listen(is_meant: bool) {
    // Where nobody can listen, the end is abrupt, as it would be without.
    let _ = ctrlc::set_handler(move || {
        match abandon() {
            _ if is_meant => process::exit(0),
            0 => eprintln!("error: interrupted, no file was written: run it again"),
            _ => eprintln!("error: interrupted when the files were written: they are whole"),
        }
        process::exit(INTERRUPTED);
    });
}
