//! Several log files read as one, any number of times.

use crate::accelerations::Accelerations;
use crate::blocks::Blocks;
use crate::source::Source;
use crate::{Frame, LogError, LogInput, Options, ReadReport, Result, is_bag, joints};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use torquewise_motion::{Motion, Raw, ReadResult, Recording, Repairs, Signal, Visit};

/// Log files of one arm.
///
/// Each file is a trajectory of its own, and a file is split where a step of t is over five times
/// the usual one and over 60 ms. The usual step begins as the median of a trajectory's first 32
/// steps, and each later step raises or lowers it by 1 %. A folder stands for the files of a ROS 2
/// bag in it.
///
/// Every reading goes through the files again and holds no more than some thousand rows. Missing
/// dq and ddq are derived from q (ddq from dq where that is recorded), by trajectory.
#[derive(Clone, Debug)]
pub struct Logs {
    sources: Vec<Source>,
    paths: Vec<PathBuf>,
    joints: Vec<String>,
    /// Correlation and gain of accelerations that were left out, as they do not follow from velocities.
    odd_ddq: Option<[f64; 2]>,
    velocity_gains: Vec<Option<f64>>,
    /// Of the last complete reading of each file.
    readings: Arc<Mutex<Vec<Reading>>>,
}

/// What the last complete reading of a file came to.
#[derive(Clone, Debug, Default)]
struct Reading {
    report: ReadReport,
    trajectories: usize,
    /// Usual step of its last trajectory \[s\].
    usual_step: Option<f64>,
}

/// Who is shown the blocks of logs, and the number of their trajectory.
type Each<'v, B, E> = &'v mut dyn FnMut(usize, B) -> Result<(), E>;

impl Logs {
    /// Reads the headers of files in columns `t`, `q1`…`qn`, … and the messages of bags; other rows
    /// are checked when read.
    ///
    /// # Errors
    /// [`LogError`] if a file cannot be opened, its header is not understood, or the files differ
    /// in the number or the names of their joints.
    pub fn open(paths: &[PathBuf]) -> Result<Self> {
        Self::open_with(paths, &Options::default())
    }

    /// The same for files with other columns, bags with several topics, or faulty rows.
    ///
    /// # Errors
    /// As [`open`](Self::open), and if a file does not have what the profile says.
    pub fn open_with(paths: &[PathBuf], options: &Options) -> Result<Self> {
        let paths = paths.iter().map(|path| files_of(path)).collect::<Result<Vec<_>, _>>()?;
        let paths = paths.concat();
        Self::of_inputs(&paths.iter().map(LogInput::from).collect::<Vec<_>>(), options)
    }

    /// The same for files that need not lie on a disk.
    ///
    /// # Errors
    /// As [`open_with`](Self::open_with).
    pub fn of_inputs(files: &[LogInput], options: &Options) -> Result<Self> {
        let sources = files.iter().map(|file| Source::open(file, options));
        Self::of_sources(sources.collect::<Result<_>>()?)
    }

    /// Reads tables in memory instead of files; each has a label, which stands for the name of a
    /// file.
    ///
    /// # Errors
    /// As [`open_with`](Self::open_with).
    pub fn of_frames(frames: &[(PathBuf, Arc<dyn Frame>)], options: &Options) -> Result<Self> {
        let open = |(label, frame): &(PathBuf, Arc<dyn Frame>)| {
            Source::of_frame(label, frame.clone(), options)
        };
        Self::of_sources(frames.iter().map(open).collect::<Result<_>>()?)
    }

    fn of_sources(sources: Vec<Source>) -> Result<Self> {
        let joints = agreed_joints(&sources)?;
        let paths = sources.iter().map(|source| (&source.file).into()).collect();
        let readings = Arc::new(Mutex::new(vec![Reading::default(); sources.len()]));
        let (odd_ddq, velocity_gains) = (None, vec![None; joints.len()]);
        let mut logs = Self { sources, paths, joints, odd_ddq, velocity_gains, readings };
        if logs.has_dq() && logs.has_ddq() {
            // What cannot be read is told by whoever reads it all.
            let seen = |source: &Source| {
                let mut seen = Accelerations::default();
                let mut blocks = Blocks::new(source.rows().ok()?, &logs.joints, true);
                while !seen.is_enough() {
                    let Some((_, block)) = blocks.next(Blocks::block).ok()? else { break };
                    seen.add(&block);
                }
                Some(seen)
            };
            let seen: Vec<Accelerations> = logs.sources.iter().filter_map(seen).collect();
            for gains in seen.iter().map(Accelerations::velocity_gains) {
                let own = logs.velocity_gains.iter_mut().zip(gains);
                own.for_each(|(own, gain)| *own = own.or(gain));
            }
            logs.odd_ddq = Accelerations::odd(seen.iter().map(Accelerations::agreement));
            if logs.odd_ddq.is_some() {
                logs.sources.iter_mut().for_each(|source| source.mapping.forget(Signal::Ddq));
            }
        }
        Ok(logs)
    }

