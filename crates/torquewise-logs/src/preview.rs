//! The first rows of a log as they stand in it, for whoever has to say what its columns mean.

use crate::source::named_rows;
use crate::{LogInput, Result, Rows};
use serde::Serialize;

const MOST_COLUMNS: usize = 200;

/// A column of a log.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PreviewColumn {
    /// Its name.
    pub name: String,
    /// Its first values, NaN where one is missing; none at all where one is no number.
    pub values: Vec<f64>,
}

/// The columns of a log, whatever they are called, with their first values.
///
/// # Errors
/// `LogError` if the file cannot be read.
pub fn preview(file: &LogInput, rows: usize) -> Result<Vec<PreviewColumn>> {
    let log = named_rows(file)?;
    let names: Vec<String> = log.names().iter().take(MOST_COLUMNS).cloned().collect();
    let all: Vec<usize> = (0..names.len()).collect();
    let values = first_values(log, &all, rows).unwrap_or_else(|_| {
        // One by one, so that a column of words takes no other with it.
        let own = |&column: &usize| {
            let values = named_rows(file).and_then(|log| first_values(log, &[column], rows));
            values.map(|mut own| own.remove(0)).unwrap_or_default()
        };
        all.iter().map(own).collect()
    });
    let columns = names.into_iter().zip(values);
    Ok(columns.map(|(name, values)| PreviewColumn { name, values }).collect())
}

/// First values of some columns of a log.
pub(crate) fn first_values(
    mut log: Box<dyn Rows>,
    columns: &[usize],
    most: usize,
) -> Result<Vec<Vec<f64>>> {
    log.choose(columns)?;
    let (mut row, mut values) = (vec![0.0; columns.len()], vec![Vec::new(); columns.len()]);
    while values.first().is_some_and(|own| own.len() < most) && log.next(&mut row)? {
        values.iter_mut().zip(&row).for_each(|(own, value)| own.push(*value));
    }
    Ok(values)
}

#[cfg(test)]
mod tests {
    use super::preview;
    use crate::LogInput;
    use std::sync::Arc;

    #[test]
    fn columns_of_words_have_no_values_and_those_beside_them_do() {
        let text = b"clock,state,x\n0,idle,1.5\n1,moving,2.5\n2,idle,3.5\n".to_vec();

        let columns = preview(&LogInput::held("a.csv", Arc::new(text)), 2).unwrap();

        let found: Vec<_> =
            columns.iter().map(|c| (c.name.as_str(), c.values.as_slice())).collect();
        assert_eq!(found, [("clock", &[0.0, 1.0][..]), ("state", &[]), ("x", &[1.5, 2.5])]);
    }
}
