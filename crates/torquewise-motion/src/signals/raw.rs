//! Raw signals of one trajectory, checked and changed column by column.

use crate::{MotionError, Result};
use faer::Mat;

/// The signals of an arm.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[expect(missing_docs, reason = "as their names say")]
pub enum Signal {
    Q,
    Dq,
    Ddq,
    Tau,
}

impl Signal {
    /// All signals, in order.
    pub const ALL: [Self; 4] = [Self::Q, Self::Dq, Self::Ddq, Self::Tau];

    /// q, dq, ddq or tau: the name of its columns, before the number of the joint.
    pub fn name(self) -> &'static str {
        ["q", "dq", "ddq", "tau"][self as usize]
    }
}

/// What was measured of one trajectory of an arm with n joints, m rows.
#[derive(Clone, Debug, Default)]
pub struct Raw {
    /// Names of the n joints, base to tip.
    pub joints: Vec<String>,
    /// Time stamps \[s\], m, strictly increasing.
    pub t: Vec<f64>,
    /// Positions \[rad\], velocities \[rad/s\], accelerations \[rad/s²\] and torques \[N·m\], in the
    /// order of [`Signal::ALL`]: each n columns of m values. Positions must be there.
    pub signals: [Option<Vec<Vec<f64>>>; 4],
}

impl Raw {
    /// The columns of a signal, n; none where it was not measured.
    pub fn of(&self, signal: Signal) -> &[Vec<f64>] {
        self.signals[signal as usize].as_deref().unwrap_or_default()
    }

    /// Makes sure of shapes, finiteness and time order.
    pub(crate) fn check(&self) -> Result<()> {
        let expected = [self.t.len(), self.joints.len()];
        if self.joints.is_empty() {
            return Err(MotionError::NoJoints);
        }
        MotionError::check_finite("t", 0, &self.t)?;
        MotionError::check_order(&self.t)?;
        if self.signals[0].is_none() {
            return Err(MotionError::Missing("q"));
        }
        for (signal, columns) in self.present() {
            let rows = columns.iter().map(Vec::len).find(|rows| *rows != expected[0]);
            let found = [rows.unwrap_or(expected[0]), columns.len()];
            if found != expected {
                return Err(MotionError::Shape { signal: signal.name(), found, expected });
            }
            for (joint, (column, name)) in columns.iter().zip(&self.joints).enumerate() {
                MotionError::check_finite(signal.name(), joint, column)
                    .map_err(|e| e.of(signal.name(), name))?;
            }
        }
        Ok(())
    }

    pub(crate) fn present(&self) -> impl Iterator<Item = (Signal, &Vec<Vec<f64>>)> {
        let signals = Signal::ALL.into_iter().zip(&self.signals);
        signals.filter_map(|(signal, columns)| Some((signal, columns.as_ref()?)))
    }

    /// The rows named by `rows`, in that order.
    #[must_use]
    pub fn select(&self, rows: &[usize]) -> Self {
        let pick = |x: &Vec<f64>| -> Vec<f64> { rows.iter().map(|&row| x[row]).collect() };
        let signals = self.signals.each_ref();
        let signals = signals.map(|own| own.as_ref().map(|own| own.iter().map(pick).collect()));
        Self { joints: self.joints.clone(), t: pick(&self.t), signals }
    }

    /// Puts the rows of a block of the same signals behind these.
    pub fn append(&mut self, block: Self) {
        if self.t.is_empty() {
            *self = block;
            return;
        }
        self.t.extend(block.t);
        for (own, new) in self.signals.iter_mut().zip(block.signals) {
            own.iter_mut()
                .flatten()
                .zip(new.into_iter().flatten())
                .for_each(|(x, new)| x.extend(new));
        }
    }

    /// Takes the first rows away.
    pub fn forget(&mut self, rows: usize) {
        let rows = rows.min(self.t.len());
        self.t.drain(..rows);
        for column in self.signals.iter_mut().flatten().flatten() {
            column.drain(..rows);
        }
    }

    /// Every column through `work`, which is told the signal and the joint.
    pub(crate) fn map(
        &self,
        t: Vec<f64>,
        mut work: impl FnMut(Signal, usize, &[f64]) -> Result<Vec<f64>>,
    ) -> Result<Self> {
        let mut signals = [const { None }; 4];
        for (signal, columns) in self.present() {
            let mut mapped = Vec::with_capacity(columns.len());
            for (joint, column) in columns.iter().enumerate() {
                let done = work(signal, joint, column);
                mapped.push(done.map_err(|e| e.of(signal.name(), &self.joints[joint]))?);
            }
            signals[signal as usize] = Some(mapped);
        }
        Ok(Self { joints: self.joints.clone(), t, signals })
    }
}

pub(crate) fn matrix(columns: &[Vec<f64>]) -> Mat<f64> {
    let rows = columns.first().map_or(0, Vec::len);
    Mat::from_fn(rows, columns.len(), |row, joint| columns[joint][row])
}
