//! Findings → table: how far the log reaches, and how noisy it is.

use crate::fit_report::Findings;
use crate::html::number::significant;
use crate::html::{Column, Item, Label, Section, Table};

const DIGITS: usize = 3;

/// Positions, speeds, accelerations, torques and noise of each joint.
pub(crate) fn section(findings: &Findings<'_>) -> Section {
    let words = "The model is known to hold within these ranges only; beyond them it is a guess.";
    let items =
        vec![Item::Text(words.into()), Item::Table(reach(findings)), Item::Table(noise(findings))];
    Section { heading: "Ranges".into(), items }
}

fn reach(findings: &Findings<'_>) -> Table {
    let survey = &findings.found.survey;
    let columns = [
        "q from [rad]",
        "to [rad]",
        "largest |q̇| [rad/s]",
        "largest |q̈| [rad/s²]",
        "mean τ [N·m]",
        "std of τ [N·m]",
    ];
    let numbers = |joint: usize| {
        let [low, high] = survey.q_range[joint];
        let peaks = [survey.dq_peak[joint], survey.ddq_peak[joint]];
        let torque = [survey.torque_mean[joint], survey.torque_std[joint]];
        [[low, high], peaks, torque].concat()
    };
    let caption = "What each joint did in the log.".into();
    per_joint(&survey.joints, caption, &columns, numbers)
}

fn noise(findings: &Findings<'_>) -> Table {
    let noise = &findings.found.noise;
    let columns = ["in q [rad]", "in q̇ [rad/s]", "in q̈ [rad/s²]"];
    let numbers = |joint: usize| vec![noise.q[joint], noise.dq[joint], noise.ddq[joint]];
    let caption = "Standard deviation of the white noise; 0 where none was found.".into();
    per_joint(&findings.found.survey.joints, caption, &columns, numbers)
}

fn per_joint(
    joints: &[String],
    caption: String,
    headings: &[&str],
    numbers: impl Fn(usize) -> Vec<f64>,
) -> Table {
    let row = |(joint, name): (usize, &String)| -> Vec<Label> {
        let numbers = numbers(joint).into_iter().map(|x| significant(x, DIGITS).into());
        std::iter::once(name.as_str().into()).chain(numbers).collect()
    };
    let columns = headings.iter().map(|heading| Column::numbers(*heading));
    Table {
        caption,
        columns: std::iter::once(Column::words("joint")).chain(columns).collect(),
        rows: joints.iter().enumerate().map(row).collect(),
    }
}
