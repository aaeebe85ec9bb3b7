//! From indicators to section: what noise and leverage of rows buy.

use crate::page::Drawn;
use crate::page::cells::{columns, count, table, with_range};
use crate::scenario::Decibels;
use crate::study::indicators::{IndicatorResults, IndicatorRow, PossibleGain, Sorting};
use torquewise_report::html::{Column, Item, Section};

/// What was done, the figure and the tables.
pub(super) fn section(results: &IndicatorResults, drawn: &Drawn) -> Section {
    let mut items = vec![Item::Text(format!(
        "The paper's first open question: to sort rows by noise and correlation, not by \
         activation alone [E17]. The noise of a row is its effective variance v, the variance \
         that noise in q, dq and ddq gives the modelled torque; its correlation with the \
         candidates is its leverage h in the regression of its step. Both come from a first fit. \
         Logs of {} s. Of {} regressions of a step and a joint the elbow sees more than one \
         cluster of (v, h) in {}.",
        results.log_length, results.regressions, results.clustered
    ))];
    items.extend(drawn.items("beyond_indicators"));
    items.push(rows(results, true));
    items.push(gains(&results.gains));
    items.push(Item::Details {
        summary: "The same without the noise correction [E7]".into(),
        items: vec![rows(results, false)],
    });
    Section { heading: "Noise and leverage as indicators".into(), items }
}

fn rows(results: &IndicatorResults, noise_correction: bool) -> Item {
    let row = |row: &IndicatorRow| {
        let compared = [with_range(&row.ratio), format!("{} of {}", row.better, row.runs)];
        let usual = row.sorting == Sorting::Activation;
        let [ratio, better] = if usual { ["–".into(), "–".into()] } else { compared };
        vec![
            row.method.name().into(),
            row.noise.name(),
            row.sorting.name().into(),
            format!("{} of {}", count(&row.right), row.true_terms),
            count(&row.other),
            row.nrmse_percent.iter().map(with_range).collect::<Vec<_>>().join(" / "),
            ratio,
            better,
        ]
    };
    let columns = columns(
        "method;noise;rows sorted by;true terms found;other terms;\
         error [%], joint 1 / 2 / …;error over activation alone, worst joint;\
         logs on which it is better",
    );
    let shown = results.rows.iter().filter(|row| row.noise_correction == noise_correction);
    let caption = "Median and range over the seeds; the ratio is that of the same log.";
    table(caption, columns, shown.map(row).collect())
}

fn gains(gains: &[PossibleGain]) -> Item {
    let mut steps: Vec<&str> = Vec::new();
    let mut levels: Vec<(&str, Decibels)> = Vec::new();
    for gain in gains {
        if !steps.contains(&gain.step) {
            steps.push(gain.step);
        }
        if !levels.contains(&(gain.method.name(), gain.noise)) {
            levels.push((gain.method.name(), gain.noise));
        }
    }
    let row = |(method, noise): &(&str, Decibels)| {
        let cell = |step: &&str| {
            let own = |gain: &&PossibleGain| {
                gain.method.name() == *method && gain.noise == *noise && gain.step == *step
            };
            gains.iter().find(own).map_or_else(|| "–".into(), |gain| with_range(&gain.gain))
        };
        let names = [(*method).to_owned(), noise.name()];
        names.into_iter().chain(steps.iter().map(cell)).collect()
    };
    let mut columns = columns("method;noise");
    columns.extend(steps.iter().map(|step| Column::words(*step)));
    let caption = "How unequal the rows of a step are: mean(v)·mean(1/v), the largest of the \
                   joints. So many times smaller the variance of the coefficients could be with \
                   weights 1/v.";
    table(caption, columns, levels.iter().map(row).collect())
}
