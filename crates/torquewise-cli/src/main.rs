//! The program `torquewise`.

use std::panic::{set_hook, take_hook};
use std::process::ExitCode;

fn main() -> ExitCode {
    // What a decoder makes of a damaged file is printed as an error.
    let usual = take_hook();
    set_hook(Box::new(move |panic| {
        if !torquewise::logs::error::decodes() {
            usual(panic);
        }
    }));
    ExitCode::from(torquewise_cli::run(&std::env::args_os().collect::<Vec<_>>()))
}
