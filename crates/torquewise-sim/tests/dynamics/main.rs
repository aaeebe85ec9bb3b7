//! Arms, motions and noise beside identities and values of another program.

mod identities;
mod motions;
mod noise;
mod oracles;
mod urdf_chain;

use std::path::{Path, PathBuf};

/// A file of the shared folder, or `None` where it is missing and not required.
fn shared(file: &str) -> Option<PathBuf> {
    let default = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared");
    let folder = std::env::var("TORQUEWISE_SHARED").unwrap_or_else(|_| default.into());
    let path = Path::new(&folder).join(file);
    if path.exists() {
        return Some(path);
    }
    let required = std::env::var("TORQUEWISE_SHARED_REQUIRED").is_ok_and(|value| value == "1");
    assert!(!required, "{} is required and missing", path.display());
    println!("skipped: {} is missing", path.display());
    None
}
