//! From numbers and spreads to cells of a table.

use crate::spread::Spread;
use torquewise_report::html::number::significant;
use torquewise_report::html::{Column, Item, Label, Table};

/// `0.14 (0.12–0.18)`; the median alone if there is but one value.
pub(super) fn with_range(spread: &Spread) -> String {
    let [median, least, greatest] =
        [spread.median, spread.least, spread.greatest].map(|x| significant(x, 2));
    if least == greatest { median } else { format!("{median} ({least}–{greatest})") }
}

/// A count with its range.
pub(super) fn count(spread: &Spread) -> String {
    let [median, least, greatest] = [spread.median, spread.least, spread.greatest];
    if least.total_cmp(&greatest).is_eq() {
        format!("{median}")
    } else {
        format!("{median} ({least}–{greatest})")
    }
}

/// Counts in one cell.
pub(super) fn listed(counts: &[usize]) -> String {
    counts.iter().map(usize::to_string).collect::<Vec<_>>().join(" + ")
}

/// Columns from headings between semicolons; one of numbers begins with #.
pub(super) fn columns(headings: &str) -> Vec<Column> {
    let column = |heading: &str| match heading.strip_prefix('#') {
        Some(heading) => Column::numbers(heading),
        None => Column::words(heading),
    };
    headings.split(';').map(column).collect()
}

/// Headings of the joints with a unit.
pub(super) fn joints(what: &str, count: usize) -> Vec<Column> {
    (1..=count).map(|joint| Column::words(format!("{what} {joint}"))).collect()
}

/// A table of text.
pub(super) fn table(caption: &str, columns: Vec<Column>, rows: Vec<Vec<String>>) -> Item {
    let rows = rows.into_iter().map(|row| row.into_iter().map(Label::from).collect()).collect();
    Item::Table(Table { caption: caption.into(), columns, rows })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_range_is_shown_where_there_is_one() {
        assert_eq!(with_range(&Spread::of([0.1, 0.25, 0.2])), "0.20 (0.10–0.25)");
        assert_eq!(with_range(&Spread::of([0.5])), "0.50");
        assert_eq!(count(&Spread::of([23.0, 24.0])), "23.5 (23–24)");
    }
}
