//! Tables in memory that another program holds, read where they lie.

use crate::{LogError, Result, RowPlace, Rows};
use std::fmt::Debug;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use torquewise_motion::BLOCK_ROWS;

/// Columns of numbers of one length, held by whoever implements this: arrays of NumPy, a data frame.
///
/// They are read some rows at a time, so that no whole column is copied.
pub trait Frame: Debug + Send + Sync {
    /// What its columns are called: as those of a file.
    fn names(&self) -> &[String];

    /// Joint names, base to tip, if they are known.
    fn joints(&self) -> Option<&[String]> {
        None
    }

    /// Rows of each column.
    fn n_rows(&self) -> usize;

    /// Puts the values of a column from row `first` on into `values`, which end within the column.
    ///
    /// # Errors
    /// Why they cannot be had.
    fn read(&self, column: usize, first: usize, values: &mut [f64]) -> Result<(), String>;
}

pub(crate) struct FrameRows {
    label: PathBuf,
    frame: Arc<dyn Frame>,
    chosen: Vec<usize>,
    block: Vec<Vec<f64>>,
    /// Rows handed out.
    row: usize,
}

impl FrameRows {
    pub(crate) fn new(label: &Path, frame: Arc<dyn Frame>) -> Self {
        let (chosen, block) = (Vec::new(), Vec::new());
        Self { label: label.into(), frame, chosen, block, row: 0 }
    }
}

impl Rows for FrameRows {
    fn header(&self) -> (&[String], Option<&[String]>) {
        (self.frame.names(), self.frame.joints())
    }

    fn choose(&mut self, columns: &[usize]) -> Result<()> {
        self.chosen = columns.to_vec();
        self.block = vec![Vec::new(); columns.len()];
        Ok(())
    }

    fn next(&mut self, row: &mut [f64]) -> Result<bool> {
        if self.row >= self.frame.n_rows() {
            return Ok(false);
        }
        let within = self.row % BLOCK_ROWS;
        if within == 0 {
            let rows = (self.frame.n_rows() - self.row).min(BLOCK_ROWS);
            for (column, values) in self.chosen.iter().zip(&mut self.block) {
                values.resize(rows, 0.0);
                self.frame.read(*column, self.row, values).map_err(|reason| {
                    let (file, row) = (self.label.clone(), self.row as u64 + 1);
                    let column = self.frame.names()[*column].clone();
                    let problem = format!(", column {column} cannot be read: {reason}");
                    let place = RowPlace { file, row, line: None };
                    LogError::unusable(place, &problem, "give a table of numbers")
                })?;
            }
        }
        for (value, values) in row.iter_mut().zip(&self.block) {
            *value = values[within];
        }
        self.row += 1;
        Ok(true)
    }

    fn place(&self) -> RowPlace {
        RowPlace { file: self.label.clone(), row: self.row as u64, line: None }
    }

    fn count(&self) -> Option<u64> {
        Some(self.frame.n_rows() as u64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Logs, Options};

    #[derive(Debug)]
    struct Columns {
        names: Vec<String>,
        values: Vec<Vec<f64>>,
    }

    impl Frame for Columns {
        fn names(&self) -> &[String] {
            &self.names
        }

        fn n_rows(&self) -> usize {
            self.values[0].len()
        }

        fn read(&self, column: usize, first: usize, values: &mut [f64]) -> Result<(), String> {
            if self.names[column] == "tau1" && first > 0 {
                return Err("it is gone".to_owned());
            }
            values.copy_from_slice(&self.values[column][first..first + values.len()]);
            Ok(())
        }
    }

    fn columns(rows: usize, names: &[&str]) -> Arc<dyn Frame> {
        let t = (0..rows).map(|row| 0.01 * row as f64);
        let values = (0..names.len()).map(|k| t.clone().map(|t| t + k as f64).collect());
        let names = names.iter().map(|&name| name.to_owned()).collect();
        Arc::new(Columns { names, values: values.collect() })
    }

    #[test]
    fn a_frame_is_read_as_a_file_of_the_same_rows() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("log.csv");
        let text = (0..2500).map(|row| {
            let t = 0.01 * f64::from(row);
            format!("{},{t},{}\n", t + 2.0, t + 1.0)
        });
        std::fs::write(&file, "dq1,t,q1\n".to_owned() + &text.collect::<String>()).unwrap();
        let frame = columns(2500, &["t", "q1", "dq1"]);

        let from_frame = Logs::of_frames(&[("arrays".into(), frame)], &Options::default()).unwrap();

        assert_eq!(from_frame.rows_hint(), Some(2500));
        let from_file = Logs::open(&[file]).unwrap();
        let [of_frame, of_file] = [&from_frame, &from_file].map(|logs| logs.read_all().unwrap());
        assert_eq!(format!("{of_frame:?}"), format!("{of_file:?}"));
    }

    #[test]
    fn what_cannot_be_read_is_told_with_frame_row_and_column_and_no_positions_or_rows_are_refused()
    {
        let frame = columns(2000, &["t", "q1", "tau1"]);
        let logs = Logs::of_frames(&[("arrays".into(), frame)], &Options::default()).unwrap();

        let message = logs.read_all().unwrap_err().to_string();

        assert!(message.starts_with("arrays, row 1025, column tau1 cannot be read"), "{message}");
        let open = |rows, names: &[&str]| {
            let frames = [("arrays".into(), columns(rows, names))];
            Logs::of_frames(&frames, &Options::default()).and_then(|logs| logs.read_all())
        };

        assert!(matches!(open(9, &["t", "x"]), Err(LogError::NoColumn { .. })));
        assert!(matches!(open(0, &["t", "q1"]), Err(LogError::NoRows { .. })));
    }
}
