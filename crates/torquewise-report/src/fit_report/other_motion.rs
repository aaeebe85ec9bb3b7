//! Diagnosis over another log → section: how well the model predicts what it was not fitted on.

use crate::fit_report::Findings;
use crate::fit_report::summary::score_table;
use crate::fit_report::torques::charts;
use crate::html::{Item, Section};
use torquewise_identify::Diagnosis;

/// Charts of the other log share their zoom by this word.
const LINK: &str = "time of the other motion";

/// Scores and torques.
pub(crate) fn section(findings: &Findings<'_>, test: &Diagnosis) -> Section {
    let mut items = vec![
        Item::Text(
            "The same model on a log it was not fitted on. This error, not that of the training \
             log, is what to expect of it."
                .into(),
        ),
        score_table(findings, test),
    ];
    items.extend(charts(findings, test, LINK));
    Section { heading: "Another motion".into(), items }
}
