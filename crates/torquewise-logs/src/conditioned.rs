//! Logs → conditioned Recording: resampled, filtered and differentiated, in fixed memory.

use crate::blocks::RawBlock;
use crate::error::LogError;
use crate::logs::Logs;
use crate::raw_noise::{NoiseLane, RawNoise};
use faer::Mat;
use torquewise_motion::{BLOCK_ROWS, Motion, ReadError, Recording};
use torquewise_signals::cutoff::Decided;
use torquewise_signals::{
    ConditionReport, Conditioner, Conditioning, Cutoff, CutoffChoice, Plan, Raw, SignalError,
    condition, torque_delay,
};

/// Rows that the cut-off is chosen from, and that a trajectory is planned by.
const FIRST_ROWS: usize = 1 << 15;

/// Logs whose signals are conditioned as they are read: [`torquewise_signals`] tells how.
///
/// The cut-off, and the lag of the torque if it is asked for, are chosen from the first rows of the
/// first trajectory and hold for all.
#[derive(Clone, Debug)]
pub struct ConditionedLogs {
    logs: Logs,
    settings: Conditioning,
    report: ConditionReport,
}

/// A reading that ended early, since enough is known.
enum Halt {
    Enough,
    Error(LogError),
}

impl From<LogError> for Halt {
    fn from(error: LogError) -> Self {
        Self::Error(error)
    }
}

impl ConditionedLogs {
    /// Looks at the first trajectory and settles how all are conditioned.
    ///
    /// - `find_delay`: whether the lag of the torque is estimated, in place of that of `settings`
    ///
    /// # Errors
    /// [`LogError`] if the logs cannot be read, or [`LogError::Signals`] if the first trajectory
    /// cannot be conditioned.
    pub fn new(logs: Logs, settings: &Conditioning, find_delay: bool) -> Result<Self, LogError> {
        let raw = first_rows(&logs)?;
        let refused = |source| signals(&logs, 0, source);
        let mut first = condition(&raw, settings).map_err(refused)?;
        let cutoff = first.report.cutoff.map_or(Cutoff::Off, Cutoff::Hz);
        let mut settings = Conditioning { cutoff, ..*settings };
        if find_delay
            && raw.tau.is_some()
            && let Some(lag) = torque_delay(&raw, &settings).map_err(refused)?
        {
            settings.delay += lag.seconds;
            let choice = first.report.choice.take();
            first = condition(&raw, &settings).map_err(refused)?;
            first.report.choice = choice;
        }
        Ok(Self { logs, settings, report: first.report })
    }

    /// The first rows at each of these cut-offs \[Hz\], but for those that the rate or the length
    /// of the log does not allow.
    ///
    /// # Errors
    /// [`LogError`] if the logs cannot be read or conditioned.
    pub fn at_cutoffs(&self, cutoffs: &[f64]) -> Result<Vec<(f64, Motion)>, LogError> {
        let raw = first_rows(&self.logs)?;
        let mut found = Vec::new();
        for &cutoff in cutoffs {
            let settings = Conditioning { cutoff: Cutoff::Hz(cutoff), ..self.settings };
            match condition(&raw, &settings) {
                Ok(conditioned) => found.push((cutoff, conditioned.motion)),
                Err(SignalError::Cutoff { .. }) => {}
                Err(error) if error.is_too_short() => {}
                Err(source) => return Err(signals(&self.logs, 0, source)),
            }
        }
        Ok(found)
    }

    /// The same logs at another cut-off \[Hz\], since it predicts held-out rows better.
    ///
    /// # Errors
    /// [`LogError`] if the logs cannot be read or conditioned.
    pub fn with_cutoff(self, cutoff: f64) -> Result<Self, LogError> {
        let raw = first_rows(&self.logs)?;
        let settings = Conditioning { cutoff: Cutoff::Hz(cutoff), ..self.settings };
        let first = condition(&raw, &settings).map_err(|e| signals(&self.logs, 0, e))?;
        let decided = Decided::HeldOut;
        let choice = self.report.choice.map(|choice| CutoffChoice { cutoff, decided, ..choice });
        Ok(Self { logs: self.logs, settings, report: ConditionReport { choice, ..first.report } })
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
        let mut own: Option<(usize, Stretch)> = None;
        let mut take = |trajectory: usize, block: &RawBlock| -> Result<(), ReadError> {
            if own.as_ref().is_none_or(|(current, _)| *current != trajectory) {
                if let Some((ended, stretch)) = own.take() {
                    self.end(ended, stretch, &mut out)?;
                }
                own = Some((trajectory, Stretch::Waiting(Vec::new())));
            }
            match &mut own {
                Some((_, stretch)) => self.push(trajectory, stretch, block, &mut out),
                None => Ok(()),
            }
        };
        match file {
            None => self.logs.read_raw(&mut take)?,
            Some(file) => self.logs.read_raw_of(file, &mut take)?,
        }
        if let Some((ended, stretch)) = own {
            self.end(ended, stretch, &mut out)?;
        }
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
                    let raw = joined(self.logs.joints(), blocks);
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
                let raw = joined(self.logs.joints(), std::slice::from_ref(block));
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
                let raw = joined(self.logs.joints(), &blocks);
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

/// The first rows of the first trajectory.
fn first_rows(logs: &Logs) -> Result<Raw, LogError> {
    let mut blocks: Vec<RawBlock> = Vec::new();
    let mut rows = 0;
    let read = logs.read_raw(&mut |trajectory, block| -> Result<(), Halt> {
        if trajectory > 0 || rows >= FIRST_ROWS {
            return Err(Halt::Enough);
        }
        rows += block.t.len();
        blocks.push(block.clone());
        Ok(())
    });
    match read {
        Err(Halt::Error(error)) => Err(error),
        Ok(()) | Err(Halt::Enough) => Ok(joined(logs.joints(), &blocks)),
    }
}

/// Blocks of one trajectory, one after the other.
fn joined(joints: &[String], blocks: &[RawBlock]) -> Raw {
    let n = joints.len();
    let t: Vec<f64> = blocks.iter().flat_map(|block| &block.t).copied().collect();
    let place = {
        let mut places = Vec::with_capacity(t.len());
        for (index, block) in blocks.iter().enumerate() {
            places.extend((0..block.t.len()).map(|row| (index, row)));
        }
        places
    };
    let signal = |of: &dyn Fn(&RawBlock) -> Option<&Mat<f64>>| -> Option<Mat<f64>> {
        let parts: Vec<&Mat<f64>> = blocks.iter().map(of).collect::<Option<_>>()?;
        Some(Mat::from_fn(t.len(), n, |row, joint| {
            let (index, row) = place[row];
            parts[index][(row, joint)]
        }))
    };
    let q = signal(&|block| Some(&block.q)).unwrap_or_else(|| Mat::zeros(t.len(), n));
    let dq = signal(&|block| block.dq.as_ref());
    let ddq = signal(&|block| block.ddq.as_ref());
    let tau = signal(&|block| block.tau.as_ref());
    Raw { joints: joints.to_vec(), q, dq, ddq, tau, t }
}
