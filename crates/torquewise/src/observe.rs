//! Who watches long work, and may stop it.

use crate::Error;
use std::ops::ControlFlow;
use torquewise_motion::{Motion, ReadResult, Recording, Visit, VisitPair};
use torquewise_stepwise::Progress;

/// What an observer receives while work is under way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Event {
    /// Rows will be read, about so many if that is known.
    Reading {
        /// What for, such as `predicting`.
        doing: &'static str,
        /// Rows of a pass.
        rows: Option<u64>,
    },
    /// So many rows were read since the last event.
    Rows(usize),
    /// A stage of the fit begins.
    Stage(Progress),
}

/// Is told what is done, from several threads; work stops with [`Error::Interrupted`] where it
/// breaks, which it does from then on.
pub type Observer<'a> = &'a (dyn Fn(Event) -> ControlFlow<()> + Sync + 'a);

/// Nobody watches.
pub const NOBODY: Observer<'static> = &|_| ControlFlow::Continue(());

/// A recording whose rows are counted as they are read.
pub struct Watched<'a> {
    recording: &'a dyn Recording,
    pub(crate) observer: Observer<'a>,
}

impl<'a> Watched<'a> {
    /// Tells `observer` what the rows are read for, and of each block.
    ///
    /// - `rows`: how many there are, if that is known
    pub fn new(
        recording: &'a dyn Recording,
        observer: Observer<'a>,
        doing: &'static str,
        rows: Option<u64>,
    ) -> Self {
        // Whoever wants to stop is asked again at the first block.
        let _ = observer(Event::Reading { doing, rows });
        Self { recording, observer }
    }

    fn tell(&self, block: &Motion) -> ReadResult {
        let told = (self.observer)(Event::Rows(block.n_rows()));
        if told.is_continue() { Ok(()) } else { Err(Error::Interrupted.into()) }
    }
}

impl Recording for Watched<'_> {
    fn joints(&self) -> &[String] {
        self.recording.joints()
    }

    fn is_filtered(&self) -> bool {
        self.recording.is_filtered()
    }

    fn read(&self, visit: Visit<'_>) -> ReadResult {
        self.recording.read(&mut |trajectory, block| {
            self.tell(block)?;
            visit(trajectory, block)
        })
    }

    fn n_logs(&self) -> usize {
        self.recording.n_logs()
    }

    fn read_log(&self, log: usize, visit: Visit<'_>) -> ReadResult {
        self.recording.read_log(log, &mut |trajectory, block| {
            self.tell(block)?;
            visit(trajectory, block)
        })
    }

    fn read_log_with_noise(&self, log: usize, seed: u64, visit: VisitPair<'_>) -> ReadResult<bool> {
        self.recording.read_log_with_noise(log, seed, &mut |trajectory, block, noise| {
            self.tell(block)?;
            visit(trajectory, block, noise)
        })
    }
}
