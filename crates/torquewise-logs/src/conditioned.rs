//! Logs → conditioned Recording: resampled, filtered and differentiated, in fixed memory.

use crate::blocks::RawBlock;
use crate::clock::{ClockLane, ClockRepair, joined};
use crate::error::LogError;
use crate::logs::Logs;
use crate::raw_noise::{NoiseLane, RawNoise};
use faer::Mat;
use torquewise_motion::{BLOCK_ROWS, Motion, RawRecording, ReadError, Recording};
use torquewise_signals::bandwidth::Bandwidths;
use torquewise_signals::cutoff::Decided;
use torquewise_signals::{
    ConditionReport, Conditioner, Conditioning, Cutoff, CutoffChoice, Plan, Raw, SignalError,
    condition, torque_delay,
};

/// Rows that a trajectory is planned by, and of a piece.
const FIRST_ROWS: usize = 1 << 15;
/// Rows of all pieces that the conditioning is chosen from, about.
const MOST_ROWS: usize = 1 << 18;

/// Logs whose signals are conditioned as they are read: [`torquewise_signals`] tells how.
///
/// The cut-off, and the lag of the torque if it is asked for, are chosen once, from all logs, and
/// hold for all.
#[derive(Clone, Debug)]
pub struct ConditionedLogs {
    logs: Logs,
    clock: ClockRepair,
    settings: Conditioning,
    report: ConditionReport,
}

/// Logs, and pieces of them at any bandwidth, from which that of all is chosen.
#[derive(Clone, Debug)]
pub struct RawLogs {
    conditioned: ConditionedLogs,
    first: Raw,
    bandwidths: Bandwidths,
}

impl ConditionedLogs {
    /// Looks at pieces of all logs and settles how all are conditioned.
    ///
    /// A cut-off that is not set is that of the spectra: [`raw`](Self::raw) leads to a better one.
    ///
    /// - `find_delay`: whether the lag of the torque is estimated, in place of that of `settings`
    ///
    /// # Errors
    /// [`LogError`] if the logs cannot be read, or [`LogError::Signals`] if they cannot be
    /// conditioned.
    pub fn new(logs: Logs, settings: &Conditioning, find_delay: bool) -> Result<Self, LogError> {
        let refused = |source| signals(&logs, 0, source);
        let (clock, pieces) = repaired(&logs)?;
        let first = longest(&pieces).ok_or(LogError::NoFiles)?;
        let mut report = condition(first, settings).map_err(refused)?.report;
        let cutoff = report.cutoff.map_or(Cutoff::Off, Cutoff::Hz);
        let mut settings = Conditioning { cutoff, ..*settings };
        if find_delay && logs.has_tau() {
            let lag = lag(&pieces, &settings).map_err(refused)?;
            if lag != 0.0 {
                settings.delay += lag;
                let choice = report.choice.take();
                report = condition(first, &settings).map_err(refused)?.report;
                report.choice = choice;
            }
        }
        Ok(Self { logs, clock, settings, report })
    }

    /// The same logs at any bandwidth.
    ///
    /// # Errors
    /// [`LogError`] if the logs cannot be read, hold no torque, or cannot be conditioned.
    pub fn raw(&self) -> Result<RawLogs, LogError> {
        self.logs.require_tau()?;
        let (_, pieces) = repaired(&self.logs)?;
        let first = longest(&pieces).cloned().ok_or(LogError::NoFiles)?;
        let bandwidths = Bandwidths::new(&pieces, &self.settings);
        let bandwidths = bandwidths.map_err(|source| signals(&self.logs, 0, source))?;
        Ok(RawLogs { conditioned: self.clone(), first, bandwidths })
    }

    /// The logs as they were recorded; their trajectories have the same numbers as the conditioned.
    pub fn logs(&self) -> &Logs {
        &self.logs
    }

    /// How every trajectory is conditioned, the choices made.
    pub fn settings(&self) -> &Conditioning {
        &self.settings
    }

