//! Rows of a log joined with those of further files.

use crate::{LogError, Result, RowPlace, Rows};
use std::path::PathBuf;

/// Clocks may differ by this \[s\], and by a few roundings of a long time.
const CLOCK_TOLERANCE: f64 = 1e-6;

/// A file with the same rows as the log: what its columns are called with (`NAME.column`), where it
/// is, and its rows.
pub(crate) type Beside = (String, PathBuf, Box<dyn Rows>);

/// The clock of the log: name of its column, and seconds of its unit.
pub(crate) type ClockColumn = (String, f64);

pub(crate) struct SideBySide {
    parts: Vec<Part>,
    names: Vec<String>,
    clock: Option<ClockColumn>,
    /// For each chosen column, its part and its place in the row of it.
    chosen: Vec<(usize, usize)>,
}

struct Part {
    file: PathBuf,
    rows: Box<dyn Rows>,
    /// Place of its first column among all.
    first: usize,
    row: Vec<f64>,
    clock: Option<usize>,
}

impl SideBySide {
    pub(crate) fn new(
        log: (PathBuf, Box<dyn Rows>),
        beside: Vec<Beside>,
        clock: Option<ClockColumn>,
    ) -> Self {
        let mut names = log.1.names().to_vec();
        let part = |file, rows, first| Part { file, rows, first, row: Vec::new(), clock: None };
        let mut parts = vec![part(log.0, log.1, 0)];
        for (name, file, rows) in beside {
            let first = names.len();
            names.extend(rows.names().iter().map(|column| format!("{name}.{column}")));
            parts.push(part(file, rows, first));
        }
        Self { parts, names, clock, chosen: Vec::new() }
    }

    fn check_clocks(&self) -> Result<()> {
        let Some((column, seconds)) = &self.clock else { return Ok(()) };
        let clock = |part: &Part| part.clock.map(|place| part.row[place] * seconds);
        let Some(expected) = self.parts.first().and_then(clock) else { return Ok(()) };
        for part in &self.parts[1..] {
            let Some(found) = clock(part) else { continue };
            let tolerance = CLOCK_TOLERANCE + 4.0 * f64::EPSILON * expected.abs();
            if (found - expected).abs() > tolerance || found.is_nan() != expected.is_nan() {
                let (place, column) = (part.rows.place(), column.clone());
                let problem =
                    format!(": column {column} is {found} s, in the log it is {expected} s");
                return Err(LogError::unusable(place, &problem, "give files of the same clock"));
            }
        }
        Ok(())
    }
}

impl Rows for SideBySide {
    fn header(&self) -> (&[String], Option<&[String]>) {
        (&self.names, self.parts.first().and_then(|log| log.rows.joints()))
    }

    fn choose(&mut self, columns: &[usize]) -> Result<()> {
        self.chosen.clear();
        let mut own: Vec<Vec<usize>> = vec![Vec::new(); self.parts.len()];
        for column in columns {
            let k = self.parts.partition_point(|part| part.first <= *column) - 1;
            self.chosen.push((k, own[k].len()));
            own[k].push(column - self.parts[k].first);
        }
        for (part, mut own) in self.parts.iter_mut().zip(own) {
            if own.is_empty() {
                return Err(LogError::unusable(
                    part.file.display(),
                    ": no column of it is used",
                    "name its columns as NAME.column, or drop it from [beside]",
                ));
            }
            let clock = self.clock.as_ref().map(|(name, _)| name);
            let clock = part.rows.names().iter().position(|name| Some(name) == clock);
            part.clock = clock.map(|_| own.len());
            own.extend(clock);
            part.rows.choose(&own)?;
            part.row = vec![0.0; own.len()];
        }
        Ok(())
    }

    fn next(&mut self, row: &mut [f64]) -> Result<bool> {
        let own = self.parts.iter_mut().map(|part| part.rows.next(&mut part.row));
        let had_one = own.collect::<Result<Vec<bool>>>()?;
        if !had_one.contains(&true) {
            return Ok(false);
        }
        if had_one.contains(&false) {
            let mut counts = Vec::new();
            for (part, had_one) in self.parts.iter_mut().zip(&had_one) {
                while *had_one && part.rows.next(&mut part.row)? {}
                counts.push(part.rows.place().row);
            }
            let expected = counts[0];
            let other = counts.iter().position(|count| *count != expected).unwrap_or_default();
            let (log, found) = (self.parts[0].file.display(), counts[other]);
            let problem = format!(" has {found} rows, {log} has {expected}");
            let help = "files beside each other have the same rows";
            return Err(LogError::unusable(self.parts[other].file.display(), &problem, help));
        }
        self.check_clocks()?;
        for (value, (part, place)) in row.iter_mut().zip(&self.chosen) {
            *value = self.parts[*part].row[*place];
        }
        Ok(true)
    }

    fn place(&self) -> RowPlace {
        self.parts[0].rows.place()
    }
}
