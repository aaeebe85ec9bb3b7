//! The mapping of a plain log: t, q1…qn, dq1…dqn, ddq1…ddqn, tau1…taun in SI units; joints may be
//! counted from 0.

use crate::error::{LogError, Result, shown};
use crate::mapping::{Mapping, Slot};
use std::path::Path;
use torquewise_motion::signals::Signal;

pub(crate) const MAX_COLUMNS: usize = 1_000;

pub(crate) fn plain(file: &Path, names: &[String]) -> Result<Mapping> {
    if names.len() > MAX_COLUMNS {
        let (file, found) = (file.into(), names.len());
        return Err(LogError::TooManyColumns { file, found, limit: MAX_COLUMNS });
    }
    let mut found = Found::default();
    for (column, name) in names.iter().enumerate() {
        found.add(file, column, name)?;
    }
    let lacks = |missing| {
        let found = shown(names.join(", ").as_bytes());
        LogError::NoColumn { file: file.into(), missing, found }
    };
    if !names.is_empty() && names.iter().all(|name| name.parse::<f64>().is_ok()) {
        return Err(LogError::NoHeader { file: file.into() });
    }
    let t = found.t.ok_or_else(|| lacks("t"))?;
    if found.signals[Signal::Q as usize].is_empty() {
        return Err(lacks("q1"));
    }
    // Every signal that occurs has joints 1…n, or all 0…n − 1.
    let signals = &found.signals;
    let is_zero = |found: &Vec<(usize, usize)>| found.first().is_some_and(|c| c.0 == 0);
    let first = usize::from(!signals.iter().any(is_zero));
    let last = |signal: Signal| signals[signal as usize].last().map_or(0, |c| c.0);
    let widest = Signal::ALL.into_iter().max_by_key(|s| (last(*s), *s == Signal::Q));
    let (widest, end) = widest.map_or((Signal::Q, 0), |signal| (signal, last(signal)));
    for signal in Signal::ALL {
        let joints = &signals[signal as usize];
        let gap = joints.iter().zip(first..).find(|(c, number)| c.0 != *number);
        let missing = gap.map_or(joints.len() + first, |(_, number)| number);
        if !joints.is_empty() && missing <= end {
            return Err(LogError::MissingColumn {
                file: file.into(),
                missing: format!("{}{missing}", signal.name()),
                present: format!("{}{end}", widest.name()),
            });
        }
    }
    let n_joints = end + 1 - first;
    let present = Signal::ALL.into_iter().filter(|s| !signals[*s as usize].is_empty()).collect();
    let chosen: Vec<_> = std::iter::once(t).chain(signals.iter().flatten().map(|c| c.1)).collect();
    let slots = (1..chosen.len()).map(Slot::as_it_stands).collect();
    let ignored = found.ignored;
    Ok(Mapping { n_joints, present, chosen, slots, ignored, ..Mapping::default() })
}

fn meaning(name: &str) -> Option<(Signal, usize)> {
    let digits = name.find(|c: char| c.is_ascii_digit())?;
    let (signal, number) = name.split_at(digits);
    let signal = Signal::ALL.into_iter().find(|known| known.name() == signal)?;
    let plain = number.bytes().all(|c| c.is_ascii_digit());
    let number = number.parse().ok().filter(|_| number.len() == 1 || !number.starts_with('0'));
    number.filter(|_| plain).map(|number| (signal, number))
}

/// Columns found so far; each signal as (joint number, column), in order of the joints.
#[derive(Default)]
struct Found {
    t: Option<usize>,
    signals: [Vec<(usize, usize)>; 4],
    ignored: Vec<String>,
}

impl Found {
    fn add(&mut self, file: &Path, column: usize, name: &str) -> Result<()> {
        let twice = || LogError::DuplicateColumn { file: file.into(), column: name.into() };
        if name == "t" {
            return self.t.replace(column).map_or(Ok(()), |_| Err(twice()));
        }
        let Some((signal, joint)) = meaning(name) else {
            self.ignored.push(name.to_owned());
            return Ok(());
        };
        let joints = &mut self.signals[signal as usize];
        match joints.binary_search_by_key(&joint, |found| found.0) {
            Ok(_) => Err(twice()),
            Err(place) => {
                joints.insert(place, (joint, column));
                Ok(())
            }
        }
    }
}

#[cfg(test)]
mod tests;