    /// What was found in the first rows, and why the cut-off is what it is.
    pub fn report(&self) -> &ConditionReport {
        &self.report
    }

    /// Conditions all files, or one of them, and noise beside them if there is any; returns whether
    /// a trajectory was long enough.
    fn visit(
        &self,
        file: Option<usize>,
        noise: Option<&RawNoise>,
        visit: Visit<'_>,
    ) -> Result<bool, ReadError> {
        let mut out = Cutter { trajectory: 0, is_empty: true, noise, visit };
        let mut own: Option<(usize, ClockLane, Stretch)> = None;
        let end = |own: Option<(usize, ClockLane, Stretch)>, out: &mut Cutter<'_>| {
            let Some((ended, lane, mut stretch)) = own else { return Ok(()) };
            if let Some(rest) = lane.finish() {
                self.push(ended, &mut stretch, &rest, out)?;
            }
            self.end(ended, stretch, out)
        };
        let mut take = |trajectory: usize, block: &RawBlock| -> Result<(), ReadError> {
            if own.as_ref().is_none_or(|(current, _, _)| *current != trajectory) {
                end(own.take(), &mut out)?;
                let lane = ClockLane::new(self.clock);
                own = Some((trajectory, lane, Stretch::Waiting(Vec::new())));
            }
            let Some((_, lane, stretch)) = &mut own else { return Ok(()) };
            match lane.push(block) {
                Some(block) => self.push(trajectory, stretch, &block, &mut out),
                None => Ok(()),
            }
        };
        match file {
            None => self.logs.read_raw(&mut take)?,
            Some(file) => self.logs.read_raw_of(file, &mut take)?,
        }
        end(own, &mut out)?;
        Ok(!out.is_empty)
    }

    fn push(
        &self,
        trajectory: usize,
        stretch: &mut Stretch,
        block: &RawBlock,
        out: &mut Cutter<'_>,
    ) -> Result<(), ReadError> {
        let failed = |source| signals(&self.logs, trajectory, source);
        out.trajectory = trajectory;
        match stretch {
            Stretch::Waiting(blocks) => {
                blocks.push(block.clone());
                let rows: usize = blocks.iter().map(|block| block.t.len()).sum();
                if rows >= FIRST_ROWS {
                    let raw = whole(self.logs.joints(), blocks);
                    let plan = Plan::new(&raw, &self.settings).map_err(failed)?;
                    let mut lane = out.noise.map(|noise| noise.lane(plan.clone()));
                    let mut conditioner = Box::new(Conditioner::new(plan));
                    let motions = conditioner.push(&raw).map_err(failed)?;
                    out.hand_out(motions, pushed(lane.as_mut(), &raw).map_err(failed)?)?;
                    *stretch = Stretch::Running(conditioner, lane.map(Box::new));
                }
                Ok(())
            }
            Stretch::Running(conditioner, lane) => {
                let raw = whole(self.logs.joints(), std::slice::from_ref(block));
                let motions = conditioner.push(&raw).map_err(failed)?;
                out.hand_out(motions, pushed(lane.as_deref_mut(), &raw).map_err(failed)?)
            }
        }
    }

    /// The rest of a trajectory; one that is too short to be filtered is left out.
    fn end(&self, trajectory: usize, rest: Stretch, out: &mut Cutter<'_>) -> Result<(), ReadError> {
        let failed = |source| signals(&self.logs, trajectory, source);
        out.trajectory = trajectory;
        let (motions, noise) = match rest {
            Stretch::Running(conditioner, lane) => {
                let motions = conditioner.finish().map_err(failed)?;
                (
                    motions,
                    lane.map_or_else(|| Ok(Vec::new()), |lane| lane.finish()).map_err(failed)?,
                )
            }
            Stretch::Waiting(blocks) => {
                let raw = whole(self.logs.joints(), &blocks);
                let motions = match condition(&raw, &self.settings) {
                    Ok(conditioned) => vec![conditioned.motion],
                    Err(error) if error.is_too_short() => return Ok(()),
                    Err(error) => return Err(failed(error).into()),
                };
                let beside = |noise: &RawNoise| -> Result<Vec<Motion>, SignalError> {
                    let mut lane = noise.lane(Plan::new(&raw, &self.settings)?);
                    let mut rows = lane.push(&raw)?;
                    rows.extend(lane.finish()?);
                    Ok(rows)
                };
                (motions, out.noise.map_or_else(|| Ok(Vec::new()), beside).map_err(failed)?)
            }
        };
        out.hand_out(motions, noise)
    }
}

