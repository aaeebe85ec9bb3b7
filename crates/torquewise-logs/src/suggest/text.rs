//! Text of a suggested profile, and its reasons.

use crate::Suggestion;
use crate::profile::unit::of_step;
use crate::suggest::guess::{Family, Found};
use crate::suggest::measure::{Measured, units_of};
use std::f64::consts::PI;
use std::path::PathBuf;
use torquewise_motion::Signal;

/// Positions beyond this \[rad\] are degrees, or angles of motors.
const LARGEST_RADIANS: f64 = 4.0 * PI;

impl Suggestion {
    fn new() -> Self {
        Self { toml: "robot = \"\"\n".into(), ..Self::default() }
    }

    fn line(&mut self, line: impl AsRef<str>) {
        self.toml.push_str(line.as_ref());
        self.toml.push('\n');
    }

    fn reason(&mut self, reason: impl Into<String>) {
        self.reasons.push(reason.into());
    }
}

/// A bag says all but the unit of its efforts.
pub(super) fn of_bag(joints: &[String], columns: &[String]) -> Suggestion {
    let mut draft = Suggestion::new();
    draft.line("# Base to tip: put them in order, and drop those that are no joints of the arm.");
    draft.line(format!("joints = {}", list(joints)));
    draft.reason("A bag names its joints and is in SI units: q, dq and tau need no columns.");
    if columns.iter().any(|column| column.ends_with(".effort")) {
        draft.line("\n# Effort may be a current. If so, take away the marks and fill in:\n# [tau]");
        current_lines(&mut draft, joints.len());
        draft.reason("ROS 2 wants efforts in N·m; some drivers give currents all the same.");
    } else {
        draft.reason("The messages have no effort: there is nothing to fit a model to.");
    }
    Suggestion { is_complete: !joints.is_empty(), ..draft }
}

pub(super) fn of_columns(
    found: &Found,
    measured: &Measured,
    beside: &[(String, PathBuf)],
) -> Suggestion {
    let mut draft = Suggestion::new();
    if let Some(q) = found.get(Signal::Q) {
        let numbered = || (1..=q.columns.len()).map(|joint| format!("joint{joint}")).collect();
        draft.line("# Base to tip.");
        draft.line(format!("joints = {}", list(&q.joints().unwrap_or_else(numbered))));
    }
    if found.time.is_none() {
        draft.line(
            "# The file has no clock that is known by its name: fill in rows per second, or\n\
             # name the column of the clock below as [t] column = \"…\".\n# rate = 1000.0",
        );
        draft.reason("No column is called t, time or stamp: fill in rate.");
    }
    if !beside.is_empty() {
        draft.line("\n# Files with the same rows, from the folder of the log.\n[beside]");
        for (name, file) in beside {
            let file = file.display().to_string();
            draft.line(format!("{name} = {}", quoted(&file)));
            draft.reason(format!(
                "{file} has what the log lacks: its columns are called {name}.NAME."
            ));
        }
    }
    if let Some(time) = &found.time {
        clock(&mut draft, time, measured);
    }
    signals(&mut draft, found, measured);
    if !found.passed_over.is_empty() {
        let names = found.passed_over.join(", ");
        draft.reason(format!("Not taken, since others fit better: {names}."));
    }
    let is_complete = found.time.is_some() && found.get(Signal::Q).is_some();
    let (has_torque, takes_others) = (found.get(Signal::Tau).is_some(), !beside.is_empty());
    Suggestion { is_complete, has_torque, takes_others, ..draft }
}

fn signals(draft: &mut Suggestion, found: &Found, measured: &Measured) {
    let units = units(draft, found, measured);
    let q = found.get(Signal::Q);
    if q.is_none() {
        draft.line(
            "\n# No column is known for a position by its name: name them.\n# [q]\n\
             # columns = [\"…\"]",
        );
        draft.reason("No column is called q, pos or angle, and none is numbered: name them.");
    }
    // Without positions the first signal says how many joints there are.
    let first = q.or_else(|| found.signals.values().next());
    let n = first.map_or(0, |family| family.columns.len());
    for (signal, family) in &found.signals {
        let unit = match signal {
            Signal::Q => units.0,
            Signal::Dq => units.1,
            Signal::Ddq if units.0 == "deg" => "deg/s2",
            Signal::Ddq => "rad/s2",
            Signal::Tau => "N.m",
        };
        signal_lines(draft, *signal, family, unit, n);
    }
    if found.get(Signal::Tau).is_none() {
        draft.reason(
            "No column is called tau, torque, effort or current: no model can be fitted. If torques \
             are in another file, inspect both together.",
        );
    }
}

