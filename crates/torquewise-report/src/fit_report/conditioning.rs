//! Findings → table: what was repaired in each log before the fit.

use crate::fit_report::Findings;
use crate::html::number::significant;
use crate::html::{Column, Item, Label, Section, Table};
use torquewise_motion::Repairs;

const DIGITS: usize = 3;

/// Rows left out, values replaced and stamps moved, log by log and in total; `None` where nothing
/// was.
pub(crate) fn section(findings: &Findings<'_>) -> Option<Section> {
    let by_log = &findings.found.model.training.conditioning;
    let total: Repairs = by_log.values().sum();
    if total.is_none() {
        return None;
    }
    let each = by_log.iter().map(|(log, repairs)| row(log, repairs));
    let table = Table {
        caption: "What was repaired in the logs; those that are not listed are sound.".into(),
        columns: columns(),
        rows: each.chain([row("all", &total)]).collect(),
    };
    let items = vec![Item::Text(format!("All logs: {total}.")), Item::Table(table)];
    Some(Section { heading: "Conditioning".into(), items })
}

fn columns() -> Vec<Column> {
    let numbers = [
        "spikes replaced",
        "repeated stamps",
        "held rows",
        "other rows left out",
        "late stamps",
        "gaps bridged",
        "longest [ms]",
        "splits",
    ];
    std::iter::once(Column::words("log")).chain(numbers.map(Column::numbers)).collect()
}

fn row(log: &str, repairs: &Repairs) -> Vec<Label> {
    let others = repairs.earlier_stamps + repairs.not_finite + repairs.too_short;
    let (left_out, moved) =
        ([repairs.repeated_stamps, repairs.held_rows, others], [repairs.late_stamps, repairs.gaps]);
    let counts = std::iter::once(repairs.spikes.values().sum()).chain(left_out).chain(moved);
    let mut cells: Vec<Label> = vec![log.into()];
    cells.extend(counts.map(|number| number.to_string().into()));
    cells.push(significant(1e3 * repairs.longest_gap, DIGITS).into());
    cells.push(repairs.splits.to_string().into());
    cells
}