impl RawRecording for RawLogs {
    type Filtered = ConditionedLogs;

    fn first_cutoff(&self) -> f64 {
        self.conditioned.report.cutoff.unwrap_or_default()
    }

    fn cutoffs(&self) -> Vec<f64> {
        self.bandwidths.cutoffs()
    }

    fn sample(&self, cutoff: f64) -> Result<Option<Motion>, ReadError> {
        Ok(self.bandwidths.motion(cutoff)?)
    }

    fn raw_torque(&self) -> &Mat<f64> {
        self.bandwidths.target()
    }

    fn filtered(&self, cutoff: f64) -> Result<ConditionedLogs, ReadError> {
        let ConditionedLogs { logs, clock, settings, report } = &self.conditioned;
        let settings = Conditioning { cutoff: Cutoff::Hz(cutoff), ..*settings };
        let found = condition(&self.first, &settings).map_err(|e| signals(logs, 0, e))?.report;
        let decided = Decided::HeldOut;
        let choice = report.choice.clone().map(|was| CutoffChoice { cutoff, decided, ..was });
        let report = ConditionReport { choice, ..found };
        Ok(ConditionedLogs { logs: logs.clone(), clock: *clock, settings, report })
    }
}

impl Recording for ConditionedLogs {
    fn joints(&self) -> &[String] {
        self.logs.joints()
    }

    fn is_filtered(&self) -> bool {
        true
    }

    fn read(
        &self,
        visit: &mut dyn FnMut(usize, &Motion) -> Result<(), ReadError>,
    ) -> Result<(), ReadError> {
        if !self.visit(None, None, &mut |trajectory, motion, _| visit(trajectory, motion))? {
            let cutoff = self.report.cutoff.unwrap_or_default();
            return Err(LogError::NothingLeft { cutoff }.into());
        }
        Ok(())
    }

    fn n_logs(&self) -> usize {
        self.logs.n_logs()
    }

    fn read_log(
        &self,
        log: usize,
        visit: &mut dyn FnMut(usize, &Motion) -> Result<(), ReadError>,
    ) -> Result<(), ReadError> {
        self.visit(Some(log), None, &mut |trajectory, motion, _| visit(trajectory, motion))
            .map(drop)
    }

    fn read_log_with_noise(
        &self,
        log: usize,
        seed: u64,
        visit: &mut dyn FnMut(usize, &Motion, &Motion) -> Result<(), ReadError>,
    ) -> Result<bool, ReadError> {
        let noise = RawNoise::of(&self.report, self.settings.derive, seed);
        self.visit(Some(log), Some(&noise), &mut |trajectory, motion, noise| match noise {
            Some(noise) => visit(trajectory, motion, noise),
            None => Ok(()),
        })?;
        Ok(true)
    }
}

/// Who is shown rows, and noise beside them if it was asked for.
type Visit<'v> = &'v mut dyn FnMut(usize, &Motion, Option<&Motion>) -> Result<(), ReadError>;

/// Noise for the next rows, if there is to be any.
fn pushed(lane: Option<&mut NoiseLane>, raw: &Raw) -> Result<Vec<Motion>, SignalError> {
    lane.map_or_else(|| Ok(Vec::new()), |lane| lane.push(raw))
}