    /// The files, as given.
    pub fn paths(&self) -> &[PathBuf] {
        &self.paths
    }

    /// Recorded velocity of each joint over the slope of its position, n; `None` where it does not
    /// follow, or where accelerations are derived: then the filter tells.
    pub fn velocity_gains(&self) -> &[Option<f64>] {
        &self.velocity_gains
    }

    /// Whether all files hold velocities.
    pub fn has_dq(&self) -> bool {
        self.all_have(Signal::Dq)
    }

    /// Whether all files hold accelerations that follow from their velocities.
    pub fn has_ddq(&self) -> bool {
        self.all_have(Signal::Ddq)
    }

    /// Whether all files hold torques.
    pub fn has_tau(&self) -> bool {
        self.all_have(Signal::Tau)
    }

    /// Makes sure that all files hold torques.
    ///
    /// # Errors
    /// [`LogError::NoTorque`] names the first that does not.
    pub fn require_tau(&self) -> Result<()> {
        match self.sources.iter().find(|source| source.mapping.slot(Signal::Tau).is_none()) {
            Some(source) => Err(LogError::NoTorque { file: (&source.file).into() }),
            None => Ok(()),
        }
    }

    /// Columns of any file that are not read, in alphabetical order.
    pub fn ignored_columns(&self) -> Vec<String> {
        let ignored = self.sources.iter().flat_map(|source| &source.mapping.ignored);
        ignored.cloned().collect::<BTreeSet<_>>().into_iter().collect()
    }

    /// All trajectories, whole: for logs that fit in memory.
    ///
    /// # Errors
    /// [`LogError`] if a file cannot be read or a row is wrong.
    pub fn read_all(&self) -> Result<Vec<Motion>> {
        self.trajectories().map_err(|error| match error.downcast() {
            Ok(own) => *own,
            Err(other) => {
                let file = self.paths.first().cloned().unwrap_or_default();
                LogError::Read { file, source: std::io::Error::other(other) }
            }
        })
    }

    /// About how many rows the files have, if that can be told without reading them.
    pub fn rows_hint(&self) -> Option<u64> {
        self.sources.iter().map(|source| source.rows_hint).sum()
    }

    fn all_have(&self, signal: Signal) -> bool {
        self.sources.iter().all(|source| source.mapping.slot(signal).is_some())
    }

    /// Calls `visit` with each block as it was recorded, and with the index of its trajectory.
    ///
    /// Blocks have at most 1 024 rows and are cut as those of [`Recording::read`] are, but missing
    /// dq and ddq stay missing.
    ///
    /// - `only`: the file to read, counted from 0; all without
    ///
    /// # Errors
    /// [`LogError`] if a file cannot be read or a row is wrong, or the first that `visit` returns.
    pub fn read_raw<E: From<LogError>>(
        &self,
        only: Option<usize>,
        visit: Each<'_, Raw, E>,
    ) -> Result<(), E> {
        self.each(only, false, |blocks, rows| Ok(blocks.raw_block(rows)), visit)
    }

    /// What the last complete reading of the files came to: rows, and what was dropped or sorted.
    pub fn report(&self) -> ReadReport {
        let readings = self.readings.lock().unwrap_or_else(PoisonError::into_inner);
        let mut all = ReadReport::default();
        readings.iter().for_each(|reading| all.add(&reading.report));
        all
    }

    /// The first file that the last complete reading found something in, and what.
    pub fn first<T>(&self, of: impl Fn(&ReadReport) -> Option<T>) -> Option<(&Path, T)> {
        let readings = self.readings.lock().unwrap_or_else(PoisonError::into_inner);
        let mut files = self.paths.iter().zip(readings.iter());
        files.find_map(|(path, reading)| Some((&**path, of(&reading.report)?)))
    }

    /// Clocks that hardly count seconds, by the last complete reading, and torques that a profile does
    /// not make torques.
    pub fn unit_doubts(&self) -> Vec<String> {
        let readings = self.readings.lock().unwrap_or_else(PoisonError::into_inner);
        let clocks = self.sources.iter().zip(readings.iter());
        let clocks = clocks.filter_map(|(source, own)| source.clock_doubt(own.usual_step?));
        let torque = self.sources.iter().find_map(|source| source.torque_doubt);
        let odd = self.odd_ddq.map(|[correlation, gain]| {
            format!(
                "the recorded accelerations do not follow from the recorded velocities (correlation \
                 {correlation:.2}, {gain:.2} times their slopes), as noise, commands and other units do \
                 not: they are left out, and derived"
            )
        });
        torque.map(str::to_owned).into_iter().chain(odd).chain(clocks).collect()
    }

    /// What the last complete reading of each file left out and where it was split, by name of the
    /// log; those that are sound are not listed.
    pub fn repairs(&self) -> BTreeMap<String, Repairs> {
        let readings = self.readings.lock().unwrap_or_else(PoisonError::into_inner);
        self.by_name(readings.iter().map(|reading| reading.report.repairs.clone()))
    }

