//! Conditioned logs: resampled, filtered and differentiated, in fixed memory.

use crate::clock::ClockRepair;
use crate::pieces::Pieces;
use crate::trajectory::{Done, Trajectory};
use crate::{LogError, Logs, Result};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};
use torquewise_motion::signals::bandwidth::{Band, Bandwidths};
use torquewise_motion::signals::{ConditionReport, Cutoff, CutoffFrom, condition};
use torquewise_motion::{
    BLOCK_ROWS, Conditioning, Motion, MotionError, Raw, RawRecording, ReadResult, Recording,
    Repairs, Signals, Visit, VisitPair,
};

/// Logs whose signals are conditioned as they are read: [`torquewise_motion::signals`] tells how.
///
/// The cut-off is chosen once, from all logs, and holds for all.
#[derive(Clone, Debug)]
pub struct ConditionedLogs {
    /// The logs as they were recorded; their trajectories have the same numbers as the conditioned.
    pub logs: Logs,
    /// How every trajectory is conditioned, the choices made.
    pub settings: Conditioning,
    /// What was found in the first rows, and why the cut-off is what it is.
    pub report: ConditionReport,
    clock: ClockRepair,
    /// Of the last complete reading of each file.
    repairs: Arc<Mutex<Vec<Repairs>>>,
}

/// Logs, and pieces of them at any bandwidth and with any delay of the torque, from which those of
/// all are chosen.
#[derive(Clone, Debug)]
pub struct RawLogs {
    /// The logs at the bandwidth that is set, or eight times that of the motion.
    pub conditioned: ConditionedLogs,
    /// The longest piece, and its trajectory.
    first: (usize, Raw),
    bandwidths: Bandwidths,
    cutoffs: Vec<f64>,
    delays: Vec<f64>,
}

impl ConditionedLogs {
    /// Looks at pieces of all logs and settles how all are conditioned.
    ///
    /// A cut-off that is not set is eight times the band of the motion: [`RawLogs`] lead to a better
    /// one.
    ///
    /// # Errors
    /// [`LogError`] if the logs cannot be read, or [`LogError::Signals`] if they cannot be
    /// conditioned.
    pub fn new(logs: Logs, settings: &Conditioning) -> Result<Self> {
        let pieces = Pieces::read(&logs)?;
        Self::chosen(logs, settings, &pieces)
    }

    fn chosen(logs: Logs, settings: &Conditioning, pieces: &Pieces) -> Result<Self> {
        let (trajectory, longest) = pieces.longest()?;
        let found = condition(longest, settings);
        let mut report = found.map_err(|source| signals(&logs, trajectory, source))?.report;
        // Each joint is judged where it moves most: a log may move one of them.
        for (piece, joints) in pieces.of_most_motion(longest) {
            if let Ok(other) = condition(piece, settings) {
                for joint in joints {
                    report.see_joint(joint, &other.report);
                }
            }
        }
        pieces.all.iter().for_each(|piece| report.see_stuck(piece));
        let settings = Conditioning { cutoff: Cutoff::Hz(report.cutoff), ..*settings };
        Ok(Self::of(logs, pieces.clock, settings, report))
    }

    fn of(logs: Logs, clock: ClockRepair, settings: Conditioning, report: ConditionReport) -> Self {
        let repairs = Arc::new(Mutex::new(vec![Repairs::default(); logs.n_logs()]));
        Self { logs, settings, report, clock, repairs }
    }

    /// What was repaired in each log at its last complete reading, by its name; logs that are sound
    /// are not listed.
    pub fn repairs(&self) -> BTreeMap<String, Repairs> {
        let mut all = self.logs.repairs();
        let own = self.repairs.lock().unwrap_or_else(PoisonError::into_inner);
        for (name, repairs) in self.logs.by_name(own.iter().cloned()) {
            all.entry(name).or_default().add(&repairs);
        }
        all
    }

