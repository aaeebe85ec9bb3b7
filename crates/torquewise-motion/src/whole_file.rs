//! Files written whole or not at all: a temporary file in the same folder that takes its place.

use std::io::{self, Write};
use std::path::Path;
use tempfile::NamedTempFile;

/// A new file in the folder of `file`, removed when dropped.
///
/// # Errors
/// Those of creating it.
pub fn temporary(file: &Path) -> io::Result<NamedTempFile> {
    let folder = file.parent().filter(|folder| !folder.as_os_str().is_empty());
    let mut builder = tempfile::Builder::new();
    builder.prefix(".torquewise-").suffix(".partial");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // Readable for whom the user's mask allows, like any new file.
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    builder.tempfile_in(folder.unwrap_or(Path::new(".")))
}

/// Puts a temporary file that is whole in the place of `file`.
///
/// # Errors
/// Those of writing to the disk and renaming; `file` is then as it was.
pub fn put_in_place(written: NamedTempFile, file: &Path) -> io::Result<()> {
    written.as_file().sync_all()?;
    written.persist(file)?;
    Ok(())
}

/// Writes bytes to `file`, whole or not at all.
///
/// # Errors
/// Those of writing; `file` is then as it was.
pub fn write_whole(file: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut written = temporary(file)?;
    written.write_all(bytes)?;
    put_in_place(written, file)
}
