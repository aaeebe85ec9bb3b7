//! The mapping of columns that a profile says.

use crate::profile::unit::{factor, time_factor};
use crate::profile::{Columns, PerJoint, SignalColumns};
use crate::{LogError, Mapping, Profile, Result, Rows, Slot, Time, joints, listed, shown};
use std::path::Path;
use torquewise_motion::Signal;

/// The mapping that a profile describes for a file.
///
/// - `is_bag`: whether columns are called `NAME.position` and so on
pub(crate) fn by_profile(
    profile: &Profile,
    file: &Path,
    rows: &dyn Rows,
    is_bag: bool,
) -> Result<Mapping> {
    let is_plain = profile.q.as_ref().is_none_or(|q| q.columns.is_none());
    let mut build = Build { file, names: rows.names(), is_bag, is_plain, chosen: Vec::new() };
    let time = build.time(profile)?;
    let joints = build.joints(profile, rows.joints());
    profile.check_counts(Some(joints.len()), "profile")?;
    let kept = kept(profile, &joints, file)?;
    let mut present = Vec::new();
    let mut slots = Vec::new();
    for signal in Signal::ALL {
        let parts = profile.signal(signal);
        let Some(columns) = build.columns(signal, parts, &joints)? else { continue };
        present.push(signal);
        let all = signal_slots(signal, parts, &columns);
        slots.extend(kept.iter().filter_map(|joint| all.get(*joint).cloned()));
    }
    let joints = Some(kept.iter().filter_map(|joint| joints.get(*joint).cloned()).collect());
    Ok(Mapping {
        n_joints: kept.len(),
        present,
        chosen: build.chosen,
        time,
        slots,
        rows: profile.rows.clone(),
        seconds: profile.seconds.clone(),
        joints,
        ignored: Vec::new(),
    })
}

struct Build<'a> {
    file: &'a Path,
    names: &'a [String],
    is_bag: bool,
    /// Whether the profile names no columns of positions: then those of any signal go by their
    /// plain names.
    is_plain: bool,
    chosen: Vec<usize>,
}

impl Build<'_> {
    fn time(&mut self, profile: &Profile) -> Result<Time> {
        if let Some(rate) = profile.rate {
            return Ok(Time::Rate(rate));
        }
        let (column, unit) = match &profile.t {
            Some(t) => (t.column.as_str(), t.unit.as_deref()),
            None if self.has("t") => ("t", None),
            None => {
                let problem = format!(" has no clock, found {}", listed(self.names, 30));
                let help =
                    "name its column as [t] column = \"…\" or give rate = … (Hz) in the profile";
                return Err(LogError::unusable(self.file.display(), &problem, help));
            }
        };
        self.choose("t.column", column)?;
        Ok(Time::Column(time_factor(unit).unwrap_or(1.0)))
    }

    /// Names of all joints, those that are left out among them.
    fn joints(&self, profile: &Profile, known: Option<&[String]>) -> Vec<String> {
        if !profile.joints.is_empty() {
            return profile.joints.clone();
        }
        let n = match profile.q.as_ref().and_then(|q| q.columns.as_ref()) {
            Some(Columns::Names(names)) => names.len(),
            Some(Columns::Prefix(prefix)) => self.count(prefix),
            None if self.is_bag => 0,
            None => self.count(Signal::Q.name()),
        };
        match known {
            Some(names) if self.is_bag || names.len() == n => names.to_vec(),
            _ => joints::numbered(n),
        }
    }

    /// How many joints the columns with a prefix are of.
    fn count(&self, prefix: &str) -> usize {
        let all = 1..=self.names.len();
        let numbered = all.take_while(|joint| self.has(&format!("{prefix}{joint}"))).count();
        numbered.max(usize::from(self.has(prefix)))
    }

    /// Places of the columns of a signal among the chosen; `None` if there is no such signal.
    fn columns(
        &mut self,
        signal: Signal,
        parts: Option<&SignalColumns>,
        joints: &[String],
    ) -> Result<Option<Vec<usize>>> {
        let key = format!("{}.columns", signal.name());
        let names: Vec<String> = match parts.and_then(|parts| parts.columns.as_ref()) {
            Some(Columns::Names(names)) => names.clone(),
            Some(Columns::Prefix(prefix)) => self.numbered(prefix, joints.len()),
            None if self.is_bag => {
                let fields = [Some("position"), Some("velocity"), None, Some("effort")];
                let field = fields[signal as usize];
                let names = joints.iter().filter_map(|joint| Some(format!("{joint}.{}", field?)));
                let names: Vec<String> = names.collect();
                let is_there = names.first().is_some_and(|name| self.has(name));
                if parts.is_none() && signal != Signal::Q && !is_there {
                    return Ok(None);
                }
                names
            }
            None if self.is_plain && self.has(&format!("{}1", signal.name())) => {
                self.numbered(signal.name(), joints.len())
            }
            None if parts.is_none() && signal != Signal::Q => return Ok(None),
            None => return Err(self.missing(&key, &format!("{}1", signal.name()))),
        };
        if names.is_empty() {
            return Err(self.missing(&key, "columns of a signal, such as q1, q2, …"));
        }
        names.iter().map(|name| self.choose(&key, name)).collect::<Result<_, _>>().map(Some)
    }

    fn numbered(&self, prefix: &str, n: usize) -> Vec<String> {
        let first = format!("{prefix}1");
        if n == 1 && !self.has(&first) && self.has(prefix) {
            return vec![prefix.to_owned()];
        }
        (1..=n.max(1)).map(|joint| format!("{prefix}{joint}")).collect()
    }

    fn choose(&mut self, key: &str, name: &str) -> Result<usize> {
        let name = name.trim();
        let mut columns = (0..).zip(self.names).filter(|(_, known)| *known == name);
        let (column, _) = columns.next().ok_or_else(|| self.missing(key, name))?;
        if columns.next().is_some() {
            let (file, column) = (self.file.into(), shown(name.as_bytes()));
            return Err(LogError::DuplicateColumn { file, column });
        }
        let place = self.chosen.iter().position(|chosen| *chosen == column);
        Ok(place.unwrap_or_else(|| {
            self.chosen.push(column);
            self.chosen.len() - 1
        }))
    }

    fn has(&self, name: &str) -> bool {
        self.names.iter().any(|known| known == name)
    }

    fn missing(&self, key: &str, missing: &str) -> LogError {
        let (missing, found) = (shown(missing.as_bytes()), listed(self.names, 30));
        let problem =
            format!(" has no column {missing}, which {key} of the profile needs, found {found}");
        LogError::unusable(self.file.display(), &problem, "name the columns as the file does")
    }
}

