//! Long work in a thread of its own: the calling thread shows its progress and listens to Ctrl-C.

use crate::errors::raised;
use pyo3::exceptions::PyOSError;
use pyo3::prelude::*;
use std::ffi::OsString;
use std::ops::ControlFlow;
use std::panic::resume_unwind;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread;
use std::time::{Duration, Instant};
use torquewise::motion::whole_file;
use torquewise::{Error, Event, Observer, Progress};

const LOOK: Duration = Duration::from_millis(50);

/// How often the bar is moved: once in so many milliseconds.
const SHOW: Duration = Duration::from_millis(100);

enum Told<T> {
    Event(Event),
    Done(Result<T, Error>),
}

/// Does work without the interpreter, with an observer to be handed to the engine, and shows it.
///
/// - `progress`: is called with what is done, how much since the last call and how much in all, if
///   that is known: rows, or starts, offers and cut-offs of stages that tell their share
pub(crate) fn work<T: Send + 'static>(
    py: Python<'_>,
    progress: Option<&Bound<'_, PyAny>>,
    job: impl FnOnce(Observer<'_>) -> Result<T, Error> + Send + 'static,
) -> PyResult<T> {
    let (sender, mut receiver) = channel();
    let stopped = Arc::new(AtomicBool::new(false));
    let worker = {
        let stopped = Arc::clone(&stopped);
        thread::spawn(move || run(&sender, &stopped, job))
    };
    let (mut bar, mut looked) = (Bar::new(progress), Instant::now());
    let found = loop {
        let told;
        (told, receiver) = py.detach(move || {
            let told = receiver.recv_timeout(LOOK);
            (told, receiver)
        });
        let stop = |_: &PyErr| stopped.store(true, Ordering::Relaxed);
        match told {
            Ok(Told::Event(event)) => bar.show(event).inspect_err(stop)?,
            Ok(Told::Done(found)) => break Some(found),
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => break None,
        }
        if looked.elapsed() >= LOOK {
            looked = Instant::now();
            py.check_signals().inspect_err(stop)?;
        }
    };
    if bar.rows > 0 {
        bar.call()?;
    }
    match (found, worker.join()) {
        (Some(found), _) => found.map_err(raised),
        (None, Err(panic)) => resume_unwind(panic),
        (None, Ok(())) => Err(raised(Error::Interrupted)),
    }
}

/// The worker: tells each event, and stops where it is told to.
fn run<T: Send>(
    sender: &Sender<Told<T>>,
    stopped: &AtomicBool,
    job: impl FnOnce(Observer<'_>) -> Result<T, Error>,
) {
    let found = job(&|event| {
        // Whoever does not listen any more has stopped the work.
        let is_quiet = event == Event::Stage(Progress::Working);
        if (is_quiet || sender.send(Told::Event(event)).is_ok()) && !stopped.load(Ordering::Relaxed)
        {
            ControlFlow::Continue(())
        } else {
            ControlFlow::Break(())
        }
    });
    // The same.
    let _ = sender.send(Told::Done(found));
}

/// Writes a file whole or not at all: beside it first, then renamed.
#[pyfunction]
pub(crate) fn write_whole(py: Python<'_>, path: PathBuf, content: &[u8]) -> PyResult<()> {
    let written = py.detach(|| whole_file::write_whole(&path, content));
    let told = |error| PyOSError::new_err(format!("{} cannot be written: {error}", path.display()));
    written.map_err(told)
}

/// Runs the command line, words from that of the program on; returns its exit code.
#[pyfunction]
pub(crate) fn command_line(py: Python<'_>, words: Vec<OsString>) -> u8 {
    py.detach(|| torquewise_cli::run(&words))
}

/// Calls a function of Python with what is done, not too often.
struct Bar<'a, 'py> {
    progress: Option<&'a Bound<'py, PyAny>>,
    doing: String,
    rows: usize,
    /// Rows in all.
    total: Option<u64>,
    /// What is done of a stage that tells its share.
    made: usize,
    shown: Instant,
}

impl<'a, 'py> Bar<'a, 'py> {
    fn new(progress: Option<&'a Bound<'py, PyAny>>) -> Self {
        let shown = Instant::now();
        Self { progress, doing: String::new(), rows: 0, total: None, made: 0, shown }
    }

    fn show(&mut self, event: Event) -> PyResult<()> {
        match event {
            Event::Rows(rows) => {
                self.rows += rows;
                if self.shown.elapsed() < SHOW { Ok(()) } else { self.call() }
            }
            Event::Reading { doing, rows } => {
                self.total = rows;
                self.begin(doing.to_owned())
            }
            Event::Stage(stage) => match stage.share() {
                None => self.begin(stage.to_string()),
                Some((made, most)) => {
                    if self.doing != stage.doing() || made < self.made {
                        self.begin(stage.doing().to_owned())?;
                    }
                    let more = made - std::mem::replace(&mut self.made, made);
                    self.tell(more, Some(most as u64))
                }
            },
        }
    }

    fn begin(&mut self, doing: String) -> PyResult<()> {
        self.call()?;
        (self.doing, self.made) = (doing, 0);
        self.call()
    }

    fn call(&mut self) -> PyResult<()> {
        let rows = std::mem::take(&mut self.rows);
        // A stage that reads no rows has no total of them.
        self.tell(rows, self.total.filter(|_| rows > 0))
    }

    fn tell(&mut self, more: usize, total: Option<u64>) -> PyResult<()> {
        self.shown = Instant::now();
        match self.progress {
            Some(progress) if !self.doing.is_empty() => {
                progress.call1((&self.doing, more, total)).map(drop)
            }
            _ => Ok(()),
        }
    }
}
