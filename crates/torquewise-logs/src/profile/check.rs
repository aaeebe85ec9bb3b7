//! The first thing in a profile that cannot be right.

use crate::profile::{Columns, PerJoint, SignalColumns, unit};
use crate::{LogError, Profile, Result, joints, shown};
use torquewise_motion::Signal;

impl Profile {
    /// Makes sure that values can be right by themselves and agree in the number of joints; `from`
    /// names the profile in messages. A profile that is read from text has been checked.
    ///
    /// # Errors
    /// [`LogError::ProfileKey`] or [`LogError::JointName`].
    pub fn check(&self, from: &str) -> Result<()> {
        let wrong = |key: &str, found: String, expected: String| {
            Err(LogError::ProfileKey { profile: from.into(), key: key.into(), found, expected })
        };
        joints::check(&self.joints)?;
        if let Some(rate) = self.rate.filter(|rate| !(rate.is_finite() && *rate > 0.0)) {
            return wrong("rate", rate.to_string(), "a number of rows per second over 0".into());
        }
        if self.rate.is_some() && self.t.is_some() {
            let expected = "one of rate and [t]: rate stands for a clock".into();
            return wrong("t", "both rate and [t]".into(), expected);
        }
        if let Some(t) = &self.t {
            let unit = t.unit.as_deref();
            if unit::time_factor(unit).is_none() {
                return wrong("t.unit", quoted(unit), format!("one of {}", unit::known(None)));
            }
        }
        if !in_order(&self.rows) || self.rows.iter().any(|range| range[0] == 0) {
            let expected = "ranges [first, last] in order, 1 for the first row".into();
            return wrong("rows", format!("{:?}", self.rows), expected);
        }
        if !in_order(&self.seconds) || self.seconds.iter().flatten().any(|x| !x.is_finite()) {
            let expected = "ranges [begin, end] in order, in seconds".into();
            return wrong("seconds", format!("{:?}", self.seconds), expected);
        }
        let is_unknown = |name: &&String| !self.joints.is_empty() && !self.joints.contains(name);
        if let Some(name) = self.leave_out.iter().find(is_unknown) {
            let expected = format!("one of {}", self.joints.join(", "));
            return wrong("leave_out", shown(name.as_bytes()), expected);
        }
        let mut present = Signal::ALL.into_iter().filter_map(|own| Some((own, self.signal(own)?)));
        present.try_for_each(|(signal, parts)| check_values(signal, parts, from))?;
        self.check_counts((!self.joints.is_empty()).then_some(self.joints.len()), from)
    }

    /// Makes sure that every list has one entry for each of n joints; where n is not known, as many
    /// as the first list.
    pub(crate) fn check_counts(&self, n: Option<usize>, from: &str) -> Result<()> {
        let present = Signal::ALL.into_iter().filter_map(|own| Some((own, self.signal(own)?)));
        let counts: Vec<_> = present.flat_map(|(signal, parts)| counts(signal, parts)).collect();
        let first = counts.first().map(|(key, count)| (format!("{key} has"), *count));
        let known = n.map(|n| ("joints are".to_owned(), n)).or(first);
        let Some((by, expected)) = known else { return Ok(()) };
        let wrong = counts.into_iter().find(|(_, count)| *count != expected);
        let Some((key, count)) = wrong else { return Ok(()) };
        let found = format!("{count} entries");
        let expected = format!("{expected}, one per joint, as {by} {expected}");
        Err(LogError::ProfileKey { profile: from.into(), key, found, expected })
    }
}

fn counts(signal: Signal, parts: &SignalColumns) -> Vec<(String, usize)> {
    let key = |name: &str| format!("{}.{name}", signal.name());
    let mut counts = Vec::new();
    if let Some(Columns::Names(names)) = &parts.columns {
        counts.push((key("columns"), names.len()));
    }
    for (name, values) in numbers(parts) {
        if let Some(PerJoint::Each(values)) = values {
            counts.push((key(name), values.len()));
        }
    }
    if let Some(matrix) = &parts.matrix {
        counts.push((key("matrix"), matrix.len()));
        let rows = (1..).zip(matrix);
        counts.extend(rows.map(|(row, values)| (key(&format!("matrix, row {row}")), values.len())));
    }
    counts
}

fn numbers(parts: &SignalColumns) -> [(&'static str, &Option<PerJoint>); 4] {
    let SignalColumns { scale, gear, torque_constant, offset, .. } = parts;
    [("scale", scale), ("gear", gear), ("torque_constant", torque_constant), ("offset", offset)]
}

/// Units that are known, factors that are finite and leave something of the column.
fn check_values(signal: Signal, parts: &SignalColumns, from: &str) -> Result<()> {
    let wrong = |key: &str, found: String, expected: String| {
        let key = format!("{}.{key}", signal.name());
        Err(LogError::ProfileKey { profile: from.into(), key, found, expected })
    };
    let unit = parts.unit.as_deref();
    if unit::factor(signal, unit).is_none() {
        return wrong("unit", quoted(unit), format!("one of {}", unit::known(Some(signal))));
    }
    if unit::is_current(unit) && parts.torque_constant.is_none() {
        let expected = "torque_constant = [N·m/A of each motor, with its sign], and gear if the \
            motor is geared: amperes alone are no torque";
        return wrong("unit", quoted(unit), expected.into());
    }
    for (key, values) in numbers(parts) {
        let Some(values) = values else { continue };
        if signal != Signal::Tau && matches!(key, "gear" | "torque_constant") {
            return wrong(key, "a value".into(), "none: this is a key of [tau] alone".into());
        }
        let is_wrong = |x: &&f64| !x.is_finite() || (key != "offset" && **x == 0.0);
        if let Some(value) = values.values().iter().find(is_wrong) {
            return wrong(key, value.to_string(), "finite numbers, factors other than 0".into());
        }
    }
    let mut entries = parts.matrix.iter().flatten().flatten();
    if let Some(value) = entries.find(|x| !x.is_finite()) {
        return wrong("matrix", value.to_string(), "finite numbers".into());
    }
    Ok(())
}

fn in_order<T: PartialOrd>(ranges: &[[T; 2]]) -> bool {
    ranges.iter().all(|[first, last]| first <= last)
        && ranges.windows(2).all(|pair| pair[0][1] < pair[1][0])
}

fn quoted(text: Option<&str>) -> String {
    format!("\"{}\"", shown(text.unwrap_or_default().as_bytes()))
}

#[cfg(test)]
mod tests;