    /// Conditions all files, or one of them, and noise beside them if it has a seed; returns whether
    /// a trajectory was long enough.
    fn visit(
        &self,
        file: Option<usize>,
        seed: Option<u64>,
        visit: VisitBoth<'_>,
    ) -> ReadResult<bool> {
        let mut out = Cutter { trajectory: 0, is_empty: true, visit };
        let failed = |trajectory: usize| move |source| signals(&self.logs, trajectory, source);
        let noise = seed.map(|seed| (&self.report, seed));
        let mut first = 0;
        for file in file.map_or(0..self.logs.n_logs(), |file| file..file + 1) {
            let mut repairs = Repairs::default();
            let mut open: Option<Trajectory<'_>> = None;
            let mut end = |open: Option<Trajectory<'_>>, out: &mut Cutter<'_>| {
                let Some(ended) = open else { return Ok(()) };
                let (rest, own) = ended.finish().map_err(failed(out.trajectory))?;
                repairs.add(&own);
                out.hand_out(rest)
            };
            let begin = first;
            self.logs.read_raw(Some(file), &mut |own, block| -> ReadResult {
                let trajectory = begin + own;
                if trajectory != out.trajectory {
                    end(open.take(), &mut out)?;
                    out.trajectory = trajectory;
                }
                let open =
                    open.get_or_insert_with(|| Trajectory::new(&self.settings, noise, self.clock));
                let done = open.push(block).map_err(failed(trajectory))?;
                first = trajectory + 1;
                out.hand_out(done)
            })?;
            end(open, &mut out)?;
            let mut known = self.repairs.lock().unwrap_or_else(PoisonError::into_inner);
            if let Some(old) = known.get_mut(file) {
                *old = repairs;
            }
        }
        Ok(!out.is_empty)
    }
}

impl RawLogs {
    /// Looks at pieces of all logs, settles how all are conditioned but for bandwidth and delay,
    /// and keeps the pieces to choose these by. A cut-off that is set is the only one tried.
    ///
    /// - `find_delay`: whether delays of the torque other than that of `settings` are tried
    ///
    /// # Errors
    /// As [`ConditionedLogs::new`], and if the logs hold no torque.
    pub fn new(logs: Logs, settings: &Conditioning, find_delay: bool) -> Result<Self> {
        logs.require_tau()?;
        let pieces = Pieces::read(&logs)?;
        let conditioned = ConditionedLogs::chosen(logs, settings, &pieces)?;
        let (trajectory, first) = pieces.longest()?;
        let bandwidths = Bandwidths::new(&pieces.all)
            .map_err(|source| signals(&conditioned.logs, trajectory, source))?;
        let cutoffs = match settings.cutoff {
            Cutoff::Hz(cutoff) => vec![cutoff],
            Cutoff::Auto => bandwidths.cutoffs(),
        };
        let delays = if find_delay { bandwidths.delays() } else { vec![settings.delay] };
        let first = (trajectory, first.clone());
        Ok(Self { conditioned, first, bandwidths, cutoffs, delays })
    }

    /// A sample of the motion at the bandwidth of the logs, with the torque as it was measured but
    /// for spikes; `None` where they are too short.
    ///
    /// # Errors
    /// [`ReadError`](torquewise_motion::ReadError) if the logs cannot be conditioned.
    pub fn beside_raw_torque(&self) -> ReadResult<Option<Motion>> {
        let band = self.band(self.first_cutoff(), &[self.conditioned.settings.delay])?;
        let Some(Band { motion, mut torques }) = band else { return Ok(None) };
        let tau = torques.pop().map(|torque| torque.raw);
        Ok(Some(Motion::new(Signals { tau, ..motion.into_signals() })?))
    }
}

impl RawRecording for RawLogs {
    type Filtered = ConditionedLogs;

    fn first_cutoff(&self) -> f64 {
        self.conditioned.report.cutoff
    }

    fn cutoffs(&self) -> Vec<f64> {
        self.cutoffs.clone()
    }

    fn delays(&self) -> Vec<f64> {
        self.delays.clone()
    }

