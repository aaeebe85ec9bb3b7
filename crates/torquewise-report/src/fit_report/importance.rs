//! Findings → bars: how much of each joint's torque a term carries, and which terms nearly stayed.

use crate::fit_report::Findings;
use crate::html::number::count;
use crate::html::{BarRow, Bars, Colour, Item, Label, Section};
use crate::mathml::term;
use std::collections::BTreeMap;
use torquewise_model::Term;

/// Terms of a joint that are shown.
const MOST_TERMS: usize = 12;
/// Dropped terms that are shown.
const MOST_DROPPED: usize = 12;

/// The most important terms of each joint.
pub(crate) fn section(findings: &Findings<'_>) -> Section {
    let words = "Root mean square of what each term adds to the torque of its joint over the rows.";
    let equations = findings.found.model.equations();
    let joints = equations.iter().enumerate();
    let bars = joints.map(|(joint, equation)| {
        let terms = equation.iter().map(|(_, term)| (term.name(), term)).collect();
        joint_bars(findings, joint, &terms)
    });
    let mut items = vec![Item::Text(words.into()), Item::BarsBeside(bars.collect())];
    items.extend(dropped(findings));
    Section { heading: "Terms".into(), items }
}

fn joint_bars(findings: &Findings<'_>, joint: usize, terms: &BTreeMap<String, &Term>) -> Bars {
    let importance = &findings.diagnosis.importance[joint];
    let left_out = importance.len().saturating_sub(MOST_TERMS);
    let row = |found: &torquewise_identify::diagnose::Importance| BarRow {
        name: terms.get(&found.name).map_or_else(|| found.name.clone().into(), |t| term(t).into()),
        sizes: vec![found.rms],
    };
    let caption = match left_out {
        0 => String::new(),
        n => format!("{} smaller terms are not shown.", count(n)),
    };
    Bars {
        title: findings.joints()[joint].clone(),
        caption,
        label: "share of the torque [N·m]".into(),
        series: vec![("share".into(), Colour::Series(0))],
        rows: importance.iter().take(MOST_TERMS).map(row).collect(),
        log: false,
    }
}

fn dropped(findings: &Findings<'_>) -> Option<Item> {
    let all = &findings.found.dropped;
    let row = |dropped: &torquewise_identify::form::Dropped| BarRow {
        name: Label::Text(dropped.name.clone()),
        sizes: vec![100.0 * dropped.inclusion],
    };
    let bars = Bars {
        title: "Terms that nearly stayed".into(),
        caption: "They are not in the model, though some resampled logs kept them: more rows, or \
                  other motion, would settle it."
            .into(),
        label: "resampled logs in which they stayed [%]".into(),
        series: vec![("share".into(), Colour::Faded)],
        rows: all.iter().take(MOST_DROPPED).map(row).collect(),
        log: false,
    };
    (!all.is_empty()).then_some(Item::Bars(bars))
}
