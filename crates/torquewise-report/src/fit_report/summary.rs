//! Findings → summary: the result in words and numbers, warnings first.

use crate::fit_report::Findings;
use crate::html::number::{count, significant};
use crate::html::{Callout, Column, Fact, Item, Label, Section, Table, Tone};
use torquewise_identify::Diagnosis;
use torquewise_model::Form;
use torquewise_motion::Pattern;

/// Digits of errors.
const DIGITS: usize = 3;

/// One sentence below the title.
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

/// Warnings, the numbers that matter most, and what they mean.
pub(crate) fn section(findings: &Findings<'_>) -> Section {
    let items = vec![
        warnings(findings),
        facts(findings),
        Item::Text(words(findings)),
        score_table(findings, findings.diagnosis),
    ];
    Section { heading: "Summary".into(), items }
}

fn warnings(findings: &Findings<'_>) -> Item {
    let mut lines: Vec<String> =
        findings.found.warnings.iter().map(|warning| sentence(&warning.to_string())).collect();
    if findings.checks.is_some_and(|checks| !checks.passed()) {
        lines.push("The model is no real arm at some states, see Physics.".into());
    }
    if lines.is_empty() {
        let lines = vec!["Nothing in the log or in the fit gave cause for a warning.".into()];
        return Item::Callout(Callout { tone: Tone::Good, lines });
    }
    Item::Callout(Callout { tone: Tone::Warning, lines })
}

/// A message as a sentence of its own. A joint's name at its beginning stays as it is.
fn sentence(message: &str) -> String {
    let end = if message.ends_with(['.', '?', '!']) { "" } else { "." };
    format!("{message}{end}")
}

fn facts(findings: &Findings<'_>) -> Item {
    let found = findings.found;
    let terms = found.model.n_coefficients();
    let patterns = found.patterns.present.len();
    let checks = findings.checks.map(|checks| {
        let verdict = if checks.passed() { "passed" } else { "failed" };
        Fact::new(verdict, format!("physical checks at {} states", count(checks.states)))
    });
    let mut facts = vec![
        Fact::new(count(terms), format!("terms stayed of {} candidates", count(found.candidates))),
        Fact::new(errors(findings), "error of the torque (NRMSE), best to worst joint"),
        Fact::new(count(findings.diagnosis.scores.rows), "rows the error is taken over"),
        Fact::new(patterns.to_string(), "of 3 patterns of motion in the log"),
    ];
    facts.extend(checks);
    Item::Facts(facts)
}

/// `0.02–1.3 %`, in one word.
fn errors(findings: &Findings<'_>) -> String {
    let percents = findings.diagnosis.scores.joints.iter().map(|joint| joint.nrmse_percent);
    let finite = percents.filter(|percent| percent.is_finite());
    let [least, most] =
        finite.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)]);
    if least > most {
        return "–".into();
    }
    let [least, most] = [least, most].map(|percent| significant(percent, 2));
    if least == most { format!("{least}\u{202f}%") } else { format!("{least}–{most}\u{202f}%") }
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
    let shares: Vec<String> = Pattern::ALL
        .into_iter()
        .map(|pattern| format!("{} {} %", pattern.name(), significant(share(findings, pattern), 2)))
        .collect();
    let noise = if found.noise.is_none() {
        "No white noise was found in position, velocity and acceleration."
    } else {
        "The white noise found in position, velocity and acceleration is listed under Ranges."
    };
    let overlooked = overlooked(findings);
    format!("{form}{friction} The rows fall into {}. {noise}{overlooked}", shares.join(", "))
}

/// What terms that were not offered would explain, as one more sentence.
fn overlooked(findings: &Findings<'_>) -> String {
    let Some(found) = &findings.found.model.training.overlooked else { return String::new() };
    let tried = count(found.candidates);
    let Some(best) = found.best.first() else {
        return format!(" Of {tried} more terms tried one by one, none would lower the residual.");
    };
    format!(
        " Of {tried} more terms tried one by one, none would lower the residual (RMS) by more than \
         {} %: {}, that of {} by {} %, on held-out rows by {} ± {} %.",
        significant(100.0 * best.of_residual(), 2),
        best.term,
        best.joint,
        significant(100.0 * best.of_joint, 2),
        significant(100.0 * found.held_out, 2),
        significant(100.0 * found.held_out_std_error, 2),
    )
}

/// Rows of a pattern in percent.
pub(crate) fn share(findings: &Findings<'_>, pattern: Pattern) -> f64 {
    let patterns = &findings.diagnosis.trace.patterns;
    let own = patterns.iter().filter(|&&row| row == pattern).count();
    100.0 * own as f64 / patterns.len().max(1) as f64
}

/// Errors of each joint over what a diagnosis looked at.
pub(crate) fn score_table(findings: &Findings<'_>, diagnosis: &Diagnosis) -> Item {
    let active = findings.found.model.active();
    let row = |(joint, terms): (&torquewise_diagnose::score::JointScore, usize)| -> Vec<Label> {
        vec![
            joint.name.as_str().into(),
            count(terms).into(),
            significant(joint.rmse, DIGITS).into(),
            significant(joint.nrmse_percent, DIGITS).into(),
            r_squared(joint.r2).into(),
        ]
    };
    Item::Table(Table {
        caption: "NRMSE is the root mean square of the error divided by the standard deviation of \
                  the torque of the joint: a lightly loaded joint has a large one."
            .into(),
        columns: vec![
            Column::words("joint"),
            Column::numbers("terms"),
            Column::numbers("RMSE [N·m]"),
            Column::numbers("NRMSE [%]"),
            Column::numbers("R²"),
        ],
        rows: diagnosis.scores.joints.iter().zip(active).map(row).collect(),
    })
}

/// Five decimals, since it is close to one.
fn r_squared(r2: f64) -> String {
    if r2.is_finite() { format!("{r2:.5}").replace('-', "−") } else { "–".into() }
}
