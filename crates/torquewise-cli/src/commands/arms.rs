//! The built-in arms.

use crate::outcome::Outcome;
use crate::table::Table;
use serde_json::json;
use torquewise::dynamics::{ArmSummary, arms};

/// Lists them, fewest joints first.
pub(crate) fn list() -> Outcome {
    let mut text = String::new();
    let mut table = Table::new(&["arm", "joints"]);
    for arm in arms() {
        table.row(arm.name, [arm.joints.to_string()]);
    }
    let descriptions = std::iter::once("").chain(arms().into_iter().map(|arm| arm.description));
    for (line, description) in table.text().lines().zip(descriptions) {
        text.push_str(format!("{line}  {description}").trim_end());
        text.push('\n');
    }
    let objects = arms().into_iter().map(|arm| {
        let ArmSummary { name, joints, description } = arm;
        json!({ "name": name, "joints": joints, "description": description })
    });
    let json = json!({ "arms": objects.collect::<Vec<_>>() });
    Outcome { text, json, ..Outcome::default() }
}
