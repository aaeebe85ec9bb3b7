//! From a log to logs to train and to test on, cut before anything is conditioned.

use crate::sets::Split;
use std::error::Error;
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};
use torquewise::motion::signals::Raw;
use torquewise::logs::{LogError, Logs};

/// Ways to cut each log, over which errors scatter.
pub(crate) const WAYS: usize = 3;
/// Part of the time that is tested on.
const TESTED: f64 = 0.3;

/// A row of a log: whether it is tested on, its stamp, and a line of its values.
struct Row {
    is_test: bool,
    line: String,
}

/// Writes the stretches of a log as files of their own; returns those to train and to test on.
pub(crate) fn written(
    logs: &Logs,
    (split, way): (Split, usize),
    folder: &Path,
) -> Result<[Vec<PathBuf>; 2], Box<dyn Error + Send + Sync>> {
    let (mut header, mut begin, mut end) = (String::new(), f64::INFINITY, f64::NEG_INFINITY);
    logs.read_raw(&mut |_, block| -> Result<(), LogError> {
        header = names(&block);
        begin = block.t.iter().copied().fold(begin, f64::min);
        end = block.t.iter().copied().fold(end, f64::max);
        Ok(())
    })?;
    let mut rows: Vec<Row> = Vec::new();
    logs.read_raw(&mut |_, block| -> Result<(), LogError> {
        for (row, t) in block.t.iter().enumerate() {
            let is_test = is_test((t - begin) / (end - begin), t - begin, split, way);
            rows.push(Row { is_test, line: line(&block, row) });
        }
        Ok(())
    })?;
    fs::create_dir_all(folder)?;
    let mut files = [Vec::new(), Vec::new()];
    for (place, stretch) in rows.chunk_by(|a, b| a.is_test == b.is_test).enumerate() {
        let path = folder.join(format!("{place:03}.csv"));
        let lines: Vec<&str> = stretch.iter().map(|row| row.line.as_str()).collect();
        let joints = logs.joints().join(",");
        fs::write(&path, format!("# joints: {joints}\n{header}\n{}\n", lines.join("\n")))?;
        files[usize::from(stretch[0].is_test)].push(path);
    }
    Ok(files)
}

/// - `part`: of the time of the log that has gone; `seconds`: the same
fn is_test(part: f64, seconds: f64, split: Split, way: usize) -> bool {
    match split {
        Split::Time => {
            let first = (1.0 - TESTED) * [1.0, 0.0, 0.5][way];
            (first..=first + TESTED).contains(&part)
        }
        Split::Blocks(block) => (seconds / block + way as f64) % 3.0 >= 2.0,
    }
}

fn signals(block: &Raw) -> Vec<(&'static str, &faer::Mat<f64>)> {
    let all = [
        ("q", Some(&block.q)),
        ("dq", block.dq.as_ref()),
        ("ddq", block.ddq.as_ref()),
        ("tau", block.tau.as_ref()),
    ];
    all.into_iter().filter_map(|(name, signal)| Some((name, signal?))).collect()
}

fn names(block: &Raw) -> String {
    let mut text = "t".to_owned();
    for (name, signal) in signals(block) {
        for joint in 1..=signal.ncols() {
            let _ = write!(text, ",{name}{joint}");
        }
    }
    text
}

fn line(block: &Raw, row: usize) -> String {
    let mut text = format!("{:?}", block.t[row]);
    for (_, signal) in signals(block) {
        for joint in 0..signal.ncols() {
            let _ = write!(text, ",{:?}", signal[(row, joint)]);
        }
    }
    text
}
