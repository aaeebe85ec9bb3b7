//! Details of the method: patterns, and what each step found.

use crate::fit_report::clock;
use crate::fit_report::torques::LINK;
use crate::{
    Chart, Clock, Colour, Findings, Heading, Item, Label, Mark, ReportError, Result, Section,
    Series, Table, count, significant,
};
use torquewise_model::{Model, Torque};
use torquewise_motion::{Motion, Pattern};

pub(crate) fn section(findings: &Findings<'_>) -> Result<Section> {
    let words = format!(
        "K-means of the activation indices of velocity and acceleration told the rows apart, into \
         {} clusters, each named by what it activates: gravity alone at standstill, Coriolis torque \
         at uniform velocity, inertia at variable velocity. Each step regresses what the steps \
         before it leave unexplained; the last line refits all kept terms together on all rows.",
        findings.found.patterns.n_clusters()
    );
    let items = vec![
        Item::Text(words),
        Item::Table(patterns(findings)),
        Item::Table(steps(findings)?),
        Item::Charts(vec![motion(findings)]),
    ];
    let details = Item::Details { summary: "Patterns of motion, and steps".into(), items };
    Ok(Section { heading: "Method details".into(), items: vec![details] })
}

fn patterns(findings: &Findings<'_>) -> Table {
    let (found, rows) = (&findings.found.patterns, &findings.diagnosis.trace.patterns);
    let row = |pattern: Pattern| -> Vec<Label> {
        let of = |all: &[Pattern]| all.iter().filter(|own| **own == pattern).count();
        let share = 100.0 * of(rows) as f64 / rows.len().max(1) as f64;
        let used = if found.present.contains(&pattern) { "yes" } else { "no" };
        let numbers = [significant(share, 3), count(of(&found.names))].map(Label::from);
        [&[pattern.name().into()], &numbers[..], &[used.into()]].concat()
    };
    let caption = "A pattern is used if it has enough rows and what should be zero in them is.";
    let [share, clusters] = ["rows [%]", "clusters"].map(Heading::numbers);
    let columns = vec![Heading::words("pattern"), share, clusters, Heading::words("used")];
    let rows = Pattern::ALL.into_iter().map(row).collect();
    Table { caption: caption.into(), columns, rows }
}

/// Terms and errors of each joint after each step (Fig. 10 of the paper).
fn steps(findings: &Findings<'_>) -> Result<Table> {
    let found = findings.found;
    let (active, kept) = (found.model.active(), found.model.n_coefficients());
    let steps =
        found.steps.iter().map(|step| (step.name, step.rows, step.candidates, &step.active));
    let steps = steps.chain([("refit", found.survey.rows, kept, &active)]);
    let members = members(findings)?;
    let mut rows = Vec::new();
    for (place, (name, m, candidates, active)) in steps.enumerate() {
        let mut cells: Vec<Label> = vec![name.into(), count(m).into(), count(candidates).into()];
        cells.extend(active.iter().map(|&terms| Label::from(count(terms))));
        // The last of the members is the whole.
        let model = &members[place.min(members.len() - 1)].1;
        let errors = nrmse_percent(&findings.diagnosis.trace.motion, (place + 1, model))?;
        cells.extend(errors.into_iter().map(|percent| Label::from(significant(percent, 3))));
        rows.push(cells);
    }
    let joints = |what: &'static str| {
        findings.joints().iter().map(move |joint| Heading::numbers(format!("{what}, {joint}")))
    };
    let mut columns =
        vec![Heading::words("step"), Heading::numbers("rows"), Heading::numbers("candidates")];
    columns.extend(joints("terms").chain(joints("NRMSE [%]")));
    let caption = "Terms found up to and with each step, and the error after it over an even sample \
                   of the rows.";
    Ok(Table { caption: caption.into(), columns, rows })
}

fn motion(findings: &Findings<'_>) -> Chart {
    let trace = &findings.diagnosis.trace;
    let clock = Clock::new(trace.motion.t());
    let dq = trace.motion.dq();
    let line = |(joint, name): (usize, &String)| {
        let points = clock.curve(|row| dq[(row, joint)]);
        Series::new(name, Mark::Line, Colour::Series(joint), points)
    };
    let series = findings.joints().iter().enumerate().map(line).collect();
    let names = [clock::LABEL, "velocity [rad/s]"];
    let chart = Chart::over("Motion, coloured by pattern", names, series);
    Chart { bands: clock.bands(&trace.patterns), linked: Some(LINK.into()), ..chart }
}

/// The model after each step, and as it is, with their names.
pub(crate) fn members(findings: &Findings<'_>) -> Result<Vec<(String, Model)>> {
    let model = &findings.found.model;
    let mut members = Vec::new();
    for (place, stage) in model.stages.iter().enumerate() {
        let step = place + 1;
        let after = model.after_step(step).map_err(|source| ReportError::Step { step, source })?;
        members.push((stage.name.clone(), after));
    }
    let whole = if model.stages.is_empty() { "the whole model" } else { "refit" };
    members.push((whole.into(), model.clone()));
    Ok(members)
}

/// Error of each joint's torque over its standard deviation in percent after a step, n.
pub(crate) fn nrmse_percent(motion: &Motion, (step, model): (usize, &Model)) -> Result<Vec<f64>> {
    let tau_hat = Torque::new(model).over(motion);
    let tau_hat = tau_hat.map_err(|source| ReportError::Step { step, source })?;
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
