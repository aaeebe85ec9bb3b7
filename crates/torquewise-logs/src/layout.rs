//! Column names → layout: which column of a file is which signal of which joint.

use crate::error::{LogError, shown};
use std::path::Path;

/// Columns a file may have at most.
pub(crate) const MAX_COLUMNS: usize = 1_000;

/// A signal with one column per joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Signal {
    Q,
    Dq,
    Ddq,
    Tau,
}

impl Signal {
    /// All signals, in the order of the slots of a [`Layout`].
    pub(crate) const ALL: [Self; 4] = [Self::Q, Self::Dq, Self::Ddq, Self::Tau];

    /// The name of its columns, before the number of the joint.
    pub(crate) fn name(self) -> &'static str {
        ["q", "dq", "ddq", "tau"][self as usize]
    }

    /// The signal and the joint number that a column name means.
    fn of_column(name: &str) -> Option<(Self, usize)> {
        let digits = name.find(|c: char| c.is_ascii_digit())?;
        let (signal, number) = name.split_at(digits);
        let signal = Self::ALL.into_iter().find(|known| known.name() == signal)?;
        let plain = number.bytes().all(|c| c.is_ascii_digit());
        let number = number.parse().ok().filter(|n| *n == 0 || !number.starts_with('0'));
        number.filter(|_| plain).map(|number| (signal, number))
    }
}

/// Where the signals of a file stand.
///
/// A row that was read has one slot per column in use: t, then q1…qn, then dq, ddq and tau as far
/// as the file has them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Layout {
    n_joints: usize,
    n_columns: usize,
    present: Vec<Signal>,
    columns: Vec<usize>,
    ignored: Vec<String>,
}

impl Layout {
    /// Finds the signals among the column names of `file`.
    pub(crate) fn new(file: &Path, names: &[&str]) -> Result<Self, LogError> {
        let n_columns = names.len();
        if n_columns > MAX_COLUMNS {
            let file = file.into();
            return Err(LogError::TooManyColumns { file, found: n_columns, limit: MAX_COLUMNS });
        }
        let mut found = Found::default();
        for (column, name) in names.iter().enumerate() {
            found.add(file, column, name.trim())?;
        }
        let lacks = |missing| {
            let found = shown(names.join(", ").as_bytes());
            LogError::NoColumn { file: file.into(), missing, found }
        };
        let t = found.t.ok_or_else(|| lacks("t"))?;
        if found.signals[Signal::Q as usize].is_empty() {
            return Err(lacks("q1"));
        }
        let n_joints = found.count_joints(file)?;
        let signals = &found.signals;
        let present =
            Signal::ALL.into_iter().filter(|s| !signals[*s as usize].is_empty()).collect();
        let columns = std::iter::once(t).chain(signals.iter().flatten().map(|c| c.1)).collect();
        Ok(Self { n_joints, n_columns, present, columns, ignored: found.ignored })
    }

    /// Number of joints n.
    pub(crate) fn n_joints(&self) -> usize {
        self.n_joints
    }

    /// Columns of the file, those that are not used among them.
    pub(crate) fn n_columns(&self) -> usize {
        self.n_columns
    }

    /// The column of the file that fills each slot.
    pub(crate) fn columns(&self) -> &[usize] {
        &self.columns
    }

    /// The slot of joint 1 of a signal; the other joints follow.
    pub(crate) fn slot(&self, signal: Signal) -> Option<usize> {
        let place = self.present.iter().position(|present| *present == signal)?;
        Some(1 + place * self.n_joints)
    }

    /// The column name of a slot.
    pub(crate) fn name(&self, slot: usize) -> String {
        match slot.checked_sub(1) {
            None => "t".to_owned(),
            Some(place) => {
                let signal = self.present[place / self.n_joints];
                format!("{}{}", signal.name(), place % self.n_joints + 1)
            }
        }
    }

    /// Columns with names that mean nothing here.
    pub(crate) fn ignored(&self) -> &[String] {
        &self.ignored
    }
}

/// Columns found so far; each signal as (joint number, column), in order of the joints.
#[derive(Default)]
struct Found {
    t: Option<usize>,
    signals: [Vec<(usize, usize)>; 4],
    ignored: Vec<String>,
}

impl Found {
    fn add(&mut self, file: &Path, column: usize, name: &str) -> Result<(), LogError> {
        let twice = || LogError::DuplicateColumn { file: file.into(), column: name.into() };
        if name == "t" {
            return self.t.replace(column).map_or(Ok(()), |_| Err(twice()));
        }
        let Some((signal, joint)) = Signal::of_column(name) else {
            self.ignored.push(name.to_owned());
            return Ok(());
        };
        if joint == 0 {
            return Err(LogError::ZeroBased { file: file.into(), column: name.into() });
        }
        let joints = &mut self.signals[signal as usize];
        match joints.binary_search_by_key(&joint, |found| found.0) {
            Ok(_) => Err(twice()),
            Err(place) => {
                joints.insert(place, (joint, column));
                Ok(())
            }
        }
    }

    /// n, if every signal that occurs has joints 1…n.
    fn count_joints(&self, file: &Path) -> Result<usize, LogError> {
        let last = |signal: Signal| self.signals[signal as usize].last().map_or(0, |c| c.0);
        let widest = Signal::ALL.into_iter().max_by_key(|s| (last(*s), *s == Signal::Q));
        let (widest, n) = widest.map_or((Signal::Q, 0), |signal| (signal, last(signal)));
        for signal in Signal::ALL {
            let joints = &self.signals[signal as usize];
            let gap = joints.iter().zip(1..).find(|(c, number)| c.0 != *number);
            let missing = gap.map_or(joints.len() + 1, |(_, number)| number);
            if !joints.is_empty() && missing <= n {
                return Err(LogError::MissingColumn {
                    file: file.into(),
                    missing: format!("{}{missing}", signal.name()),
                    present: format!("{}{n}", widest.name()),
                });
            }
        }
        Ok(n)
    }
}

#[cfg(test)]
mod tests;
