//! Files written whole or not at all: a temporary file in the same folder that takes its place.
//!
//! A device, a pipe or a socket is written to as it is. Of a link the target is replaced, a file
//! keeps its mode, and one that is read-only is refused. Whatever is unfinished when the program is
//! [abandoned](abandon) is removed; what a killed program left, the next one removes that writes to
//! the same folder.

use std::collections::{BTreeMap, BTreeSet};
use std::ffi::OsStr;
#[cfg(unix)]
use std::fs::Permissions;
use std::fs::{self, File, Metadata, OpenOptions};
use std::io::{self, Write};
use std::mem;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::Duration;
use tempfile::{NamedTempFile, TempDir};

const PREFIX: &str = ".torquewise-";
const SUFFIX: &str = ".partial";

/// How many links a path may go through, as systems have it.
const MOST_LINKS: usize = 40;

/// A file in the making, [put in place](Self::put_in_place) when it is whole, gone when dropped.
#[derive(Debug)]
pub struct Output(Way);

#[derive(Debug)]
enum Way {
    /// A temporary file, the file whose place it takes, and what removes it.
    Beside(Staged, Cleanup),
    /// What cannot be replaced: a device, a pipe.
    Straight(File),
}

#[derive(Debug)]
struct Staged {
    written: NamedTempFile,
    target: PathBuf,
}

/// What is unfinished in this process.
struct Unfinished {
    next: u64,
    /// What undoes it, in the order of its beginning.
    cleanups: BTreeMap<u64, Box<dyn FnOnce() + Send>>,
    /// Whole files that wait for the others of [`Together`].
    waiting: Option<Waiting>,
    /// Files that took their place.
    placed: usize,
    /// Folders that were looked through for what killed programs left.
    looked_through: BTreeSet<PathBuf>,
}

static UNFINISHED: Mutex<Unfinished> = Mutex::new(Unfinished {
    next: 0,
    cleanups: BTreeMap::new(),
    waiting: None,
    placed: 0,
    looked_through: BTreeSet::new(),
});

/// What appears together.
#[derive(Default)]
struct Waiting {
    files: Vec<(Staged, Cleanup)>,
    /// Folders that were made for them.
    folders: Vec<(PathBuf, Cleanup)>,
}

fn unfinished() -> MutexGuard<'static, Unfinished> {
    // No code of others runs under the lock: what a panic leaves is still right.
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Unfinished {
    fn undo_by(&mut self, undo: impl FnOnce() + Send + 'static) -> Cleanup {
        let key = self.next;
        self.next += 1;
        self.cleanups.insert(key, Box::new(undo));
        Cleanup(key)
    }
}

/// Stands for something unfinished; dropped, it is finished.
#[derive(Debug)]
pub struct Cleanup(u64);

impl Drop for Cleanup {
    fn drop(&mut self) {
        unfinished().cleanups.remove(&self.0);
    }
}

/// Runs `undo` if the program is [abandoned](abandon) while the result lives.
///
/// `undo` must neither write files by this module nor panic.
#[must_use]
pub fn undo_by(undo: impl FnOnce() + Send + 'static) -> Cleanup {
    unfinished().undo_by(undo)
}

/// Removes all that is unfinished, and returns how many files took their place before.
///
/// For a handler of signals that ends the process right after: nothing is begun or put in place
/// from then on, whoever tries waits.
pub fn abandon() -> usize {
    let mut all = unfinished();
    for undo in mem::take(&mut all.cleanups).into_values().rev() {
        undo();
    }
    let placed = all.placed;
    mem::forget(all);
    placed
}

impl Output {
    /// Begins to write `file`.
    ///
    /// # Errors
    /// Those of creating a file in its folder; [`io::ErrorKind::PermissionDenied`] where `file` is
    /// there and read-only.
    pub fn create(file: &Path) -> io::Result<Self> {
        let target = target(file)?;
        let Destination::File { path, before } = target else {
            return Ok(Self(Way::Straight(OpenOptions::new().append(true).open(file)?)));
        };
        let folder = folder_of(&path);
        let mut all = unfinished();
        if all.looked_through.insert(folder.into()) {
            remove_stale(folder);
        }
        let written = temporary(folder)?;
        if let Some(before) = before {
            take_over(&written, &before)?;
        }
        let place = written.path().to_owned();
        let cleanup = all.undo_by(move || drop(fs::remove_file(place)));
        Ok(Self(Way::Beside(Staged { written, target: path }, cleanup)))
    }

