//! Text in columns.

use torquewise::FitResult;
use torquewise::model::number;

const WIDEST: usize = 250;

/// A table for the terminal: names to the left, numbers to the right.
#[derive(Clone, Debug)]
pub(crate) struct Table {
    rows: Vec<Vec<String>>,
}

impl Table {
    pub(crate) fn new(headings: impl IntoIterator<Item = impl Into<String>>) -> Self {
        Self::of(vec![headings.into_iter().map(Into::into).collect()])
    }

    pub(crate) fn of(rows: Vec<Vec<String>>) -> Self {
        Self { rows }
    }

    pub(crate) fn row(&mut self, name: &str, cells: impl IntoIterator<Item = String>) {
        self.rows.push(std::iter::once(name.to_owned()).chain(cells).collect());
    }

    /// One line per row, each ended; cells beyond any terminal are cut.
    pub(crate) fn text(&self) -> String {
        let cut = |cell: &String| match cell.char_indices().nth(WIDEST) {
            None => cell.clone(),
            Some((end, _)) => cell[..end].to_owned() + "…",
        };
        let rows: Vec<Vec<String>> =
            self.rows.iter().map(|row| row.iter().map(cut).collect()).collect();
        let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
        let width = |column: usize| {
            let cells = rows.iter().filter_map(|row| row.get(column));
            cells.map(|cell| cell.chars().count()).max().unwrap_or(0)
        };
        let widths: Vec<usize> = (0..columns).map(width).collect();
        let line = |row: &Vec<String>| {
            let cells = row.iter().zip(&widths).enumerate().map(|(column, (cell, &width))| {
                if column == 0 { format!("{cell:<width$}") } else { format!("{cell:>width$}") }
            });
            cells.collect::<Vec<_>>().join("  ").trim_end().to_owned() + "\n"
        };
        rows.iter().map(line).collect()
    }
}

/// Methods beside each other: candidates, coefficients, seconds, and the error of each joint.
pub(crate) fn methods<'a>(
    joints: &[String],
    rows: impl IntoIterator<Item = (&'a str, &'a FitResult, Vec<f64>)>,
) -> Table {
    let mut headings = ["method", "candidates", "active", "seconds"].map(str::to_owned).to_vec();
    headings.extend(joints.iter().map(|name| format!("NRMSE {name} [%]")));
    let mut table = Table::new(headings);
    for (name, fit, errors) in rows {
        let counts = [fit.candidates, fit.model.n_coefficients()].map(|count| count.to_string());
        let (counts, seconds) = (counts.into_iter(), format!("{:.2}", fit.seconds));
        table.row(name, counts.chain([seconds]).chain(errors.into_iter().map(number)));
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cell_beyond_any_terminal_is_cut() {
        let mut table = Table::new(["joint"]);
        table.row(&"é".repeat(70_000), []);

        assert_eq!(table.text(), format!("joint\n{}…\n", "é".repeat(WIDEST)));
    }
}
