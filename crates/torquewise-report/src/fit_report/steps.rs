//! From findings to table of the steps: what each was offered, what it found, what was left.

use crate::error::ReportError;
use crate::fit_report::Findings;
use crate::html::number::{count, significant};
use crate::html::{Column, Item, Label, Section, Table};
use torquewise_model::{Model, ModelError, Torque};
use torquewise_motion::Motion;

/// The steps, and the error of the torque after each (Fig. 10 of the paper).
pub(crate) fn section(findings: &Findings<'_>) -> Result<Section, ReportError> {
    let words = "Each step regresses what the steps before it leave unexplained. The last line \
                 refits all kept terms together on all rows.";
    let items = vec![Item::Text(words.into()), Item::Table(found(findings)), errors(findings)?];
    Ok(Section { heading: "Steps".into(), items })
}

fn found(findings: &Findings<'_>) -> Table {
    let mut columns =
        vec![Column::words("step"), Column::numbers("rows"), Column::numbers("candidates")];
    let joints = findings.joints().iter();
    columns.extend(joints.map(|joint| Column::numbers(format!("terms, {joint}"))));
    let row = |name: &str, rows: usize, candidates: usize, active: &[usize]| -> Vec<Label> {
        let mut cells = vec![name.into(), count(rows).into(), count(candidates).into()];
        cells.extend(active.iter().map(|&terms| Label::from(count(terms))));
        cells
    };
    let model = &findings.found.model;
    let mut rows: Vec<Vec<Label>> = findings
        .found
        .steps
        .iter()
        .map(|step| row(step.name, step.rows, step.candidates, &step.active))
        .collect();
    let active = model.active();
    let kept = model.n_coefficients();
    rows.push(row("refit", findings.found.survey.rows, kept, &active));
    Table { caption: "Terms found up to and with each step.".into(), columns, rows }
}

fn errors(findings: &Findings<'_>) -> Result<Item, ReportError> {
    let mut rows = Vec::new();
    for (place, (name, model)) in members(findings)?.iter().enumerate() {
        let percents = nrmse_percent(&findings.diagnosis.trace.motion, model);
        let percents = percents.map_err(|error| failed(place + 1, &error))?;
        let cells = percents.into_iter().map(|percent| significant(percent, 3).into());
        rows.push(std::iter::once(name.as_str().into()).chain(cells).collect());
    }
    let joints = findings.joints().iter();
    let columns = std::iter::once(Column::words("NRMSE [%] after"))
        .chain(joints.map(Column::numbers))
        .collect();
    let caption = "Over an even sample of the rows.".into();
    Ok(Item::Table(Table { caption, columns, rows }))
}

/// The model after each step, and as it is, with their names.
pub(crate) fn members(findings: &Findings<'_>) -> Result<Vec<(String, Model)>, ReportError> {
    let model = &findings.found.model;
    let mut members = Vec::new();
    for (place, stage) in model.stages.iter().enumerate() {
        let step = place + 1;
        let after = model.after_step(step).map_err(|error| failed(step, &error))?;
        members.push((stage.name.clone(), after));
    }
    let whole = if model.stages.is_empty() { "the whole model" } else { "refit" };
    members.push((whole.into(), model.clone()));
    Ok(members)
}

pub(crate) fn failed(step: usize, error: &ModelError) -> ReportError {
    ReportError::Step { step, reason: error.to_string() }
}

/// Error of each joint's torque over its standard deviation in percent, n.
pub(crate) fn nrmse_percent(motion: &Motion, model: &Model) -> Result<Vec<f64>, ModelError> {
    let tau_hat = Torque::new(model).over(motion)?;
    let of = |joint: usize| {
        let measured: Vec<f64> =
            motion.tau().map_or_else(Vec::new, |tau| tau.col(joint).iter().copied().collect());
        let m = measured.len().max(1) as f64;
        let mean = measured.iter().sum::<f64>() / m;
        let spread = measured.iter().map(|tau| (tau - mean).powi(2)).sum::<f64>();
        let left = measured.iter().zip(tau_hat.col(joint).iter());
        let left = left.map(|(tau, tau_hat)| (tau - tau_hat).powi(2)).sum::<f64>();
        100.0 * (left / spread).sqrt()
    };
    Ok((0..model.n_joints()).map(of).collect())
}
