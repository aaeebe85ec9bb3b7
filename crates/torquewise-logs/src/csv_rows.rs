//! Rows of a CSV file, one line at a time.

use crate::joints;
use crate::lines::{Lines, MAX_LINE, split};
use crate::{CSV_COMMENT, LogError, Result, RowPlace, Rows, shown};
use std::io::BufRead;
use std::ops::Range;
use std::path::{Path, PathBuf};

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
    pub(crate) fn new(file: &Path, input: R) -> Result<Self> {
        let mut rows = Self {
            file: file.into(),
            lines: Lines::new(input),
            names: Vec::new(),
            joints: None,
            chosen: Vec::new(),
            fields: Vec::new(),
            row: 0,
        };
        if !rows.next_line()? {
            return Err(LogError::Empty { file: rows.file });
        }
        rows.names = rows.header()?;
        Ok(rows)
    }

    /// Advances to the next line with fields and splits it; `false` at the end.
    fn next_line(&mut self) -> Result<bool> {
        loop {
            if !self.lines.advance().map_err(LogError::read(&self.file))? {
                return Ok(false);
            }
            let line = &self.lines.line[..];
            if line.len() > MAX_LINE {
                return Err(self.too_long("line", MAX_LINE));
            }
            if line.first() == Some(&b'#') {
                // The names of joints stand before the header: `# joints: shoulder,elbow`.
                let names = line.strip_prefix(CSV_COMMENT.as_bytes());
                if let Some(names) = names.filter(|_| self.names.is_empty()) {
                    self.joints = Some(joints::parse(self.text(names)?));
                }
            } else if !line.trim_ascii().is_empty() {
                if !split(line, &mut self.fields) {
                    let (file, line) = (self.file.clone(), self.lines.number);
                    return Err(LogError::OpenQuote { file, line });
                }
                if self.fields.iter().any(|field| field.len() > MAX_FIELD) {
                    return Err(self.too_long("field", MAX_FIELD));
                }
                return Ok(true);
            }
        }
    }

    fn header(&self) -> Result<Vec<String>> {
        let header = self.text(&self.lines.line)?;
        let found = header.chars().find(|c| matches!(c, ';' | '\t'));
        if let (1, Some(found)) = (self.fields.len(), found) {
            return Err(LogError::Delimiter { file: self.file.clone(), found });
        }
        Ok(self.fields.iter().map(|field| header[field.clone()].trim().to_owned()).collect())
    }

    fn text<'t>(&self, bytes: &'t [u8]) -> Result<&'t str> {
        let not_utf8 = |_| LogError::NotUtf8 { file: self.file.clone(), line: self.lines.number };
        std::str::from_utf8(bytes).map_err(not_utf8)
    }

    fn too_long(&self, part: &'static str, limit: usize) -> LogError {
        LogError::TooLong { file: self.file.clone(), line: self.lines.number, part, limit }
    }

    fn number(&self, column: usize) -> Result<f64> {
        let text = self.lines.line[self.fields[column].clone()].trim_ascii();
        if text.is_empty() {
            // As a table of missing values is written.
            return Ok(f64::NAN);
        }
        let number = std::str::from_utf8(text).ok().and_then(|text| text.parse().ok());
        number.ok_or_else(|| LogError::NotANumber {
            place: self.place(),
            column: self.names[column].clone(),
            text: shown(text),
        })
    }
}

impl<R: BufRead> Rows for CsvRows<R> {
    fn header(&self) -> (&[String], Option<&[String]>) {
        (&self.names, self.joints.as_deref())
    }

    fn choose(&mut self, columns: &[usize]) -> Result<()> {
        self.chosen = columns.to_vec();
        Ok(())
    }

    fn next(&mut self, row: &mut [f64]) -> Result<bool> {
        if !self.next_line()? {
            return Ok(false);
        }
        self.row += 1;
        let (found, expected) = (self.fields.len(), self.names.len());
        let is_short = found < expected && self.lines.is_cut_off;
        if found != expected && !is_short {
            return Err(LogError::Ragged { place: self.place(), found, expected });
        }
        for (value, column) in row.iter_mut().zip(&self.chosen) {
            // A logger that was stopped cuts its last line off within a number.
            let is_cut = self.lines.is_cut_off && column + 1 >= found;
            let number = if is_cut && is_short { Ok(f64::NAN) } else { self.number(*column) };
            *value = if is_cut { number.unwrap_or(f64::NAN) } else { number? };
        }
        Ok(true)
    }

    fn place(&self) -> RowPlace {
        RowPlace { file: self.file.clone(), row: self.row, line: Some(self.lines.number) }
    }
}

#[cfg(test)]
pub(crate) mod tests;