/// Places of the joints that are not left out.
fn kept(profile: &Profile, joints: &[String], file: &Path) -> Result<Vec<usize>> {
    let is_unknown = |name: &&String| !joints.contains(name);
    if let Some(unknown) = profile.leave_out.iter().find(is_unknown) {
        let (profile, key) = ("profile".into(), "leave_out".into());
        let expected = format!("one of the joints {}", joints.join(", "));
        let found = shown(unknown.as_bytes());
        return Err(LogError::ProfileKey { profile, key, found, expected });
    }
    let kept: Vec<_> =
        (0..joints.len()).filter(|joint| !profile.leave_out.contains(&joints[*joint])).collect();
    if kept.is_empty() && !joints.is_empty() {
        let problem = ": the profile leaves out all joints";
        Err(LogError::unusable(file.display(), problem, "keep one"))
    } else {
        Ok(kept)
    }
}

fn signal_slots(signal: Signal, parts: Option<&SignalColumns>, columns: &[usize]) -> Vec<Slot> {
    let Some(parts) = parts else {
        return columns.iter().map(|place| Slot::as_it_stands(*place)).collect();
    };
    let unit = factor(signal, parts.unit.as_deref()).unwrap_or(1.0);
    let of = |values: &Option<PerJoint>, joint, default| {
        values.as_ref().and_then(|values| values.of(joint)).unwrap_or(default)
    };
    let column_factor = |joint| {
        let motor = of(&parts.gear, joint, 1.0) * of(&parts.torque_constant, joint, 1.0);
        motor * of(&parts.scale, joint, 1.0) * unit
    };
    let coupling = |joint: usize, column: usize| match &parts.matrix {
        Some(matrix) => matrix[joint][column],
        None => f64::from(u8::from(joint == column)),
    };
    let slot = |joint| {
        let term = |column| (columns[column], coupling(joint, column) * column_factor(column));
        let terms = (0..columns.len()).map(term).filter(|(_, factor)| *factor != 0.0).collect();
        Slot { terms, offset: of(&parts.offset, joint, 0.0) }
    };
    (0..columns.len()).map(slot).collect()
}
