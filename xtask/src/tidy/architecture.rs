//! ARCHITECTURE.md → dead paths: every path it names exists.

use crate::violation::Violation;
use crate::workspace::read_text;
use anyhow::Result;
use std::path::Path;

const FILE: &str = "ARCHITECTURE.md";
/// Lines it may have.
const LINES: usize = 120;

/// Every path named in backticks or as a link that does not exist under `root`, and a text that
/// has grown too long.
///
/// # Errors
/// If the file cannot be read.
pub(crate) fn check(root: &Path) -> Result<Vec<Violation>> {
    let text = read_text(&root.join(FILE))?;
    let mut violations = dead_paths(&text, |path| root.join(path).exists());
    let n_lines = text.lines().count();
    if n_lines > LINES {
        let message = format!("{n_lines} lines, limit {LINES}: move detail to the crates");
        violations.push(Violation::new(FILE, LINES + 1, message));
    }
    Ok(violations)
}

fn dead_paths(text: &str, exists: impl Fn(&str) -> bool) -> Vec<Violation> {
    let mut violations = Vec::new();
    for (index, line) in text.lines().enumerate() {
        for path in named_paths(line).into_iter().filter(|path| !exists(path)) {
            let message = format!("`{path}` does not exist: name what does");
            violations.push(Violation::new(FILE, index + 1, message));
        }
    }
    violations
}

/// Paths in backticks, and link targets that are no web addresses.
fn named_paths(line: &str) -> Vec<&str> {
    let quoted = line.split('`').skip(1).step_by(2).filter(|token| is_path(token));
    let links = line.split("](").skip(1).filter_map(|rest| rest.split(')').next());
    let local = links.filter(|link| !link.contains("://") && !link.starts_with('#'));
    quoted.chain(local.filter_map(|link| link.split('#').next())).collect()
}

/// Something with a `/`, or a document by its ending; `lib.rs` names no one file.
fn is_path(token: &str) -> bool {
    let plain = |c: char| c.is_ascii_alphanumeric() || "._-/".contains(c);
    let endings = [".md", ".toml"];
    let named = token.contains('/') || endings.iter().any(|ending| token.ends_with(ending));
    named && token.chars().all(plain)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn messages(text: &str) -> Vec<String> {
        let exists = |path: &str| path == "docs/method.md";
        dead_paths(text, exists).iter().map(ToString::to_string).collect()
    }

    #[test]
    fn a_path_that_does_not_exist_is_reported_with_its_line() {
        let found = messages("See `docs/method.md`.\nSee `docs/gone.md`.");

        assert_eq!(found, ["ARCHITECTURE.md:2: `docs/gone.md` does not exist: name what does"]);
    }

    #[test]
    fn a_link_is_a_path_unless_it_leads_to_the_web() {
        assert_eq!(messages("[a](docs/method.md#e3) [b](https://example.org) [c](#d)"), [""; 0]);
        assert_eq!(messages("[a](docs/gone.md)").len(), 1);
    }

    #[test]
    fn code_that_is_no_path_is_left_alone() {
        assert_eq!(messages("`cargo xtask ci`, `a::b`, `lib.rs`, `Motion`"), [""; 0]);
    }
}
