//! Tables of words and numbers.

use crate::html::markup::Label;
use crate::html::number::aligned;
use serde::Serialize;

/// Rows under headings.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    /// What it shows; may be empty.
    pub caption: String,
    /// Headings.
    pub columns: Vec<Heading>,
    /// Cells; a row may be shorter than the headings, what is beyond them is left out.
    pub rows: Vec<Vec<Label>>,
}

/// Heading of a column.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Heading {
    /// What its cells are, with the unit in brackets.
    pub heading: String,
    /// Whether they are numbers, to be aligned at the decimal point.
    pub numeric: bool,
}

impl Heading {
    /// A column of words.
    pub fn words(heading: impl Into<String>) -> Self {
        Self { heading: heading.into(), numeric: false }
    }

    /// A column of numbers.
    pub fn numbers(heading: impl Into<String>) -> Self {
        Self { heading: heading.into(), numeric: true }
    }
}

const WORDS: [&str; 5] = ["joint", "direction", "link", "on", "what"];

impl Table {
    /// Rows of text, headings first; columns of numbers are those of other names than `joint`,
    /// `direction`, `link`, `on` and `what`.
    pub(crate) fn of_text(rows: Vec<Vec<String>>) -> Self {
        let mut rows = rows.into_iter();
        let column = |heading: String| {
            let is_word = WORDS.contains(&heading.as_str());
            if is_word { Heading::words(heading) } else { Heading::numbers(heading) }
        };
        let columns: Vec<Heading> =
            rows.next().unwrap_or_default().into_iter().map(column).collect();
        let cell = |(column, text): (&Heading, String)| -> Label {
            if column.numeric { text.replace('-', "−").into() } else { text.into() }
        };
        let cells = |row: Vec<String>| columns.iter().zip(row).map(cell).collect();
        let rows = rows.map(cells).collect();
        Self { caption: String::new(), columns, rows }
    }

    /// The cells row by row, each row as long as the headings.
    pub(crate) fn cells(&self) -> Vec<Vec<Label>> {
        let mut rows = self.rows.clone();
        for row in &mut rows {
            row.resize(self.columns.len(), "".into());
        }
        let numeric = (0..self.columns.len()).filter(|&place| self.columns[place].numeric);
        for place in numeric {
            let cells: Vec<String> = rows.iter().map(|row| row[place].to_string()).collect();
            for (row, cell) in rows.iter_mut().zip(aligned(&cells)) {
                row[place] = cell.into();
            }
        }
        rows
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::html::{Item, Page, Section};

    #[test]
    fn cells_are_escaped_aligned_and_as_many_as_the_headings() {
        let table = Table {
            columns: vec![Heading::words("joint"), Heading::numbers("NRMSE [%]")],
            rows: vec![
                vec!["<b>".into(), "1.5".into(), "too much".into()],
                vec!["wrist".into(), "12".into()],
                vec!["short".into()],
            ],
            ..Table::default()
        };

        let cells = table.cells();

        let [first, second, third] = [0, 1, 2].map(|row| cells[row].iter().map(Label::to_string));
        assert!(first.eq(["<b>", "1.5"]) && !cells[0][0].is_safe(), "{cells:?}");
        assert!(second.eq(["wrist", "12\u{2008}\u{2007}"]), "{cells:?}");
        assert!(third.eq(["short", ""]), "{cells:?}");
        let section = Section { items: vec![Item::Table(table)], ..Section::default() };
        let page = Page { sections: vec![section], ..Page::default() }.to_html().unwrap();
        assert!(page.contains("<td>&lt;b&gt;</td>"), "{page}");
    }
}
