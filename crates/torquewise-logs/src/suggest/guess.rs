//! Families of columns: one signal, one column per joint.

use crate::joints;
use std::collections::BTreeMap;
use std::path::Path;
use torquewise_motion::Signal;

/// Words that the clock, or a signal, is called by.
const WORDS: [(Option<Signal>, &str); 5] = [
    (None, "t time timestamp stamp clock"),
    (Some(Signal::Q), "q pos position positions angle angles theta qp qpos"),
    (Some(Signal::Dq), "dq qd qv qdot vel velocity velocities speed omega qvel"),
    (Some(Signal::Ddq), "ddq qdd qa qddot acc accel acceleration"),
    (Some(Signal::Tau), "tau torque torques effort efforts moment trq current currents cur curr"),
];

/// Words that others are put before without a space, as in `jointtorque`; and the dots of derivatives.
const LAST: &str = "position velocity acceleration torque torques effort current currents";
const DOTS: [(Option<Signal>, &str); 2] = [(Some(Signal::Dq), "dot"), (Some(Signal::Ddq), "ddot")];

const CURRENT: &str = "current currents cur curr";
const DEGREES: &str = "deg degrees degree";

/// Words of what was measured, and of what was wanted, worked out or wrong.
const MEASURED: &str = "meas measured act actual mot";
const NOT_MEASURED: &str =
    "des desired ref reference cmd cmptd command con target error err fric ff sim model";

#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Family {
    pub(super) columns: Vec<String>,
    /// What all begin with, if they are called that and 1, 2, ….
    pub(super) prefix: Option<String>,
    /// The word that told, and where it stood.
    pub(super) told_by: String,
    pub(super) is_current: bool,
    pub(super) is_degrees: bool,
    /// How much the name speaks for a measurement.
    pub(super) score: usize,
}

#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Found {
    pub(super) time: Option<String>,
    pub(super) signals: BTreeMap<Signal, Family>,
    /// Families of the same signals that were not taken.
    pub(super) passed_over: Vec<String>,
}

impl Found {
    pub(super) fn get(&self, signal: Signal) -> Option<&Family> {
        self.signals.get(&signal)
    }
}

/// The families among the columns of a file; its own name tells where those of columns do not.
pub(super) fn families(file: &Path, names: &[String]) -> Found {
    let stem = file.file_stem().map(|stem| stem.to_string_lossy().into_owned());
    let stem = words(&stem.unwrap_or_default());
    let mut found = Found::default();
    let mut all: Vec<(Signal, Family)> = Vec::new();
    for (key, columns) in grouped(names) {
        let Some((signal, word)) = meaning(&words(&key)) else { continue };
        if let Some(signal) = signal {
            all.push((signal, family(columns, &key, word)));
        } else {
            found.time.get_or_insert_with(|| columns[0].clone());
        }
    }
    if all.is_empty() {
        all.extend(by_stem(&stem, names, found.time.as_ref()));
    }
    for (signal, family) in all {
        let passed_over = match found.signals.get(&signal) {
            Some(best) if best.score >= family.score => Some(family),
            // Without accelerations they are derived: better than those of a command.
            None if signal == Signal::Ddq && family.score == 0 => Some(family),
            _ => found.signals.insert(signal, family),
        };
        found.passed_over.extend(passed_over.and_then(|family| family.columns.first().cloned()));
    }
    found
}

/// The numbered columns that mean nothing by themselves, by the name of the file.
fn by_stem(stem: &[String], names: &[String], time: Option<&String>) -> Option<(Signal, Family)> {
    let told = meaning(stem).and_then(|(signal, word)| Some((signal?, word)));
    let (signal, word) = told.unwrap_or((Signal::Q, "no name"));
    let numbered = grouped(names).into_iter().filter(|(key, columns)| {
        columns.len() > 1 && !columns.contains(key) && columns.iter().all(|c| Some(c) != time)
    });
    let (key, columns) = numbered.max_by_key(|(_, columns)| columns.len())?;
    let mut family = family(columns, &key, word);
    family.is_current = stem.iter().any(|word| is_in(word, CURRENT));
    Some((signal, family))
}

/// Columns that differ in the number at their end, or in the joint before the word that tells.
fn grouped(names: &[String]) -> Vec<(String, Vec<String>)> {
    let mut groups: Vec<(String, Vec<String>)> = Vec::new();
    for name in names {
        let (bare, unit) = parted(name);
        let numbered = bare.trim_end_matches([']', ')']);
        let prefix = numbered.trim_end_matches(|c: char| c.is_ascii_digit());
        let last =
            words(bare).into_iter().rfind(|word| meaning(std::slice::from_ref(word)).is_some());
        let key = match last {
            _ if prefix.len() < numbered.len() && !prefix.is_empty() => prefix.to_owned(),
            // arm_1_joint_position and arm_2_joint_position: one group by their last word.
            Some(word) if bare.to_lowercase().ends_with(&word) && bare.len() > word.len() => {
                format!("… {word}")
            }
            // pos_shoulder and pos_elbow: by their first word, where the rest names a joint.
            Some(word) if names_joint(bare, &word) => format!("{word} …"),
            _ => name.clone(),
        };
        let is_same = |(known, columns): &&mut (String, Vec<String>)| {
            *known == key && columns.first().is_some_and(|first| parted(first).1 == unit)
        };
        match groups.iter_mut().find(is_same) {
            Some((_, columns)) => columns.push(name.clone()),
            None => groups.push((key, vec![name.clone()])),
        }
    }
    groups
}

