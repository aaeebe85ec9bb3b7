//! The mapping of a plain log: t, q1…qn, dq1…dqn, ddq1…ddqn, tau1…taun in SI units; joints may be
//! counted from 0.

use crate::{LogError, Mapping, Result, Slot, shown};
use std::collections::BTreeMap;
use std::path::Path;
use torquewise_motion::Signal;

pub(crate) const MAX_COLUMNS: usize = 1_000;

pub(crate) fn plain(file: &Path, names: &[String]) -> Result<Mapping> {
    if names.len() > MAX_COLUMNS {
        let (file, found) = (file.into(), names.len());
        return Err(LogError::TooManyColumns { file, found, limit: MAX_COLUMNS });
    }
    let (mut t, mut ignored) = (None, Vec::new());
    let mut columns: BTreeMap<(Signal, usize), usize> = BTreeMap::new();
    for (column, name) in names.iter().enumerate() {
        let before = match meaning(name) {
            Some(signal_and_joint) => columns.insert(signal_and_joint, column),
            None if name == "t" => t.replace(column),
            None => {
                ignored.push(name.clone());
                None
            }
        };
        if before.is_some() {
            return Err(LogError::DuplicateColumn { file: file.into(), column: name.into() });
        }
    }
    let lacks = |missing| {
        let found = shown(names.join(", ").as_bytes());
        LogError::NoColumn { file: file.into(), missing, found }
    };
    if !names.is_empty() && names.iter().all(|name| name.parse::<f64>().is_ok()) {
        return Err(LogError::NoHeader { file: file.into() });
    }
    let t = t.ok_or_else(|| lacks("t"))?;
    let joints = |signal| -> Vec<usize> {
        columns.keys().filter(|(own, _)| *own == signal).map(|(_, joint)| *joint).collect()
    };
    if joints(Signal::Q).is_empty() {
        return Err(lacks("q1"));
    }
    // Every signal that occurs has joints 1…n, or all 0…n − 1.
    let first = usize::from(columns.keys().all(|(_, joint)| *joint > 0));
    let last = |signal| joints(signal).last().copied().unwrap_or(0);
    let widest = Signal::ALL.into_iter().max_by_key(|s| (last(*s), *s == Signal::Q));
    let (widest, end) = widest.map_or((Signal::Q, 0), |signal| (signal, last(signal)));
    for signal in Signal::ALL {
        let joints = joints(signal);
        let gap = joints.iter().zip(first..).find(|(joint, number)| **joint != *number);
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
    let present = Signal::ALL.into_iter().filter(|signal| !joints(*signal).is_empty()).collect();
    let chosen: Vec<_> = std::iter::once(t).chain(columns.into_values()).collect();
    let slots = (1..chosen.len()).map(Slot::as_it_stands).collect();
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

#[cfg(test)]
mod tests;
