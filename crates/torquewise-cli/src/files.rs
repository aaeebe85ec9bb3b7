//! Paths → texts, models and arms; texts → files, written whole or not at all.

use crate::{CliError, Result};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;
use std::{env, fs, io, mem, thread};
use tempfile::TempDir;
use torquewise::dynamics::{Arm, Friction, SimError};
use torquewise::logs::is_log;
use torquewise::model::{Model, number};
use torquewise::motion::bounded_file;
use torquewise::motion::whole_file::{self, destination, folder_of, keep_mode};
use torquewise::twin;

pub(crate) fn read_model(file: &Path) -> Result<Model> {
    if is_log(file) {
        let help = "the model comes first, then the logs";
        return Err(CliError::refused(file, "is a log, not a model", help));
    }
    Ok(Model::load(file)?)
}

/// The built-in arm of that name, or the one in a `.urdf`, `.toml` or model file, with that model.
///
/// - `friction`: a file of it, which a model does not take
pub(crate) fn read_arm(
    arm: &str,
    locked: &[String],
    friction: Option<&Path>,
) -> Result<(Arm, Option<Model>)> {
    let file = Path::new(arm);
    let extension = file.extension().map(|e| e.to_string_lossy().to_lowercase());
    let read = |read: &dyn Fn(&str) -> Result<Arm, SimError>| {
        read(&read_text(file)?)
            .map_err(|error| CliError::from(error).within(format!("no arm in {arm}")))
    };
    let usage = |message: &str| Err(CliError::Usage(format!("{message}: leave it out")));
    let arm = match extension.as_deref() {
        Some("urdf") => read(&|text| Arm::from_urdf(text, locked))?,
        _ if !locked.is_empty() => return usage("--lock is for arms from a .urdf file"),
        Some("json") if friction.is_some() => {
            return usage("--friction is not for a model, which has its own");
        }
        Some("json") => {
            let model = read_model(file)?;
            return Ok((twin::arm(&model)?, Some(model)));
        }
        Some("toml") => read(&Arm::from_dh_toml)?,
        _ => Arm::builtin(arm)?,
    };
    Ok((arm, None))
}

/// The friction in a file, for the joints of an arm; none without a file.
pub(crate) fn read_friction(file: Option<&Path>, arm: &Arm) -> Result<Friction> {
    match file {
        None => Ok(Friction::none(arm.n_joints())),
        Some(file) => Friction::from_toml(&read_text(file)?, arm.joints()).map_err(|error| {
            CliError::from(error).within(format!("no friction in {}", file.display()))
        }),
    }
}

pub(crate) fn read_bytes(file: &Path) -> Result<Vec<u8>> {
    bounded_file::read(file).map_err(|source| CliError::Read { file: file.into(), source })
}

pub(crate) fn read_text(file: &Path) -> Result<String> {
    bounded_file::read_text(file).map_err(|source| CliError::Read { file: file.into(), source })
}

/// A file to be written, and the endings that its name may have; any without.
pub(crate) type Output<'a> = (&'a Path, &'a [&'a str]);
/// Endings of tables.
pub(crate) const TABLES: &[&str] = &["csv", "parquet"];

/// Refuses outputs that cannot be written, would replace what is read or each other, or whose name
/// promises another format, before work is done.
pub(crate) fn check_files<'a>(
    inputs: impl IntoIterator<Item = &'a PathBuf>,
    outputs: impl IntoIterator<Item = Output<'a>>,
) -> Result<()> {
    let inputs: Vec<PathBuf> =
        inputs.into_iter().filter_map(|input| input.canonicalize().ok()).collect();
    let mut seen: Vec<PathBuf> = Vec::new();
    for (file, endings) in outputs {
        let folder = folder_of(file);
        if !folder.is_dir() {
            let what = format!("cannot be written, there is no folder {}", folder.display());
            return Err(CliError::refused(file, what, "create it or name another"));
        }
        if file.is_dir() {
            return Err(CliError::refused(file, "is a folder", "name a file in it"));
        }
        let refused = |source| CliError::Write { file: file.into(), source };
        destination(file).map_err(refused)?;
        // A file that does not exist yet has a folder that does.
        let folder = folder.canonicalize().unwrap_or_else(|_| folder.into());
        let new = || folder.join(file.file_name().unwrap_or_default());
        let real = file.canonicalize().unwrap_or_else(|_| new());
        if inputs.contains(&real) {
            let help = "give the output another name";
            return Err(CliError::refused(file, "is read by this command", help));
        }
        if seen.contains(&real) {
            let help = "give each output a name of its own";
            return Err(CliError::refused(file, "would be written twice", help));
        }
        let ending = file.extension().map(|ending| ending.to_string_lossy().to_lowercase());
        if !endings.is_empty() && ending.is_none_or(|ending| !endings.contains(&&*ending)) {
            let expected: Vec<_> = endings.iter().map(|ending| format!(".{ending}")).collect();
            return Err(CliError::Ending { file: file.into(), expected: expected.join(" or ") });
        }
        seen.push(real);
    }
    Ok(())
}

