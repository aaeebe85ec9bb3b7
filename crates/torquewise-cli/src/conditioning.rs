//! What was repaired in logs, in words.

use std::collections::BTreeMap;
use torquewise::motion::Repairs;

/// - `by_log`: logs that are sound are not listed
pub(crate) fn text(by_log: &BTreeMap<String, Repairs>) -> String {
    if by_log.is_empty() {
        return String::new();
    }
    let line = |(log, repairs): (&String, &Repairs)| format!("{log}: {repairs}\n");
    format!("\nconditioning\n{}", by_log.iter().map(line).collect::<String>())
}
