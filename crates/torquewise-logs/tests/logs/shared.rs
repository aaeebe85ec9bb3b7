//! Reference values, real logs and robots that are not part of the repository.

use std::path::{Path, PathBuf};

/// A file or folder of those in `TORQUEWISE_SHARED`, or in `shared` beside the repository; none where
/// a test is to be skipped.
pub(crate) fn shared(name: &str) -> Option<PathBuf> {
    let beside = || {
        let above = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors();
        above.map(|folder| folder.join("shared")).find(|folder| folder.is_dir())
    };
    let folder = std::env::var_os("TORQUEWISE_SHARED").map(PathBuf::from).or_else(beside);
    let found = folder.map(|folder| folder.join(name)).filter(|path| path.exists());
    let is_required = std::env::var_os("TORQUEWISE_SHARED_REQUIRED").is_some();
    assert!(found.is_some() || !is_required, "{name} is required and missing");
    if found.is_none() {
        println!("skipped: {name} is missing");
    }
    found
}