pub(crate) fn check_rows(seconds: f64, rate: f64, most: f64) -> Result<()> {
    if seconds * rate <= most {
        return Ok(());
    }
    Err(CliError::Usage(format!(
        "{} rows of motion would have to be held in memory, at most {most} are: choose a shorter \
         time or a lower rate",
        number(seconds * rate)
    )))
}

/// What the command at work has begun and not yet put in place.
struct Unfinished {
    temporary: Vec<TempDir>,
    /// Temporary files, and the files whose place they will take.
    files: Vec<(PathBuf, PathBuf)>,
    folders: Vec<PathBuf>,
    placed: usize,
}

static UNFINISHED: Mutex<Unfinished> =
    Mutex::new(Unfinished { temporary: vec![], files: vec![], folders: vec![], placed: 0 });

fn unfinished() -> MutexGuard<'static, Unfinished> {
    // What a panic leaves is still right.
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Unfinished {
    fn temporary_in(&mut self, parent: &Path) -> io::Result<PathBuf> {
        let folder = tempfile::Builder::new().prefix(".torquewise-").tempdir_in(parent)?;
        let path = folder.path().to_owned();
        self.temporary.push(folder);
        Ok(path)
    }

    fn undo(&mut self) {
        for folder in mem::take(&mut self.temporary) {
            // A compiler that is being ended may still write in it.
            for _ in 0..20 {
                if fs::remove_dir_all(folder.path()).is_ok() || !folder.path().exists() {
                    break;
                }
                thread::sleep(Duration::from_millis(5));
            }
        }
        for folder in mem::take(&mut self.folders).into_iter().rev() {
            // One that is not empty stays.
            let _ = fs::remove_dir(folder);
        }
    }
}

/// Where to write what will appear as `file` when the command is done: a temporary file of that
/// name in the same folder, or `file` itself where that is a device or a pipe.
pub(crate) fn staged(file: &Path) -> Result<PathBuf> {
    let failed = |source| CliError::Write { file: file.into(), source };
    let Some(target) = destination(file).map_err(failed)? else { return Ok(file.into()) };
    let mut all = unfinished();
    let folder = all.temporary_in(folder_of(&target)).map_err(failed)?;
    let written = folder.join(file.file_name().unwrap_or_default());
    all.files.push((written.clone(), target));
    Ok(written)
}

pub(crate) fn write_whole(file: &Path, bytes: impl AsRef<[u8]>) -> Result<()> {
    whole_file::write_whole(&staged(file)?, bytes.as_ref())
        .map_err(|source| CliError::Write { file: file.into(), source })
}

pub(crate) fn work_folder() -> Result<PathBuf> {
    let parent = env::temp_dir();
    let made = unfinished().temporary_in(&parent);
    made.map_err(|source| CliError::Write { file: parent, source })
}

/// Does work whose files appear together when it is done, or not at all.
pub(crate) fn all_or_none<T>(work: impl FnOnce() -> Result<T>) -> Result<T> {
    struct Undo;
    impl Drop for Undo {
        fn drop(&mut self) {
            unfinished().undo();
        }
    }
    let _undo = Undo;
    let found = work()?;
    let mut all = unfinished();
    for (written, file) in mem::take(&mut all.files) {
        let placed = keep_mode(&written, &file).and_then(|()| fs::rename(&written, &file));
        placed.map_err(|source| CliError::Write { file, source })?;
        all.placed += 1;
    }
    Ok(found)
}

/// Removes all that is unfinished, and returns how many files took their place before.
///
/// For a handler of signals that ends the process right after: nothing is begun or put in place
/// from then on, whoever tries waits.
pub(crate) fn abandon() -> usize {
    let mut all = unfinished();
    all.undo();
    let placed = all.placed;
    mem::forget(all);
    placed
}

/// Makes a folder for results, and tries whether files can be written there; it is gone again
/// where the command does not succeed.
pub(crate) fn create_folder(folder: &Path) -> Result<()> {
    if folder.exists() && !folder.is_dir() {
        return Err(CliError::refused(folder, "is a file", "name a folder"));
    }
    let failed = |source| CliError::Write { file: folder.into(), source };
    let ancestors = folder.ancestors().take_while(|path| !path.as_os_str().is_empty());
    let missing: Vec<_> = ancestors.take_while(|path| !path.is_dir()).map(Path::to_owned).collect();
    let mut all = unfinished();
    all.folders.extend(missing.into_iter().rev());
    fs::create_dir_all(folder).map_err(failed)?;
    tempfile::tempfile_in(folder).map_err(failed).map(drop)
}
