//! From variants to what each choice buys.

use crate::figures::looks::worst_joint;
use crate::page::cells::{columns, count, joints, table, with_range};
use crate::results::Results;
use crate::study::ablation::Variant;
use torquewise_report::html::{BarRow, Bars, Colour, Column, Item, Section};

/// The table, and bars of the worst joint.
pub(super) fn section(results: &Results) -> Section {
    let variants = &results.ablation;
    let n = variants.first().map_or(0, |variant| variant.nrmse_percent.len());
    let mut columns = columns("method;changed;tests");
    columns.extend([Column::numbers("runs"), Column::words("terms")]);
    columns.extend(joints("error [%], joint", n));
    let row = |variant: &Variant| {
        let mut row = vec![
            variant.family.into(),
            variant.change.into(),
            variant.equation.into(),
            variant.runs.to_string(),
            count(&variant.terms),
        ];
        row.extend(variant.nrmse_percent.iter().map(with_range));
        row
    };
    let bars = Bars {
        title: "Error of the worst joint".into(),
        caption: "Logarithmic: equal lengths are equal ratios.".into(),
        label: "RMSE / std(torque) [%]".into(),
        series: vec![("worst joint".into(), Colour::Series(0))],
        rows: variants.iter().map(bar).collect(),
        log: true,
    };
    Section {
        heading: "What each choice buys".into(),
        items: vec![
            Item::Text(
                "One choice of a stepwise method is changed at a time, in case 3. The two \
                 libraries beside each other test [E4]; “one step” takes the steps away and leaves \
                 everything else."
                    .into(),
            ),
            Item::Bars(vec![bars]),
            table(
                "Error outside the training log, median and range over the seeds.",
                columns,
                variants.iter().map(row).collect(),
            ),
        ],
    }
}

fn bar(variant: &Variant) -> BarRow {
    let name = format!("{}: {}", variant.family, variant.change);
    let error = worst_joint(&variant.nrmse_percent).median;
    BarRow { name: name.into(), sizes: vec![error] }
}