    /// Puts the file, which is whole now, where it belongs: at once, or with the others of
    /// [`Together`].
    ///
    /// # Errors
    /// Those of writing to the disk and renaming; what was there is then as it was.
    pub fn put_in_place(self) -> io::Result<()> {
        let (staged, cleanup) = match self.0 {
            Way::Straight(mut file) => return file.flush(),
            Way::Beside(staged, cleanup) => (staged, cleanup),
        };
        staged.written.as_file().sync_all()?;
        let mut all = unfinished();
        if let Some(waiting) = &mut all.waiting {
            waiting.files.push((staged, cleanup));
            return Ok(());
        }
        staged.put(&mut all)?;
        // Its own drop takes the lock.
        drop(all);
        drop(cleanup);
        Ok(())
    }
}

impl Staged {
    fn put(self, all: &mut Unfinished) -> io::Result<()> {
        self.written.persist(self.target)?;
        all.placed += 1;
        Ok(())
    }
}

impl Write for Output {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match &mut self.0 {
            Way::Beside(staged, _) => staged.written.write(bytes),
            Way::Straight(file) => file.write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        match &mut self.0 {
            Way::Beside(staged, _) => staged.written.flush(),
            Way::Straight(file) => file.flush(),
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

/// Holds back the files that are finished while it lives, in this process: they
/// [appear](Self::appear) together, or not at all where it is dropped.
#[derive(Debug)]
pub struct Together(());

impl Together {
    /// Begins to hold back.
    #[must_use]
    pub fn begin() -> Self {
        unfinished().waiting.get_or_insert_default();
        Self(())
    }

    /// Puts all of them in place.
    ///
    /// # Errors
    /// The first file that could not be renamed, and why; those after it are gone.
    pub fn appear(self) -> Result<(), (PathBuf, io::Error)> {
        let mut all = unfinished();
        let mut cleanups = Vec::new();
        let mut outcome = Ok(());
        let Waiting { files, folders } = all.waiting.take().unwrap_or_default();
        for (staged, cleanup) in files {
            cleanups.push(cleanup);
            if outcome.is_ok() {
                let target = staged.target.clone();
                outcome = staged.put(&mut all).map_err(|error| (target, error));
            }
        }
        drop(all);
        drop((cleanups, folders));
        outcome
    }
}

impl Drop for Together {
    fn drop(&mut self) {
        let Some(Waiting { files, folders }) = unfinished().waiting.take() else { return };
        drop(files);
        for (folder, _cleanup) in folders.into_iter().rev() {
            // One that others have filled meanwhile stays.
            let _ = fs::remove_dir(folder);
        }
    }
}

/// Makes a folder and those it lies in; new ones are gone again where files that are held back
/// [together](Together) do not appear.
///
/// # Errors
/// Those of making them.
pub fn create_folder(folder: &Path) -> io::Result<()> {
    let missing = folder.ancestors().take_while(|path| !path.as_os_str().is_empty());
    let missing: Vec<PathBuf> =
        missing.take_while(|path| !path.is_dir()).map(Path::to_owned).collect();
    let mut all = unfinished();
    fs::create_dir_all(folder)?;
    let Some(mut waiting) = all.waiting.take() else { return Ok(()) };
    for path in missing.into_iter().rev() {
        let own = path.clone();
        let cleanup = all.undo_by(move || drop(fs::remove_dir(own)));
        waiting.folders.push((path, cleanup));
    }
    all.waiting = Some(waiting);
    Ok(())
}

/// A folder for work between, gone with the result, with the program when it is abandoned, or with
/// the next such folder if the program is killed.
#[derive(Debug)]
pub struct WorkFolder {
    folder: TempDir,
    /// Locked while it is in use, where folders can be.
    _lock: Option<File>,
    _cleanup: Cleanup,
}

impl WorkFolder {
    /// Makes one.
    ///
    /// # Errors
    /// Those of making it.
    pub fn create() -> io::Result<Self> {
        let parent = std::env::temp_dir();
        let mut all = unfinished();
        if all.looked_through.insert(parent.clone()) {
            remove_stale(&parent);
        }
        let folder = tempfile::Builder::new().prefix(PREFIX).suffix(SUFFIX).tempdir_in(parent)?;
        let lock = File::open(folder.path()).ok().filter(|lock| lock.try_lock().is_ok());
        let place = folder.path().to_owned();
        let cleanup = all.undo_by(move || remove_folder(&place));
        Ok(Self { folder, _lock: lock, _cleanup: cleanup })
    }

    /// Where it is.
    #[must_use]
    pub fn path(&self) -> &Path {
        self.folder.path()
    }
}

/// Removes a folder in which programs that are being ended may still write.
fn remove_folder(folder: &Path) {
    for _ in 0..20 {
        if fs::remove_dir_all(folder).is_ok() || !folder.exists() {
            break;
        }
        thread::sleep(Duration::from_millis(5));
    }
}

/// Whether `file` could be written: not read-only, and its folder there.
///
/// # Errors
/// As [`Output::create`], which this does not do.
pub fn check(file: &Path) -> io::Result<()> {
    target(file).map(drop)
}

/// What a path leads to.
enum Destination {
    /// A file, and what is there now.
    File { path: PathBuf, before: Option<Metadata> },
    /// Something that is no file, or one that another process holds open, such as `/dev/stdout`.
    Straight,
}

fn target(file: &Path) -> io::Result<Destination> {
    if ["/dev", "/proc"].iter().any(|system| file.starts_with(system)) && file.exists() {
        return Ok(Destination::Straight);
    }
    let mut path = file.to_owned();
    for _ in 0..MOST_LINKS {
        match fs::read_link(&path) {
            Ok(next) => path = folder_of(&path).join(next),
            Err(_) => break,
        }
    }
    let before = match fs::metadata(&path) {
        Ok(before) if !before.is_file() => return Ok(Destination::Straight),
        Ok(before) => before,
        Err(error) if error.kind() == io::ErrorKind::NotFound => {
            return Ok(Destination::File { path, before: None });
        }
        Err(error) => return Err(error),
    };
    if before.permissions().readonly() {
        let message = "it is read-only";
        return Err(io::Error::new(io::ErrorKind::PermissionDenied, message));
    }
    // Another's file in a folder of ours: not ours to replace.
    OpenOptions::new().write(true).open(&path)?;
    Ok(Destination::File { path, before: Some(before) })
}

/// The folder that a file lies in, `.` for a bare name.
#[must_use]
pub fn folder_of(file: &Path) -> &Path {
    match file.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// A new locked file in a folder, removed when dropped.
fn temporary(folder: &Path) -> io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(PREFIX).suffix(SUFFIX);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // Readable for whom the user's mask allows, like any new file.
        builder.permissions(Permissions::from_mode(0o666));
    }
    loop {
        let made = builder.tempfile_in(folder)?;
        // Another process may have taken it for stale before it was locked.
        if made.as_file().lock().is_err() || made.path().exists() {
            return Ok(made);
        }
    }
}

/// Gives a new file the mode of the one it will replace, and its owner where that is allowed.
fn take_over(written: &NamedTempFile, before: &Metadata) -> io::Result<()> {
    #[cfg(unix)]
    {
        use std::os::unix::fs::{MetadataExt, fchown};
        let own = written.as_file().metadata()?;
        if (own.uid(), own.gid()) != (before.uid(), before.gid()) {
            // Only root may; the file is then the writer's.
            let _ = fchown(written.as_file(), Some(before.uid()), Some(before.gid()));
        }
    }
    written.as_file().set_permissions(before.permissions())
}

/// Removes what killed programs left in a folder: files and folders whose lock nobody holds.
fn remove_stale(folder: &Path) {
    let Ok(entries) = fs::read_dir(folder) else { return };
    let is_ours = |name: &OsStr| {
        name.to_str().is_some_and(|name| name.starts_with(PREFIX) && name.ends_with(SUFFIX))
    };
    for path in entries.flatten().filter(|entry| is_ours(&entry.file_name())).map(|e| e.path()) {
        let Ok(kind) = fs::symlink_metadata(&path).map(|found| found.file_type()) else { continue };
        if !kind.is_dir() && !kind.is_file() {
            continue;
        }
        if File::open(&path).is_ok_and(|lock| lock.try_lock().is_ok()) {
            // What another removes at the same time is gone as well.
            let _ = if kind.is_dir() { fs::remove_dir_all(&path) } else { fs::remove_file(&path) };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<String> = fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn a_stale_file_is_removed_and_one_in_use_stays() {
        let folder = tempfile::tempdir().unwrap();
        let stale = folder.path().join(".torquewise-left.partial");
        fs::write(&stale, "left").unwrap();
        let used = folder.path().join(".torquewise-used.partial");
        let held = File::create(&used).unwrap();
        held.lock().unwrap();

        write_whole(&folder.path().join("new"), b"x").unwrap();

        assert_eq!(names(folder.path()), [".torquewise-used.partial", "new"]);
    }

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
        assert_eq!(names(folder.path()), ["pipe"]);
    }
}
