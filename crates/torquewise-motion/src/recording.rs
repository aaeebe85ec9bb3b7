//! Recordings: one or several trajectories, read in order as blocks, in fixed memory.

use crate::Motion;
use crate::signals::bandwidth::Band;

/// Rows of a block at most. Every reader cuts each trajectory at multiples of it, so that sums over
/// blocks are taken in the same order, and have the same bits, however a log is stored.
pub const BLOCK_ROWS: usize = 1024;

/// Whatever a reader met: the file, row and column are in its message.
pub type ReadError = Box<dyn std::error::Error + Send + Sync>;

/// What reading returns.
pub type ReadResult<T = ()> = Result<T, ReadError>;

/// Who is shown the blocks of a recording, and the index of their trajectory.
pub type Visit<'a> = &'a mut dyn FnMut(usize, &Motion) -> ReadResult;

/// Who is shown blocks, and noise beside each.
pub type VisitPair<'a> = &'a mut dyn FnMut(usize, &Motion, &Motion) -> ReadResult;

/// One or several trajectories of one arm that can be read through any number of times.
pub trait Recording {
    /// Joint names, base to tip.
    fn joints(&self) -> &[String];

    /// Calls `visit` with each block in order, at most [`BLOCK_ROWS`] rows each, and with the
    /// index of the trajectory it belongs to. No block holds rows of two trajectories.
    ///
    /// # Errors
    /// The reader's own, or the first that `visit` returns.
    fn read(&self, visit: Visit<'_>) -> ReadResult;

    /// Its trajectories, whole: for recordings that fit in memory.
    ///
    /// # Errors
    /// As [`read`](Self::read).
    fn trajectories(&self) -> ReadResult<Vec<Motion>> {
        let mut all: Vec<Vec<Motion>> = Vec::new();
        self.read(&mut |trajectory, block| {
            all.resize_with(trajectory + 1, Vec::new);
            all[trajectory].push(block.clone());
            Ok(())
        })?;
        let filled = all.iter().filter(|blocks| !blocks.is_empty());
        filled.map(|blocks| Ok(Motion::joined(self.joints(), blocks)?)).collect()
    }

    /// Whether its signals went through a filter, so that their noise is not white.
    fn is_filtered(&self) -> bool {
        false
    }

    /// Logs it is made of, one or more: what was recorded at one time, in one file.
    fn n_logs(&self) -> usize {
        1
    }

    /// Reads one of its logs, counted from 0, as [`read`](Self::read) does; no log beyond them has
    /// rows.
    ///
    /// # Errors
    /// As [`read`](Self::read).
    fn read_log(&self, log: usize, visit: Visit<'_>) -> ReadResult {
        if log == 0 { self.read(visit) } else { Ok(()) }
    }

    /// Reads one of its logs as [`read_log`](Self::read_log) does, each block beside what noise
    /// like that of the raw samples becomes on its way to the same rows: q, q̇ and q̈ of the second
    /// motion are that noise alone.
    ///
    /// Returns whether it can: false, and nothing is visited, where rows are as they were measured.
    ///
    /// - `seed`: of the noise, which depends on the seed and on the log alone
    ///
    /// # Errors
    /// As [`read`](Self::read).
    fn read_log_with_noise(&self, log: usize, seed: u64, visit: VisitPair<'_>) -> ReadResult<bool> {
        let _ = (log, seed, visit);
        Ok(false)
    }
}

/// Logs before their filter: what they become at any bandwidth, and with any delay of the torque.
pub trait RawRecording: Sync {
    /// The logs once cut-off and delay are chosen.
    type Filtered: Recording;

    /// Where a search for the bandwidth may begin: a cut-off \[Hz\].
    fn first_cutoff(&self) -> f64;

    /// Cut-offs worth trying \[Hz\], ascending; the one that is set.
    fn cutoffs(&self) -> Vec<f64>;

    /// Seconds by which the torque may lag the motion; those that are set.
    fn delays(&self) -> Vec<f64>;

    /// A sample of motion filtered at a cut-off, in the order of time, at the same instants for
    /// each, with the torque advanced by each delay. `None` where the logs are too short for it.
    ///
    /// # Errors
    /// As [`Recording::read`].
    fn band(&self, cutoff: f64, delays: &[f64]) -> ReadResult<Option<Band>>;

    /// All rows, filtered at a cut-off, their torque advanced by a delay.
    ///
    /// # Errors
    /// As [`Recording::read`].
    fn filtered(&self, cutoff: f64, delay: f64) -> Result<Self::Filtered, ReadError>;
}

impl Recording for Motion {
    fn joints(&self) -> &[String] {
        Motion::joints(self)
    }

    fn read(&self, visit: Visit<'_>) -> ReadResult {
        let rows: Vec<usize> = (0..self.n_rows()).collect();
        rows.chunks(BLOCK_ROWS).try_for_each(|block| visit(0, &self.select(block)))
    }
}

impl Recording for [Motion] {
    fn joints(&self) -> &[String] {
        self.first().map_or(&[], Motion::joints)
    }

    fn read(&self, visit: Visit<'_>) -> ReadResult {
        let mut all = self.iter().enumerate();
        all.try_for_each(|(trajectory, own)| own.read(&mut |_, block| visit(trajectory, block)))
    }

    fn n_logs(&self) -> usize {
        self.len()
    }

    fn read_log(&self, log: usize, visit: Visit<'_>) -> ReadResult {
        self.get(log).map_or(Ok(()), |own| own.read(visit))
    }
}
