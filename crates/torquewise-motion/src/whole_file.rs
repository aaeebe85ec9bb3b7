//! Files written whole or not at all: a temporary file in the same folder that takes its place.
//!
//! A device, a pipe or a socket is written to as it is. Of a link the target is replaced, a file
//! keeps its mode, and one that is read-only is refused.

#[cfg(unix)]
use std::fs::Permissions;
use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

const MOST_LINKS: usize = 40;

/// A file in the making, [put in place](Self::put_in_place) when it is whole, gone when dropped.
#[derive(Debug)]
pub enum Output {
    /// A temporary file, and the file whose place it takes.
    Beside(NamedTempFile, PathBuf),
    /// What cannot be replaced: a device, a pipe.
    Straight(File),
}

impl Output {
    /// Begins to write `file`.
    ///
    /// # Errors
    /// Those of creating a file in its folder; [`io::ErrorKind::PermissionDenied`] where `file` is
    /// there and read-only.
    pub fn create(file: &Path) -> io::Result<Self> {
        let Some(target) = destination(file)? else {
            return Ok(Self::Straight(OpenOptions::new().append(true).open(file)?));
        };
        let mut builder = tempfile::Builder::new();
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            // Readable for whom the user's mask allows, like any new file.
            builder.permissions(Permissions::from_mode(0o666));
        }
        let written = builder.prefix(".torquewise-").tempfile_in(folder_of(&target))?;
        Ok(Self::Beside(written, target))
    }

    /// Puts the file, which is whole now, where it belongs.
    ///
    /// # Errors
    /// Those of writing to the disk and renaming; what was there is then as it was.
    pub fn put_in_place(self) -> io::Result<()> {
        match self {
            Self::Straight(mut file) => file.flush(),
            Self::Beside(written, target) => {
                written.as_file().sync_all()?;
                keep_mode(written.path(), &target)?;
                Ok(written.persist(target).map(drop)?)
            }
        }
    }
}

impl Write for Output {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match self {
            Self::Beside(written, _) => written.write(bytes),
            Self::Straight(file) => file.write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        match self {
            Self::Beside(written, _) => written.flush(),
            Self::Straight(file) => file.flush(),
        }
    }
}

/// Writes bytes to `file`, whole or not at all.
///
/// # Errors
/// Those of [`Output`].
pub fn write_whole(file: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut written = Output::create(file)?;
    written.write_all(bytes)?;
    written.put_in_place()
}

/// The file that writing to `file` makes or replaces, behind any links; none where `file` is no
/// file, or one that another process holds open, such as `/dev/stdout`: it is written to as it is.
///
/// # Errors
/// [`io::ErrorKind::PermissionDenied`] where it is there and read-only, or those of looking at it.
pub fn destination(file: &Path) -> io::Result<Option<PathBuf>> {
    if ["/dev", "/proc"].iter().any(|system| file.starts_with(system)) && file.exists() {
        return Ok(None);
    }
    let mut path = file.to_owned();
    for _ in 0..MOST_LINKS {
        let Ok(next) = fs::read_link(&path) else { break };
        path = folder_of(&path).join(next);
    }
    let before = match fs::metadata(&path) {
        Ok(before) if !before.is_file() => return Ok(None),
        Ok(before) => before,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Some(path)),
        Err(error) => return Err(error),
    };
    if before.permissions().readonly() {
        let message = "it is read-only";
        return Err(io::Error::new(io::ErrorKind::PermissionDenied, message));
    }
    // Another's file in a folder of ours: not ours to replace.
    OpenOptions::new().write(true).open(&path)?;
    Ok(Some(path))
}

/// Gives a new file the mode of the one that it will replace, if there is one.
///
/// # Errors
/// Those of setting it.
pub fn keep_mode(written: &Path, target: &Path) -> io::Result<()> {
    fs::metadata(target).map_or(Ok(()), |before| fs::set_permissions(written, before.permissions()))
}

/// The folder that a file lies in, `.` for a bare name.
#[must_use]
pub fn folder_of(file: &Path) -> &Path {
    match file.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(unix)]
    #[test]
    fn c17_links_are_followed_modes_kept_and_read_only_files_refused() {
        use std::os::unix::fs::{PermissionsExt, symlink};
        let folder = tempfile::tempdir().unwrap();
        let [file, link, loose] = ["file", "link", "loose"].map(|name| folder.path().join(name));
        fs::write(&file, "old").unwrap();
        fs::set_permissions(&file, Permissions::from_mode(0o640)).unwrap();
        symlink("file", &link).unwrap();
        symlink("made", &loose).unwrap();

        write_whole(&link, b"new").unwrap();
        write_whole(&loose, b"made").unwrap();

        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read(&file).unwrap(), b"new");
        assert_eq!(fs::metadata(&file).unwrap().permissions().mode() & 0o777, 0o640);
        assert_eq!(fs::read(folder.path().join("made")).unwrap(), b"made");

        fs::set_permissions(&file, Permissions::from_mode(0o444)).unwrap();
        let refused = write_whole(&file, b"newer").unwrap_err();
        assert_eq!(refused.kind(), io::ErrorKind::PermissionDenied);
        assert_eq!(fs::read(&file).unwrap(), b"new");
    }

    #[cfg(unix)]
    #[test]
    fn c17_a_device_and_a_pipe_are_written_to_and_stay() {
        use std::os::unix::fs::FileTypeExt;
        let folder = tempfile::tempdir().unwrap();
        let pipe = folder.path().join("pipe");
        let made = std::process::Command::new("mkfifo").arg(&pipe).status().unwrap();
        assert!(made.success());
        let reader = {
            let pipe = pipe.clone();
            std::thread::spawn(move || fs::read(pipe).unwrap())
        };

        write_whole(&pipe, b"through").unwrap();
        write_whole(Path::new("/dev/null"), b"gone").unwrap();

        assert_eq!(reader.join().unwrap(), b"through");
        assert!(fs::symlink_metadata(&pipe).unwrap().file_type().is_fifo());
        assert!(fs::metadata("/dev/null").unwrap().file_type().is_char_device());
        let names = fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name());
        assert_eq!(names.collect::<Vec<_>>(), ["pipe"]);
    }
}
