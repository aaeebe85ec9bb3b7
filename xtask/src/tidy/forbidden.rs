//! Code → forbidden calls: what would panic on bad input, silence a lint or skip a test.

use crate::code::line_of;
use crate::violation::Violation;
use crate::workspace::Source;

/// Not even in tests, and what to do instead.
const NOWHERE: [(&str, &str); 5] = [
    ("#[allow(", "obey the lint, or say why with #[expect(…, reason = …)]"),
    ("#![allow(", "obey the lint, or say why with #![expect(…, reason = …)]"),
    ("#[ignore", "a test that does not run proves nothing: run it or drop it"),
    ("#[should_panic", "assert the error instead"),
    ("dbg!(", "drop it"),
];

/// Only in tests, and what to do instead.
const ONLY_IN_TESTS: [(&str, &str); 4] = [
    (".unwrap()", "return an error"),
    (".expect(", "return an error"),
    ("todo!(", "write it"),
    ("unimplemented!(", "write it"),
];

/// Crates that may open files; every other one takes bytes and returns text.
const MAY_OPEN_FILES: [&str; 4] =
    ["crates/torquewise-logs/", "crates/torquewise-model/", "crates/torquewise-cli/", "xtask/"];

/// Every forbidden piece of code, with its line.
pub(crate) fn check(source: &Source) -> Vec<Violation> {
    let mut violations = find(source, &source.code, &NOWHERE);
    if source.module_path().is_none() || source.is_test {
        return violations;
    }
    violations.extend(find(source, &source.shipped, &ONLY_IN_TESTS));
    if !MAY_OPEN_FILES.iter().any(|folder| source.path.starts_with(folder)) {
        let instead = "only logs, model and the command line touch files: take bytes instead";
        violations.extend(find(source, &source.shipped, &[("std::fs", instead)]));
    }
    violations
}

fn find(source: &Source, code: &[char], patterns: &[(&str, &str)]) -> Vec<Violation> {
    let mut violations = Vec::new();
    for (pattern, instead) in patterns {
        let wanted: Vec<char> = pattern.chars().collect();
        for at in (0..code.len()).filter(|&at| code[at..].starts_with(&wanted)) {
            let message = format!("`{pattern}` is forbidden here: {instead}");
            violations.push(Violation::new(&source.path, line_of(code, at), message));
        }
    }
    violations
}

#[cfg(test)]
mod tests {
    use super::*;

    fn is_reported(path: &str, text: &str) -> bool {
        !check(&Source::new("crates/torquewise-regression", path, text)).is_empty()
    }

    const SHIPPED: &str = "crates/torquewise-regression/src/gram.rs";
    const TESTS: &str = "crates/torquewise-regression/tests/contract.rs";

    #[test]
    fn a_panic_on_bad_input_is_for_tests_only() {
        let text = "fn f() { g().unwrap() }";
        let tested = format!("#[cfg(test)]\nmod tests {{ {text} }}");

        assert!(is_reported(SHIPPED, text));
        assert!(!is_reported(SHIPPED, &tested));
        assert!(!is_reported(TESTS, text));
    }

    #[test]
    fn a_lint_is_silenced_nowhere() {
        assert!(is_reported(SHIPPED, "#[allow(dead_code)]\nfn f() {}"));
        assert!(is_reported(TESTS, "#[allow(dead_code)]\nfn f() {}"));
        assert!(!is_reported(SHIPPED, "#[expect(dead_code, reason = \"why\")]\nfn f() {}"));
    }

    #[test]
    fn a_doc_example_may_unwrap() {
        assert!(!is_reported(SHIPPED, "/// let x = f().unwrap();\nfn f() {}"));
    }

    #[test]
    fn only_openers_touch_files() {
        let text = "use std::fs::File;";

        assert!(is_reported(SHIPPED, text));
        assert!(!is_reported("crates/torquewise-logs/src/csv.rs", text));
    }
}
