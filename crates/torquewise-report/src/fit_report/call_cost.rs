//! Which step's torque fits which control rate, by counted operations.

use crate::fit_report::method::{members, nrmse_percent};
use crate::{Findings, Heading, Item, Label, Result, Section, Table, count, significant};
use torquewise_export::Cost;
use torquewise_identify::Diagnosis;

/// Rates of controllers \[Hz\].
pub const RATES: [f64; 4] = [1e3, 4e3, 10e3, 40e3];
/// Part of a period that a call may take.
const MOST: f64 = 0.1;
const DIGITS: usize = 2;

/// One model to choose: its name, its cost and the error of its worst joint in percent.
struct Choice {
    name: String,
    cost: Cost,
    on_log: f64,
    on_test: Option<f64>,
}

pub(crate) fn section(findings: &Findings<'_>) -> Result<Section> {
    let mut choices = Vec::new();
    for ((place, (name, model)), &cost) in
        members(findings)?.into_iter().enumerate().zip(findings.costs)
    {
        let worst = |diagnosis: &Diagnosis| -> Result<f64> {
            let joints = nrmse_percent(&diagnosis.trace.motion, (place + 1, &model))?;
            Ok(joints.into_iter().filter(|percent| percent.is_finite()).fold(0.0, f64::max))
        };
        let (on_log, on_test) = (worst(findings.diagnosis)?, findings.test.map(worst).transpose()?);
        choices.push(Choice { name, cost, on_log, on_test });
    }
    let items = vec![Item::Text(advice(&choices)), Item::Table(table(&choices))];
    Ok(Section { heading: "Cost in a controller".into(), items })
}

fn advice(choices: &[Choice]) -> String {
    let best = |rate: f64| {
        let fitting = choices.iter().filter(|c| c.cost.percent_of_period(rate) <= 100.0 * MOST);
        let error = |choice: &&Choice| choice.on_test.unwrap_or(choice.on_log);
        fitting.min_by(|a, b| error(a).total_cmp(&error(b))).map(|choice| choice.name.as_str())
    };
    let said = RATES.chunk_by(|a, b| best(*a) == best(*b)).map(|rates| {
        let name = best(rates[0]).map_or_else(|| "none".into(), |name| format!("“{name}”"));
        let rates: Vec<String> = rates.iter().map(|rate| kilohertz(*rate)).collect();
        format!("{name} at {}", rates.join(", "))
    });
    format!(
        "The most accurate torque that takes at most a tenth of the period of a control loop: {}. \
         Exported code was counted, and the time estimated for a desktop processor; a controller \
         that is k times slower takes k times the share.",
        said.collect::<Vec<_>>().join("; ")
    )
}

fn kilohertz(rate: f64) -> String {
    format!("{}\u{202f}kHz", significant(1e-3 * rate, 2).trim_end_matches(".0"))
}

fn table(choices: &[Choice]) -> Table {
    let has_test = choices.iter().any(|choice| choice.on_test.is_some());
    let mut columns = vec![Heading::words("torque of")];
    columns.extend(["+ − ·", "sin cos exp tanh", "about [µs]"].map(Heading::numbers));
    columns.extend(RATES.map(|rate| Heading::numbers(format!("of {} [%]", kilohertz(rate)))));
    columns.push(Heading::numbers("NRMSE, fitted log [%]"));
    columns.extend(has_test.then(|| Heading::numbers("test log [%]")));
    let row = |choice: &Choice| -> Vec<Label> {
        let Choice { name, cost, on_log, on_test } = choice;
        let mut cells = vec![name.as_str().into(), count(cost.operations).into()];
        cells.push(count(cost.functions).into());
        cells.push(significant(1e6 * cost.seconds(), DIGITS).into());
        let shares = RATES.map(|rate| significant(cost.percent_of_period(rate), DIGITS));
        cells.extend(shares.map(Label::from));
        let errors = std::iter::once(on_log).chain(on_test);
        cells.extend(errors.map(|percent| Label::from(significant(*percent, 3))));
        cells
    };
    let caption = "Cost of one call, and error of the worst joint.".into();
    Table { caption, columns, rows: choices.iter().map(row).collect() }
}