fn clock(draft: &mut Suggestion, time: &str, measured: &Measured) {
    draft.line(format!("\n[t]\ncolumn = {}", quoted(time)));
    if let Some(step) = measured.step {
        let (unit, seconds) = of_step(step);
        draft.line(format!("unit = \"{unit}\""));
        let (rate, step) = ((1.0 / (step * seconds)).round(), (1e6 * step).round() / 1e6);
        draft.reason(format!(
            "Clock {time}: the usual step is {step}, so it counts {unit}, {rate} rows per second."
        ));
    }
}

fn units(
    draft: &mut Suggestion,
    found: &Found,
    measured: &Measured,
) -> (&'static str, &'static str) {
    let says_degrees = |signal| found.get(signal).is_some_and(|family| family.is_degrees);
    let is_large = measured.largest_q.is_some_and(|largest| largest > LARGEST_RADIANS);
    let q = if says_degrees(Signal::Q) || is_large { "deg" } else { "rad" };
    if let Some(largest) = measured.largest_q {
        draft.reason(if q == "deg" && !says_degrees(Signal::Q) {
            format!(
                "Positions reach {largest:.3}: degrees, or radians of the motors; if so, set unit \
                 = \"rad\" and scale to one over the gear ratio."
            )
        } else {
            format!("Positions reach {largest:.3}: {q}.")
        });
    }
    let same = if q == "deg" { ("deg", "deg/s") } else { ("rad", "rad/s") };
    let Some(ratio) = measured.ratio else { return same };
    let (units, verdict) = match units_of(ratio) {
        Some(("", _)) => (same, "the same angle is used in both"),
        Some(units) => (units, "their units differ"),
        None => (same, "this fits no unit: check both"),
    };
    draft.reason(format!("Velocities are {ratio:.3} times the slopes of positions: {verdict}."));
    units
}

fn signal_lines(draft: &mut Suggestion, signal: Signal, family: &Family, unit: &str, n: usize) {
    let Family { columns, prefix, told_by, is_current, .. } = family;
    draft.line("");
    if columns.len() != n {
        let (signal, found) = (signal.name(), columns.len());
        let first = columns.first().map_or("", String::as_str);
        draft.reason(format!("{signal} has {found} columns ({first}, …), not {n}: left out."));
        draft.line(format!("# [{signal}] has {found} columns for {n} joints."));
        return;
    }
    draft.line(format!("[{}]", signal.name()));
    let columns_value = prefix.as_ref().map_or_else(|| list(columns), |prefix| quoted(prefix));
    draft.line(format!("columns = {columns_value}"));
    draft.reason(format!("{} is {columns_value}, told by \"{told_by}\".", signal.name()));
    if *is_current {
        draft.line("# The name says current: take away the marks and fill in.");
        current_lines(draft, n);
        draft.reason("Torque constants and gear ratios stand in no log: fill them in.");
    } else {
        draft.line(format!("unit = \"{unit}\""));
    }
    if told_by.starts_with("effort") {
        draft.line(
            "# Effort may be a current. If so, take away the marks and fill in, instead of\n\
             # the unit above.",
        );
        current_lines(draft, n);
        draft.reason("Efforts are N·m by the rules of ROS, but some drivers give currents.");
    }
}

fn current_lines(draft: &mut Suggestion, n: usize) {
    let ones = vec!["1.0"; n].join(", ");
    draft.line(format!(
        "# unit = \"A\"\n# torque_constant = [{ones}] # N·m/A, sign included\n\
         # gear = [{ones}] # turns of the motor for one of the joint"
    ));
}

fn list(names: &[String]) -> String {
    let names: Vec<_> = names.iter().map(|name| quoted(name)).collect();
    format!("[{}]", names.join(", "))
}

fn quoted(name: &str) -> String {
    toml::Value::String(name.to_owned()).to_string()
}