/// Whether a name is a word and what else tells nothing of a signal.
fn names_joint(name: &str, word: &str) -> bool {
    let mut all = words(name).into_iter();
    let begins = all.next().is_some_and(|first| first == word) && all.len() > 0;
    let lists = [MEASURED, "filtered raw", NOT_MEASURED, CURRENT, DEGREES];
    begins && !all.any(|own| lists.into_iter().any(|list| is_in(&own, list)))
}

/// The name of a column but for a unit, or what else stands in brackets at its end, and that.
fn parted(name: &str) -> (&str, &str) {
    let closed = name.strip_suffix([']', ')']).and_then(|rest| rest.rsplit_once(['[', '(']));
    let unit = closed.filter(|(_, unit)| unit.contains(|c: char| !c.is_ascii_digit()));
    unit.map_or((name, ""), |(bare, unit)| (bare.trim_end(), unit))
}

fn family(mut columns: Vec<String>, key: &str, word: &str) -> Family {
    let number = |name: &String| {
        let bare = parted(name).0.trim_end_matches([']', ')']);
        bare.get(key.len()..)?.parse::<usize>().ok()
    };
    let is_numbered = columns.iter().all(|name| name.starts_with(key) && number(name).is_some());
    if is_numbered {
        columns.sort_by_key(number);
    }
    let from_one = columns.iter().zip(1..).all(|(name, joint)| *name == format!("{key}{joint}"));
    let first = columns.first().cloned().unwrap_or_default();
    let all = words(&first);
    let counted = |list: &str| all.iter().filter(|word| is_in(word, list)).count();
    // What was wanted, as derivatives of qd, or worked out comes last, a current after a torque.
    let is_current = counted(CURRENT) > 0 || is_in(word, CURRENT);
    let is_wanted = counted(NOT_MEASURED) > 0 || (word.ends_with("dot") && counted("qd") > 0);
    let score = if is_wanted { 0 } else { 1 + counted(MEASURED) + usize::from(!is_current) };
    let (prefix, told_by) = (from_one.then(|| key.to_owned()), word.to_owned());
    let is_degrees = counted(DEGREES) > 0 || parted(&first).1.contains('°');
    Family { columns, prefix, told_by, is_current, is_degrees, score }
}

impl Family {
    /// The same in a file beside the log, whose columns are called `NAME.column`.
    pub(super) fn of_file(self, name: &str) -> Self {
        let of = |column: &String| format!("{name}.{column}");
        let columns = self.columns.iter().map(of).collect();
        Self { columns, prefix: self.prefix.as_ref().map(of), ..self }
    }

    /// Names of the joints, if the columns are called `NAME_position`, `position_NAME` or the like.
    pub(super) fn joints(&self) -> Option<Vec<String>> {
        let joint = |column: &String| {
            let lower = parted(column).0.to_lowercase();
            let joint = match lower.strip_suffix(&self.told_by) {
                Some(before) => column.get(..before.len())?,
                None if names_joint(&lower, &self.told_by) => {
                    column.get(self.told_by.len()..lower.len())?
                }
                None => return None,
            };
            let joint = joint.trim_matches(|c: char| !c.is_alphanumeric());
            joint.contains(char::is_alphabetic).then(|| joint.to_owned())
        };
        let names: Vec<String> = self.columns.iter().map(joint).collect::<Option<_>>()?;
        joints::check(&names).ok().map(|()| names)
    }
}

fn is_in(word: &str, list: &str) -> bool {
    list.split(' ').any(|own| own == word)
}

/// The signal that a name means, none of the clock, and the word that tells: the first that does, but
/// `q_dot` and `d_q` are velocities.
fn meaning(words: &[String]) -> Option<(Option<Signal>, &'static str)> {
    let known = |(signal, all): (_, &'static str)| all.split(' ').map(move |word| (signal, word));
    let is = |word: &str, own| word == own || (is_in(own, LAST) && word.ends_with(own));
    let told = |word: &String| WORDS.into_iter().flat_map(known).find(|(_, own)| is(word, own));
    let (place, found) = words.iter().enumerate().find_map(|(k, word)| Some((k, told(word)?)))?;
    let dots = DOTS.into_iter().find(|(_, dots)| words.iter().any(|word| word == dots));
    let found = dots.filter(|_| matches!(found.0, Some(Signal::Q | Signal::Dq))).unwrap_or(found);
    let rates = words[..place].iter().rev().take_while(|word| *word == "d").count();
    let derived = Signal::ALL[..3].iter().position(|own| Some(*own) == found.0);
    let signal = derived.and_then(|order| Signal::ALL[..3].get(order + rates).copied());
    Some((signal.or(found.0), found.1))
}

fn words(name: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut was_lower = false;
    for c in name.chars() {
        if !c.is_alphabetic() || (was_lower && c.is_uppercase()) {
            words.push(String::new());
        }
        if let Some(word) = words.last_mut().filter(|_| c.is_alphabetic()) {
            word.extend(c.to_lowercase());
        }
        was_lower = c.is_lowercase();
    }
    words.retain(|word| !word.is_empty());
    words
}
