//! From CSV bytes to rows, one line at a time.

use crate::error::{LogError, Place, shown};
use crate::joints::{self, CSV_COMMENT};
use crate::lines::{Advance, Lines, MAX_LINE, split};
use crate::rows::Rows;
use std::io::BufRead;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Bytes of a field at most.
const MAX_FIELD: usize = 4_096;

/// The rows of a CSV text. Blank lines and lines that start with `#` are passed over.
pub(crate) struct CsvRows<R> {
    file: PathBuf,
    lines: Lines<R>,
    names: Vec<String>,
    joints: Option<Vec<String>>,
    chosen: Vec<usize>,
    fields: Vec<Range<usize>>,
    row: u64,
}

impl<R: BufRead> CsvRows<R> {
    /// Reads up to the header; `file` is named in errors.
    pub(crate) fn new(file: &Path, input: R) -> Result<Self, LogError> {
        let mut lines = Lines::new(input);
        let mut joints = None;
        let mut fields = Vec::new();
        if !next_line(file, &mut lines, &mut fields, Some(&mut joints))? {
            return Err(LogError::Empty { file: file.into() });
        }
        let names = header(file, &lines, &fields)?;
        let file = file.into();
        Ok(Self { file, lines, names, joints, chosen: Vec::new(), fields, row: 0 })
    }

    fn number(&self, column: usize) -> Result<f64, LogError> {
        let text = self.lines.line()[self.fields[column].clone()].trim_ascii();
        let number = std::str::from_utf8(text).ok().and_then(|text| text.parse().ok());
        number.ok_or_else(|| LogError::NotANumber {
            place: self.place(),
            column: self.names[column].clone(),
            text: shown(text),
        })
    }
}

impl<R: BufRead> Rows for CsvRows<R> {
    fn names(&self) -> &[String] {
        &self.names
    }

    fn joints(&self) -> Option<&[String]> {
        self.joints.as_deref()
    }

    fn choose(&mut self, columns: &[usize]) -> Result<(), LogError> {
        self.chosen = columns.to_vec();
        Ok(())
    }

    fn next(&mut self, row: &mut [f64]) -> Result<bool, LogError> {
        if !next_line(&self.file, &mut self.lines, &mut self.fields, None)? {
            return Ok(false);
        }
        self.row += 1;
        let (found, expected) = (self.fields.len(), self.names.len());
        if found != expected {
            return Err(LogError::Ragged { place: self.place(), found, expected });
        }
        for (value, column) in row.iter_mut().zip(&self.chosen) {
            *value = self.number(*column)?;
        }
        Ok(true)
    }

    fn place(&self) -> Place {
        Place { file: self.file.clone(), row: self.row, line: Some(self.lines.number()) }
    }
}

/// Advances to the next line with fields and splits it; `false` at the end.
fn next_line<R: BufRead>(
    file: &Path,
    lines: &mut Lines<R>,
    fields: &mut Vec<Range<usize>>,
    mut names: Option<&mut Option<Vec<String>>>,
) -> Result<bool, LogError> {
    loop {
        match lines.advance().map_err(LogError::read(file))? {
            Advance::End => return Ok(false),
            Advance::TooLong => return Err(too_long(file, lines, "line", MAX_LINE)),
            Advance::Line => {}
        }
        let line = lines.line();
        if line.first() == Some(&b'#') {
            if let Some(names) = names.as_deref_mut() {
                *names = joint_names(file, lines)?.or(names.take());
            }
        } else if !line.trim_ascii().is_empty() {
            if !split(line, fields) {
                return Err(LogError::OpenQuote { file: file.into(), line: lines.number() });
            }
            if line.len() > MAX_FIELD && fields.iter().any(|field| field.len() > MAX_FIELD) {
                return Err(too_long(file, lines, "field", MAX_FIELD));
            }
            return Ok(true);
        }
    }
}

/// The names in a line `# joints: shoulder,elbow`.
fn joint_names<R: BufRead>(file: &Path, lines: &Lines<R>) -> Result<Option<Vec<String>>, LogError> {
    let Some(names) = lines.line().strip_prefix(CSV_COMMENT.as_bytes()) else {
        return Ok(None);
    };
    let not_utf8 = |_| LogError::NotUtf8 { file: file.into(), line: lines.number() };
    Ok(Some(joints::parse(std::str::from_utf8(names).map_err(not_utf8)?)))
}

/// The names in the header line.
fn header<R: BufRead>(
    file: &Path,
    lines: &Lines<R>,
    fields: &[Range<usize>],
) -> Result<Vec<String>, LogError> {
    let not_utf8 = |_| LogError::NotUtf8 { file: file.into(), line: lines.number() };
    let header = std::str::from_utf8(lines.line()).map_err(not_utf8)?;
    if let ([_], Some(found)) = (fields, header.chars().find(|c| matches!(c, ';' | '\t'))) {
        return Err(LogError::Delimiter { file: file.into(), found });
    }
    Ok(fields.iter().map(|field| header[field.clone()].trim().to_owned()).collect())
}

fn too_long<R: BufRead>(
    file: &Path,
    lines: &Lines<R>,
    part: &'static str,
    limit: usize,
) -> LogError {
    LogError::TooLong { file: file.into(), line: lines.number(), part, limit }
}

#[cfg(test)]
mod tests;
