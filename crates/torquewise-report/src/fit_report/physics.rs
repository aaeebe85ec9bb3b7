//! Physical checks → verdict: whether the model could be an arm.

use crate::html::number::{count, significant};
use crate::html::{Callout, Column, Item, Section, Table, Tone};
use torquewise_model::Checks;

/// Each check with what a real arm has, and what it means.
pub(crate) fn section(checks: &Checks) -> Section {
    let (tone, verdict) = if checks.passed() {
        (Tone::Good, "The model could be a real arm at every state looked at.")
    } else {
        let words = "The model is no real arm at some state looked at: it may predict torque, but \
                     simulation and computed-torque control with it can go wrong.";
        (Tone::Warning, words)
    };
    let row = |name: &str, value: f64, expected: &str| {
        vec![name.into(), significant(value, 3).into(), expected.into()]
    };
    let table = Table {
        caption: format!("The worst of {} states.", count(checks.states)),
        columns: vec![
            Column::words("check"),
            Column::numbers("found"),
            Column::words("a real arm has"),
        ],
        rows: vec![
            row("smallest eigenvalue of M [kg·m²]", checks.smallest_eigenvalue, "more than zero"),
            row("asymmetry of M", checks.asymmetry, "zero, but for rounding"),
            row(
                "defect of Ṁ − 2C from skew symmetry",
                checks.skew_defect,
                "zero, but for rounding",
            ),
        ],
    };
    let callout = Callout { tone, lines: vec![verdict.into()] };
    Section { heading: "Physics".into(), items: vec![Item::Callout(callout), Item::Table(table)] }
}
