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
    if line.contains(" → ") || !needs_arrow(source) {
        return None;
    }
    let message = format!("the first line `{line}` has no arrow: say what becomes what");
    Some(Violation::new(&source.path, 1, message))
}

fn needs_arrow(source: &Source) -> bool {
    let module = source.module_path().unwrap_or_default();
    let turns_something = module.last().is_some_and(|name| name != "error");
    turns_something && !source.is_test
}

#[cfg(test)]
mod tests {
    use super::*;

    fn is_reported(within: &str, text: &str) -> bool {
        check(&Source::new("crates/a", &format!("crates/a/{within}"), text)).is_some()
    }

    #[test]
    fn a_module_says_what_becomes_what() {
        assert!(!is_reported("src/gram.rs", "//! Moments → Gram matrix: one pass.\n"));
        assert!(is_reported("src/gram.rs", "//! Gram matrices.\n"));
        assert!(is_reported("src/gram.rs", "use faer::Mat;\n"));
    }

    #[test]
    fn roots_errors_and_tests_need_no_arrow_but_a_line() {
        for within in ["src/lib.rs", "src/main.rs", "src/error.rs", "src/a/tests.rs", "tests/b.rs"]
        {
            assert!(!is_reported(within, "//! What it is.\n"), "{within}");
            assert!(is_reported(within, ""), "{within}");
        }
    }
}
