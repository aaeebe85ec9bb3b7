//! What was repaired in logs, in words.

use std::collections::BTreeMap;
use torquewise::motion::Repairs;

/// What was repaired in each log, by its name; logs that are sound are not listed.
type ByLog = BTreeMap<String, Repairs>;

pub(crate) fn text(by_log: &ByLog) -> String {
    if by_log.is_empty() {
        return String::new();
    }
    let line = |(log, repairs): (&String, &Repairs)| format!("{log}: {repairs}\n");
    format!("\nconditioning\n{}", by_log.iter().map(line).collect::<String>())
}
