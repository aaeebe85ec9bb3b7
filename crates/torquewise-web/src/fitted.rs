//! A fit as the page shows it.

use serde_json::{Value, json};
use torquewise::model::selection::Selection;
use torquewise::model::{print, to_json};
use torquewise::page::{LogFile, Origin, page};
use torquewise::{Error, FitResult, Observer, Prepared};

/// Verdict, errors, warnings, report, equations and the text of the model file.
pub(crate) fn fitted(
    fit: &FitResult,
    files: &[String],
    date: &str,
    observer: Observer<'_>,
) -> Result<Value, Error> {
    let model = &fit.model;
    let logs: Vec<LogFile> =
        files.iter().map(|name| LogFile { name: name.clone(), date: String::new() }).collect();
    let origin = Origin {
        logs: &logs,
        tests: &[],
        model: "model.json",
        command: &format!("torquewise fit {} -o model.json", files.join(" ")),
        date,
    };
    let (notes, warnings): (Vec<_>, Vec<_>) =
        fit.warnings.iter().partition(|warning| warning.is_remark());
    let of_log = fit.log.iter().flat_map(Prepared::warnings);
    Ok(json!({
        "summary": fit.summary()?,
        "warnings": warnings.iter().map(ToString::to_string).chain(of_log).collect::<Vec<_>>(),
        "notes": notes.iter().map(ToString::to_string).collect::<Vec<_>>(),
        "report": page(fit, None, origin, observer)?,
        "equations": print::text(model, &Selection::default()),
        "is_chain": model.chain.is_some(),
        "model": to_json(model)?,
    }))
}
