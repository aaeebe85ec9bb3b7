//! Importance of terms: how much of each torque each carries, and which nearly stayed.

use crate::html::equation::{friction, term};
use crate::{Bars, Colour, Findings, Item, Label, Section, count};
use std::collections::BTreeMap;
use torquewise_identify::diagnose::Importance;
use torquewise_model::print::weighted_friction;
use torquewise_model::{FrictionLaw, FrictionTerm};

const MOST_TERMS: usize = 8;
const MOST_DROPPED: usize = 12;

pub(crate) fn section(findings: &Findings<'_>) -> Option<Section> {
    let words = "Root mean square of what each term adds to the torque of its joint over the rows.";
    let model = &findings.found.model;
    if findings.diagnosis.importance.iter().all(Vec::is_empty) {
        return None;
    }
    let equations = model.equations().into_iter().zip(weighted_friction(model));
    let bars = equations.enumerate().map(|(joint, (equation, rubbing))| {
        let terms: BTreeMap<_, _> = equation.iter().map(|(_, term)| (term.name(), term)).collect();
        let label = |found: &Importance| -> Label {
            let own = terms.get(&found.name).map(|found| term(found));
            let rubs = rubbing.iter().find(|w| w.term.name() == found.name);
            let is_offset = |term: &FrictionTerm| term.law == FrictionLaw::Offset;
            let of_friction = |term| if is_offset(term) { "offset".into() } else { friction(term) };
            let name = own.or_else(|| rubs.map(|w| of_friction(&w.term)));
            name.unwrap_or_else(|| found.name.clone().into())
        };
        let all = &findings.diagnosis.importance[joint];
        let caption = match all.len().saturating_sub(MOST_TERMS) {
            0 => String::new(),
            1 => "One smaller term is not shown.".into(),
            n => format!("{} smaller terms are not shown.", count(n)),
        };
        Bars {
            title: findings.joints()[joint].clone(),
            caption,
            label: "share of the torque [N·m]".into(),
            colour: Colour::Series(0),
            rows: all.iter().take(MOST_TERMS).map(|found| (label(found), found.rms)).collect(),
        }
    });
    let mut items = vec![Item::Text(words.into()), Item::Bars(bars.collect())];
    items.extend(dropped(findings));
    Some(Section { heading: "Terms".into(), items })
}

fn dropped(findings: &Findings<'_>) -> Option<Item> {
    let all = &findings.found.dropped;
    let kept = all.iter().take(MOST_DROPPED);
    let kept = kept.map(|dropped| (dropped.name.clone().into(), 100.0 * dropped.inclusion));
    let bars = Bars {
        title: "Terms close to being kept".into(),
        caption: "They are not in the model, though some resampled logs kept them: more rows, or \
                  other motion, would settle it."
            .into(),
        label: "resampled logs in which they were kept [%]".into(),
        colour: Colour::Faded,
        rows: kept.collect(),
    };
    (!all.is_empty()).then_some(Item::Bars(vec![bars]))
}
