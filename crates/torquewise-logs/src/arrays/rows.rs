//! From arrays to rows.

use crate::arrays::array::{Array, Arrays};
use crate::arrays::mat::Mat;
use crate::arrays::npz::Npz;
use crate::error::{LogError, Place};
use crate::rows::Rows;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Series of one array at most; a wider one, such as an image, is no signal of a robot.
const MAX_SERIES: usize = 256;

/// Columns of all arrays at most.
const MAX_COLUMNS: usize = 10_000;

/// A format that holds arrays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ArrayFormat {
    Npz,
    Mat,
}

/// The rows of a file of arrays: a matrix A has columns A1, A2, …, a vector A one column A.
pub(crate) struct ArrayRows {
    file: PathBuf,
    arrays: Box<dyn Arrays>,
    names: Vec<String>,
    /// For each column, its array and the series in it.
    series: Vec<(usize, usize)>,
    chosen: Vec<Vec<f64>>,
    row: usize,
}

impl ArrayRows {
    /// Reads names and shapes.
    pub(crate) fn open(file: &Path, format: ArrayFormat) -> Result<Self, LogError> {
        let arrays: Box<dyn Arrays> = match format {
            ArrayFormat::Npz => Box::new(Npz::open(file)?),
            ArrayFormat::Mat => Box::new(Mat::open(file)?),
        };
        let (mut names, mut series) = (Vec::new(), Vec::new());
        for (k, array) in arrays.arrays().iter().enumerate() {
            let (instants, n) = array.instants_and_series();
            if instants < 2 || n > MAX_SERIES {
                continue;
            }
            series.extend((0..n).map(|part| (k, part)));
            match n {
                1 => names.push(array.name.clone()),
                _ => names.extend((1..=n).map(|part| format!("{}{part}", array.name))),
            }
        }
        if names.len() > MAX_COLUMNS {
            let (file, found) = (file.into(), names.len());
            return Err(LogError::TooManyColumns { file, found, limit: MAX_COLUMNS });
        }
        let file = file.into();
        Ok(Self { file, arrays, names, series, chosen: Vec::new(), row: 0 })
    }

    fn array(&self, column: usize) -> &Array {
        &self.arrays.arrays()[self.series[column].0]
    }
}

impl Rows for ArrayRows {
    fn names(&self) -> &[String] {
        &self.names
    }

    fn choose(&mut self, columns: &[usize]) -> Result<(), LogError> {
        let instants = |column: usize| self.array(column).instants_and_series().0;
        if let Some((first, others)) = columns.split_first() {
            let expected = instants(*first);
            if let Some(other) = others.iter().find(|column| instants(**column) != expected) {
                return Err(LogError::ArrayLength {
                    file: self.file.clone(),
                    column: self.names[*other].clone(),
                    found: instants(*other),
                    first: self.names[*first].clone(),
                    expected,
                });
            }
        }
        let wanted: BTreeSet<usize> = columns.iter().map(|column| self.series[*column].0).collect();
        let loaded = self.arrays.load(&wanted)?;
        let values = |column: &usize| {
            let (array, part) = self.series[*column];
            let elements = loaded.get(&array).map_or(&[][..], Vec::as_slice);
            self.arrays.arrays()[array].series(elements, part)
        };
        self.chosen = columns.iter().map(values).collect();
        Ok(())
    }

    fn next(&mut self, row: &mut [f64]) -> Result<bool, LogError> {
        if self.chosen.first().is_none_or(|values| self.row >= values.len()) {
            return Ok(false);
        }
        for (value, values) in row.iter_mut().zip(&self.chosen) {
            *value = values[self.row];
        }
        self.row += 1;
        Ok(true)
    }

    fn place(&self) -> Place {
        Place { file: self.file.clone(), row: self.row as u64, line: None }
    }
}
