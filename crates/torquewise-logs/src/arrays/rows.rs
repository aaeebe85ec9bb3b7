//! Rows of arrays.

use crate::arrays::array::{Array, MAX_COLUMNS};
use crate::arrays::numbers::Numbers;
use crate::arrays::{mat, npz};
use crate::{Format, LogError, LogInput, Result, RowPlace, Rows};
use std::collections::BTreeMap;

/// The rows of a file of arrays: a matrix A has columns A1, A2, …, a vector A one column A.
pub(crate) struct ArrayRows {
    file: LogInput,
    arrays: Vec<Array>,
    names: Vec<String>,
    /// For each column, its array and the series in it.
    series: Vec<(usize, usize)>,
    streams: Vec<Stream>,
    /// Instants of the chosen columns, and rows handed out.
    instants: usize,
    row: usize,
}

/// Elements of an array that are read side by side: all series of one instant, or one series.
struct Stream {
    numbers: Numbers,
    instant: Vec<f64>,
    /// Series of the instant, and the chosen column that each is.
    columns: Vec<(usize, usize)>,
    is_last: bool,
}

impl ArrayRows {
    pub(crate) fn open(file: &LogInput, format: Format) -> Result<Self> {
        let arrays = if format == Format::Mat { mat::arrays(file)? } else { npz::arrays(file)? };
        let (mut names, mut series) = (Vec::new(), Vec::new());
        for (k, array) in arrays.iter().enumerate() {
            let (_, n) = array.instants_and_series();
            series.extend((0..n).map(|part| (k, part)));
            match n {
                1 => names.push(array.name.clone()),
                _ => names.extend((1..=n).map(|part| format!("{}{part}", array.name))),
            }
            if names.len() > MAX_COLUMNS {
                let (file, found) = (file.into(), names.len());
                return Err(LogError::TooManyColumns { file, found, limit: MAX_COLUMNS });
            }
        }
        let file = file.clone();
        Ok(Self { file, arrays, names, series, streams: Vec::new(), instants: 0, row: 0 })
    }

    fn array(&self, column: usize) -> &Array {
        &self.arrays[self.series[column].0]
    }
}

impl Rows for ArrayRows {
    fn header(&self) -> (&[String], Option<&[String]>) {
        (&self.names, None)
    }

    fn choose(&mut self, columns: &[usize]) -> Result<()> {
        let instants = |column: usize| self.array(column).instants_and_series().0;
        if let Some((first, others)) = columns.split_first() {
            let expected = instants(*first);
            if let Some(other) = others.iter().find(|column| instants(**column) != expected) {
                let problem = format!(
                    ": column {} has {} values, column {} has {expected}",
                    self.names[*other],
                    instants(*other),
                    self.names[*first],
                );
                let help = "use arrays with the same number of instants";
                return Err(LogError::unusable(self.file.display(), &problem, help));
            }
        }
        self.instants = columns.first().map_or(0, |first| instants(*first));
        // What is read to have the chosen columns, each array as it is stored: by array, and by the
        // first series of what is read together.
        let mut wanted: BTreeMap<(usize, usize), Vec<(usize, usize)>> = BTreeMap::new();
        for (place, column) in columns.iter().enumerate() {
            let (array, series) = self.series[*column];
            let (first, within) =
                if self.array(*column).is_by_instant() { (0, series) } else { (series, 0) };
            wanted.entry((array, first)).or_default().push((within, place));
        }
        let stream = |((array, first), columns): (_, Vec<_>)| {
            let own: &Array = &self.arrays[array];
            let (instants, series) = own.instants_and_series();
            let numbers = own.numbers(&self.file, (first * instants) as u64)?;
            let width = if own.is_by_instant() { series } else { 1 };
            let is_last = own.is_by_instant() || first + 1 == series;
            Ok(Stream { numbers, instant: vec![0.0; width], columns, is_last })
        };
        self.streams = wanted.into_iter().map(stream).collect::<Result<_>>()?;
        Ok(())
    }

    fn next(&mut self, row: &mut [f64]) -> Result<bool> {
        let damaged = LogError::decode(&self.file, Format::of(&self.file)?);
        if self.row == self.instants {
            for stream in self.streams.iter_mut().filter(|stream| stream.is_last) {
                stream.numbers.finish().map_err(&damaged)?;
            }
            return Ok(false);
        }
        for stream in &mut self.streams {
            stream.numbers.read(&mut stream.instant).map_err(&damaged)?;
            for (series, column) in &stream.columns {
                row[*column] = stream.instant[*series];
            }
        }
        self.row += 1;
        Ok(true)
    }

    fn place(&self) -> RowPlace {
        RowPlace { file: (&self.file).into(), row: self.row as u64, line: None }
    }
}
