//! Verdict, errors, and what to do next.

use crate::{Findings, Heading, Item, Label, Section, Table, Tone, count, significant};
use torquewise_identify::Warning;
use torquewise_identify::verdict::{Grade, Verdict};
use torquewise_model::Form;

const DIGITS: usize = 3;

pub(crate) fn lead(findings: &Findings<'_>) -> String {
    let survey = &findings.found.survey;
    let trajectories = match survey.trajectories {
        0 | 1 => String::new(),
        many => format!(" in {} trajectories", count(many)),
    };
    format!(
        "A closed-form torque model of {} joints, from {} rows of motion \
         ({} s at {} Hz{trajectories}).",
        findings.n_joints(),
        count(survey.rows),
        significant(survey.seconds, DIGITS),
        significant(survey.rate(), DIGITS),
    )
}

pub(crate) fn section(findings: &Findings<'_>) -> Section {
    let mut items = vec![verdict(findings), error_table(findings), Item::Text(words(findings))];
    items.extend(findings.origin.files());
    Section { heading: "Verdict".into(), items }
}

fn verdict(findings: &Findings<'_>) -> Item {
    let Verdict { grade, because } = findings.verdict;
    let (tone, heading) = match grade {
        Grade::Good => (Tone::Good, "Good"),
        Grade::Usable => (Tone::Note, "Usable"),
        Grade::Unusable => (Tone::Warning, "Unusable"),
    };
    let lines = because.iter().map(|reason| sentence(reason)).collect();
    Item::Callout { tone, heading: heading.into(), lines }
}

pub(crate) fn next(findings: &Findings<'_>) -> Section {
    let (remarks, warnings): (Vec<&Warning>, Vec<&Warning>) =
        findings.found.warnings.iter().partition(|warning| warning.is_remark());
    let sentences = |warnings: Vec<&Warning>| -> Vec<String> {
        warnings.into_iter().map(|warning| sentence(&warning.to_string())).collect()
    };
    let mut warnings = sentences(warnings);
    warnings.extend(worst_joint(findings));
    if findings.checks.is_some_and(|checks| !checks.passed()) {
        warnings.push("No physical arm has this model, see Physics.".into());
    }
    let (remarks, model) = (sentences(remarks), findings.origin.model);
    let model = if model.is_empty() { "MODEL.json" } else { model };
    let judge = match findings.test {
        Some(_) => "Judge the model by another motion as well",
        None => "Record a log of another motion and judge the model by it",
    };
    let then = if findings.verdict.grade == Grade::Unusable {
        "Fit again before a model moves an arm.".to_owned()
    } else {
        format!(
            "Write the model as C code for a controller: torquewise export {model} --to c -o arm.c."
        )
    };
    let uses = vec![format!("{judge}: torquewise evaluate {model} LOG."), then];
    let items = [(Tone::Warning, warnings), (Tone::Note, remarks), (Tone::Good, uses)];
    let items = items.into_iter().filter(|(_, lines)| !lines.is_empty());
    let callout = |(tone, lines)| Item::Callout { tone, heading: String::new(), lines };
    Section { heading: "What to do next".into(), items: items.map(callout).collect() }
}

/// Which joint to move more, where the errors of the model are not small.
fn worst_joint(findings: &Findings<'_>) -> Option<String> {
    if findings.verdict.grade == Grade::Good {
        return None;
    }
    let errors = findings.found.model.training.held_out_errors().unwrap_or_default();
    let (joint, error) = errors.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1))?;
    let name = &findings.joints()[joint];
    let is_told = |own: &Warning| matches!(own, Warning::Shape { joint, .. } if joint == name);
    let cure = if findings.found.warnings.iter().any(is_told) {
        ""
    } else {
        ": record more of its motion, through its whole range and at several speeds"
    };
    let percent = significant(100.0 * error, DIGITS);
    Some(format!("{name} has the largest held-out error, {percent} %{cure}."))
}

/// A message as a sentence of its own. A joint's name at its beginning stays as it is.
pub(crate) fn sentence(message: &str) -> String {
    let end = if message.ends_with(['.', '?', '!']) { "" } else { "." };
    format!("{message}{end}")
}

fn words(findings: &Findings<'_>) -> String {
    let found = findings.found;
    let form = match found.model.form {
        Form::Energy(_) => {
            "The terms belong to the inertia matrix M(q) and the potential V(q), which all joints \
             share; the torque of each joint follows from them."
        }
        Form::Torque(_) => "Each joint has an equation of its own.",
    };
    let friction = match found.model.friction.len() {
        0 => String::new(),
        1 => " One term is friction.".into(),
        many => format!(" {} terms are friction.", count(many)),
    };
    let [kept, offered] = [found.model.n_coefficients(), found.candidates].map(count);
    let checks = findings.checks.map_or_else(String::new, |checks| {
        let passed = if checks.passed() { "passed" } else { "did not pass" };
        format!(" It {passed} the physical checks at {} states.", count(checks.states))
    });
    format!("The model has {kept} terms, of {offered} candidates.{friction} {form}{checks}")
}

/// Errors of each joint: on the test log, on held-out blocks of time, on the fitted log.
fn error_table(findings: &Findings<'_>) -> Item {
    let held_out = findings.found.model.training.held_out_percent();
    let (judged, fitted) = (findings.judged(), findings.diagnosis);
    let percent = |x: f64| Label::from(significant(x, DIGITS));
    let row = |joint: usize| -> Vec<Label> {
        let score = &judged.scores.joints[joint];
        let test = findings.test.map(|_| percent(score.nrmse_percent));
        let unseen = held_out.get(joint).map(|error| percent(*error));
        let own = percent(fitted.scores.joints[joint].nrmse_percent);
        // Five decimals, since it is close to one.
        let r2 = if score.r2.is_finite() { format!("{:.5}", score.r2) } else { "–".into() };
        let [rmse, r2] = [significant(score.rmse, DIGITS), r2.replace('-', "−")].map(Label::from);
        let errors = test.into_iter().chain(unseen).chain([own, rmse, r2]);
        std::iter::once(score.name.as_str().into()).chain(errors).collect()
    };
    let columns = [
        findings.test.map(|_| "test log [%]"),
        (!held_out.is_empty()).then_some("held out [%]"),
        Some("fitted log [%]"),
        Some("RMSE [N·m]"),
        Some("R²"),
    ];
    let columns = columns.into_iter().flatten().map(Heading::numbers);
    let of = if findings.test.is_some() { "test" } else { "fitted" };
    Item::Table(Table {
        caption: format!(
            "Percentages are the root mean square of the error over the standard deviation of the \
             torque of the joint (NRMSE): a lightly loaded joint has a large one. RMSE and R² are \
             those of the {of} log."
        ),
        columns: std::iter::once(Heading::words("joint")).chain(columns).collect(),
        rows: (0..findings.n_joints()).map(row).collect(),
    })
}