/// A trajectory on its way through the filter.
enum Stretch {
    /// Too few rows to plan by so far.
    Waiting(Vec<RawBlock>),
    Running(Box<Conditioner>, Option<Box<NoiseLane>>),
}

/// Cuts motion into blocks.
struct Cutter<'a> {
    /// The trajectory in hand, as the logs count them.
    trajectory: usize,
    is_empty: bool,
    /// Noise that is asked for beside the rows.
    noise: Option<&'a RawNoise>,
    visit: Visit<'a>,
}

impl Cutter<'_> {
    /// - `noise`: of the same rows, or nothing where none is asked for
    fn hand_out(&mut self, motions: Vec<Motion>, noise: Vec<Motion>) -> Result<(), ReadError> {
        let mut noise = noise.into_iter();
        for motion in motions {
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

fn signals(logs: &Logs, trajectory: usize, source: SignalError) -> LogError {
    let file = logs.paths().first().cloned().unwrap_or_default();
    LogError::Signals { file, trajectory: trajectory + 1, source }
}

/// The piece of most rows, the first of several.
fn longest(pieces: &[Raw]) -> Option<&Raw> {
    pieces.iter().rev().max_by_key(|piece| piece.t.len())
}

/// What the clock of logs asks for, and pieces of all trajectories with their clock mended.
fn repaired(logs: &Logs) -> Result<(ClockRepair, Vec<Raw>), LogError> {
    let raw = pieces(logs)?;
    let clock = ClockRepair::of(&raw);
    let mend = |piece: &RawBlock| {
        let mut lane = ClockLane::new(clock);
        let blocks: Vec<RawBlock> = lane.push(piece).into_iter().chain(lane.finish()).collect();
        whole(logs.joints(), &blocks)
    };
    Ok((clock, raw.iter().map(mend).collect()))
}

/// Pieces of all trajectories, evenly spread over them: all rows of short logs, and no more than
/// some of long ones.
fn pieces(logs: &Logs) -> Result<Vec<RawBlock>, LogError> {
    let (mut kept, mut every, mut count) = (Vec::<RawBlock>::new(), 1, 0);
    let mut open: (usize, Vec<RawBlock>) = (0, Vec::new());
    let mut take = |blocks: &mut Vec<RawBlock>| {
        if !blocks.is_empty() && count % every == 0 {
            kept.push(joined(blocks));
        }
        count += usize::from(!blocks.is_empty());
        blocks.clear();
        let rows: usize = kept.iter().map(|piece| piece.t.len()).sum();
        if rows > MOST_ROWS && kept.len() > 1 {
            every *= 2;
            let mut place = 0;
            kept.retain(|_| {
                place += 1;
                place % 2 == 1
            });
        }
    };
    logs.read_raw(&mut |trajectory, block| -> Result<(), LogError> {
        let rows: usize = open.1.iter().map(|block| block.t.len()).sum();
        if trajectory != open.0 || rows >= FIRST_ROWS {
            take(&mut open.1);
        }
        open.0 = trajectory;
        open.1.push(block.clone());
        Ok(())
    })?;
    take(&mut open.1);
    Ok(kept)
}

/// The middle one of the lags that pieces show \[s\]; none where fewer than half of them do.
fn lag(pieces: &[Raw], settings: &Conditioning) -> Result<f64, SignalError> {
    let mut lags = Vec::new();
    for piece in pieces {
        match torque_delay(piece, settings) {
            Ok(lag) => lags.push(lag.map_or(0.0, |lag| lag.seconds)),
            Err(error) if error.is_too_short() => {}
            Err(error) => return Err(error),
        }
    }
    lags.sort_by(f64::total_cmp);
    Ok(lags.get(lags.len() / 2).copied().unwrap_or_default())
}

/// Blocks of one trajectory, one after the other.
fn whole(joints: &[String], blocks: &[RawBlock]) -> Raw {
    let RawBlock { t, q, dq, ddq, tau } = joined(blocks);
    Raw { joints: joints.to_vec(), q, dq, ddq, tau, t }
}