    fn band(&self, cutoff: f64, delays: &[f64]) -> ReadResult<Option<Band>> {
        Ok(self.bandwidths.band(cutoff, delays)?)
    }

    fn filtered(&self, cutoff: f64, delay: f64) -> ReadResult<ConditionedLogs> {
        let ConditionedLogs { logs, clock, settings, report, .. } = &self.conditioned;
        let settings = Conditioning { cutoff: Cutoff::Hz(cutoff), delay, ..*settings };
        let (trajectory, first) = &self.first;
        let found = condition(first, &settings).map_err(|e| signals(logs, *trajectory, e))?.report;
        let is_set = report.cutoff_from == CutoffFrom::Setting;
        let cutoff_from = if is_set { CutoffFrom::Setting } else { CutoffFrom::HeldOut };
        let stuck = report.stuck.clone();
        let mut report = ConditionReport { cutoff_from, stuck, ..found };
        let seen = &self.conditioned.report;
        for joint in &seen.seen_elsewhere {
            report.see_joint(*joint, seen);
        }
        Ok(ConditionedLogs::of(logs.clone(), *clock, settings, report))
    }
}

impl Recording for ConditionedLogs {
    fn joints(&self) -> &[String] {
        self.logs.joints()
    }

    fn is_filtered(&self) -> bool {
        true
    }

    fn read(&self, visit: Visit<'_>) -> ReadResult {
        if !self.visit(None, None, &mut |trajectory, motion, _| visit(trajectory, motion))? {
            let cutoff = self.report.cutoff;
            let problem = format!("no trajectory is long enough to be filtered at {cutoff:.2} Hz");
            let help = "raise the cut-off, or record longer motions";
            return Err(LogError::Unusable { problem, help }.into());
        }
        Ok(())
    }

    fn n_logs(&self) -> usize {
        self.logs.n_logs()
    }

    fn read_log(&self, log: usize, visit: Visit<'_>) -> ReadResult {
        self.visit(Some(log), None, &mut |trajectory, motion, _| visit(trajectory, motion))
            .map(drop)
    }

    fn read_log_with_noise(&self, log: usize, seed: u64, visit: VisitPair<'_>) -> ReadResult<bool> {
        self.visit(Some(log), Some(seed), &mut |trajectory, motion, noise| match noise {
            Some(noise) => visit(trajectory, motion, noise),
            None => Ok(()),
        })?;
        Ok(true)
    }
}

/// Who is shown rows, and noise beside them if it was asked for.
type VisitBoth<'v> = &'v mut dyn FnMut(usize, &Motion, Option<&Motion>) -> ReadResult;

struct Cutter<'a> {
    /// The trajectory in hand, as the logs count them.
    trajectory: usize,
    is_empty: bool,
    visit: VisitBoth<'a>,
}

impl Cutter<'_> {
    fn hand_out(&mut self, done: Done) -> ReadResult {
        let mut noise = done.noise.into_iter();
        for motion in done.motions {
            let noise = noise.next();
            let rows: Vec<usize> = (0..motion.n_rows()).collect();
            for block in rows.chunks(BLOCK_ROWS) {
                self.is_empty = false;
                let noise = noise.as_ref().map(|noise| noise.select(block));
                (self.visit)(self.trajectory, &motion.select(block), noise.as_ref())?;
            }
        }
        Ok(())
    }
}

fn signals(logs: &Logs, trajectory: usize, source: MotionError) -> LogError {
    let file = logs.file_of(trajectory).map(Path::to_owned).unwrap_or_default();
    let back = logs.report().repairs.earlier_stamps;
    let what = "rows left out, as they are earlier than a row before";
    let back = (back > 0).then(|| format!("; {what}: {back} (sort the rows by time)"));
    let doubts = logs.unit_doubts().into_iter().flat_map(|own| ["; ".to_owned(), own]);
    let doubts = doubts.chain(back).collect();
    LogError::Signals { file, trajectory: trajectory + 1, doubts, source }
}
