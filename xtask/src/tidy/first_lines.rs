//! Files → missing first lines: each file says what becomes what.

use crate::violation::Violation;
use crate::workspace::Source;

/// A file starts with `//! A → B: one line`. A crate root says what the crate holds, and `error.rs`
/// what can be wrong; they, and files outside `src`, need the line but not the arrow.
pub(crate) fn check(source: &Source) -> Option<Violation> {
    let Some(line) = source.first_line().filter(|line| !line.trim().is_empty()) else {
        let message = "the first line is not `//! A → B: one line`: say what becomes what";
        return Some(Violation::new(&source.path, 1, message));
    };
    let turns = line
        .split_once(" → ")
        .is_some_and(|(_, rest)| rest.contains(": "));
    if turns || !needs_arrow(source) {
        return None;
    }
    let message = format!("the first line `{line}` has no `A → B: `: say what becomes what");
    Some(Violation::new(&source.path, 1, message))
}

fn needs_arrow(source: &Source) -> bool {
    match source.module_path() {
        Some(module) => {
            let is_error = module.last().is_some_and(|name| name == "error");
            !module.is_empty() && !is_error && !source.is_test
        }
        None => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn is_reported(within: &str, text: &str) -> bool {
        check(&Source::new(
            "crates/a",
            &format!("crates/a/{within}"),
            text,
        ))
        .is_some()
    }

    #[test]
    fn a_module_says_what_becomes_what() {
        assert!(!is_reported(
            "src/gram.rs",
            "//! Moments → Gram matrix: one pass.\n"
        ));
        assert!(is_reported("src/gram.rs", "//! Gram matrices.\n"));
        assert!(is_reported("src/gram.rs", "//! Moments → Gram matrix\n"));
        assert!(is_reported("src/gram.rs", "use faer::Mat;\n"));
    }

    #[test]
    fn roots_errors_and_tests_need_no_arrow_but_a_line() {
        for within in [
            "src/lib.rs",
            "src/main.rs",
            "src/error.rs",
            "src/a/tests.rs",
            "tests/b.rs",
        ] {
            assert!(!is_reported(within, "//! What it is.\n"), "{within}");
            assert!(is_reported(within, ""), "{within}");
        }
    }
}