    /// Repairs of each file, in their order, by the name of the log: that of its file, its ending
    /// left out. Logs of one name add up.
    pub(crate) fn by_name(&self, all: impl Iterator<Item = Repairs>) -> BTreeMap<String, Repairs> {
        let mut by_name: BTreeMap<String, Repairs> = BTreeMap::new();
        let repaired = self.paths.iter().zip(all).filter(|(_, repairs)| !repairs.is_none());
        for (path, repairs) in repaired {
            let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
            by_name.entry(name).or_default().add(&repairs);
        }
        by_name
    }

    /// The file that a trajectory was in at the last complete reading; none before that.
    pub fn file_of(&self, trajectory: usize) -> Option<&Path> {
        let readings = self.readings.lock().unwrap_or_else(PoisonError::into_inner);
        let mut end = 0;
        let holds = |reading: &Reading| {
            end += reading.trajectories;
            trajectory < end
        };
        let file = readings.iter().position(holds)?;
        self.paths.get(file).map(PathBuf::as_path)
    }

    /// Reads all files, or one of them, in blocks of some kind, dq and ddq completed or not.
    fn each<B, E: From<LogError>>(
        &self,
        only: Option<usize>,
        is_completed: bool,
        block: impl Fn(&Blocks, usize) -> Result<B>,
        visit: Each<'_, B, E>,
    ) -> Result<(), E> {
        let mut first = 0;
        for (file, source) in self.sources.iter().enumerate() {
            if only.is_some_and(|only| only != file) {
                continue;
            }
            let mut blocks = Blocks::new(source.rows()?, &self.joints, is_completed);
            let mut last = first;
            while let Some((trajectory, block)) = blocks.next(&block)? {
                last = first + trajectory;
                visit(last, block)?;
            }
            let (report, trajectories) = (blocks.rows.report, last + 1 - first);
            let usual_step = blocks.usual_step.map(|step| step.0);
            let reading = Reading { report, trajectories, usual_step };
            let mut readings = self.readings.lock().unwrap_or_else(PoisonError::into_inner);
            if let Some(old) = readings.get_mut(file) {
                *old = reading;
            }
            first = last + 1;
        }
        Ok(())
    }
}

impl Recording for Logs {
    /// Joint names, base to tip; joint1 … jointn unless a file names them.
    fn joints(&self) -> &[String] {
        &self.joints
    }

    fn read(&self, visit: Visit<'_>) -> ReadResult {
        self.each(None, true, Blocks::block, &mut |own, block| visit(own, &block))
    }

    fn n_logs(&self) -> usize {
        self.sources.len()
    }

    fn read_log(&self, log: usize, visit: Visit<'_>) -> ReadResult {
        self.each(Some(log), true, Blocks::block, &mut |own, block| visit(own, &block))
    }
}

/// The files of a bag, if its folder is given: in the order of the numbers at their ends.
fn files_of(path: &Path) -> Result<Vec<PathBuf>> {
    if !path.is_dir() {
        return Ok(vec![path.to_owned()]);
    }
    let entries = std::fs::read_dir(path).map_err(LogError::read(path))?;
    let files = entries.map(|entry| entry.map(|entry| entry.path()));
    let mut files: Vec<_> = files.collect::<Result<_, _>>().map_err(LogError::read(path))?;
    files.retain(|file| is_bag(file));
    let number = |file: &PathBuf| -> u64 {
        let stem = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let digits = stem.rsplit(|c: char| !c.is_ascii_digit()).next();
        digits.and_then(|digits| digits.parse().ok()).unwrap_or_default()
    };
    files.sort_by(|a, b| (number(a), a).cmp(&(number(b), b)));
    if files.is_empty() {
        return Err(LogError::EmptyFolder { file: path.into() });
    }
    Ok(files)
}

/// The joint names of all files: those of the first file that has any.
fn agreed_joints(sources: &[Source]) -> Result<Vec<String>> {
    let first = sources.first().ok_or(LogError::NoFiles)?;
    let expected = first.mapping.n_joints;
    if let Some(other) = sources.iter().find(|source| source.mapping.n_joints != expected) {
        let (file, found) = ((&other.file).into(), other.mapping.n_joints);
        return Err(LogError::JointCount { file, found, first: (&first.file).into(), expected });
    }
    let mut named = sources.iter().filter_map(|s| Some((&*s.file, s.mapping.joints.as_ref()?)));
    let Some((first, expected)) = named.next() else { return Ok(joints::numbered(expected)) };
    if let Some((file, found)) = named.find(|(_, names)| *names != expected) {
        let (found, first, expected) = (found.join(", "), first.display(), expected.join(", "));
        let problem = format!(" names its joints {found}, {first} names them {expected}");
        return Err(LogError::unusable(file.display(), &problem, "read logs of one arm together"));
    }
    Ok(expected.clone())
}
