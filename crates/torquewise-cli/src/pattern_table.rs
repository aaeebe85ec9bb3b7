//! Counts of patterns, and a table with the number and the pattern of each row.

use crate::{Result, Table, staged};
use std::path::Path;
use torquewise::inspect::count_patterns;
use torquewise::logs::{Column, LogError, TableWriter, Values};
use torquewise::motion::Pattern;

pub(crate) struct PatternTable {
    writer: Option<TableWriter>,
    counts: [u64; 3],
}

impl PatternTable {
    pub(crate) fn create(file: Option<&Path>) -> Result<Self> {
        let columns =
            [Column::new("row", Values::Counts(&[])), Column::new("pattern", Values::Texts(&[]))];
        let create = |file| -> Result<_> { Ok(TableWriter::create(&staged(file)?, &columns)?) };
        Ok(Self { writer: file.map(create).transpose()?, counts: [0; 3] })
    }

    /// Takes the patterns of the next rows, which are counted from 1.
    pub(crate) fn append(&mut self, patterns: &[Pattern]) -> Result<(), LogError> {
        let before: u64 = self.counts.iter().sum();
        count_patterns(&mut self.counts, patterns);
        let names: Vec<&str> = patterns.iter().map(|pattern| pattern.name()).collect();
        let numbers: Vec<u64> = (before + 1..).take(names.len()).collect();
        let Some(writer) = &mut self.writer else { return Ok(()) };
        writer.append(&[Values::Counts(&numbers), Values::Texts(&names)])
    }

    /// Puts the table in its place and returns the rows of each pattern, least active first.
    pub(crate) fn finish(self) -> Result<[u64; 3], LogError> {
        self.writer.map(TableWriter::finish).transpose()?;
        Ok(self.counts)
    }
}

pub(crate) fn counts_text(counts: [u64; 3]) -> String {
    let total = counts.iter().sum::<u64>().max(1) as f64;
    let mut table = Table::new(["pattern", "rows", "share [%]"]);
    for (pattern, rows) in Pattern::ALL.iter().zip(counts) {
        let share = format!("{:.1}", 100.0 * rows as f64 / total);
        table.row(pattern.name(), [rows.to_string(), share]);
    }
    table.text()
}
