//! Files → what is too long: files, functions and lines.

use crate::code::functions;
use crate::violation::Violation;
use crate::workspace::Source;

/// Lines of a file that are no tests.
const FILE_LINES: usize = 400;
/// Lines of a function, signature and braces included.
const FUNCTION_LINES: usize = 60;
/// Characters of a line.
const LINE_CHARACTERS: usize = 100;

/// Every length beyond its limit. A line that holds an address may be longer.
pub(crate) fn check(source: &Source) -> Vec<Violation> {
    let mut violations = Vec::new();
    let n_lines = n_shipped_lines(source);
    if !source.is_test && n_lines > FILE_LINES {
        let message =
            format!("{n_lines} lines before its tests, limit {FILE_LINES}: cut it in two");
        violations.push(Violation::new(&source.path, FILE_LINES + 1, message));
    }
    for function in functions(&source.code) {
        if function.n_lines > FUNCTION_LINES {
            let message = format!(
                "fn {} has {} lines, limit {FUNCTION_LINES}: name its parts",
                function.name, function.n_lines
            );
            violations.push(Violation::new(&source.path, function.line, message));
        }
    }
    for (index, line) in source.text.lines().enumerate() {
        let n_characters = n_columns(line);
        if n_characters > LINE_CHARACTERS && !line.contains("https://") {
            let message = format!("{n_characters} characters, limit {LINE_CHARACTERS}: break it");
            violations.push(Violation::new(&source.path, index + 1, message));
        }
    }
    violations
}

/// Characters that take a column: the dot of q̇ does not.
fn n_columns(line: &str) -> usize {
    line.chars().filter(|c| !('\u{300}'..='\u{36f}').contains(c)).count()
}

/// Lines of the file less those under `#[cfg(test)]`.
fn n_shipped_lines(source: &Source) -> usize {
    let code: String = source.code.iter().collect();
    let shipped: String = source.shipped.iter().collect();
    let cut = code.lines().zip(shipped.lines()).filter(|(code, shipped)| code != shipped).count();
    source.text.lines().count() - cut
}

#[cfg(test)]
mod tests {
    use super::*;

    fn messages(within: &str, text: &str) -> Vec<String> {
        let source = Source::new("crates/a", &format!("crates/a/{within}"), text);
        check(&source).iter().map(ToString::to_string).collect()
    }

    #[test]
    fn a_file_is_measured_without_its_tests() {
        let shipped = "fn f() {}\n".repeat(400);
        let tests = format!("#[cfg(test)]\nmod tests {{\n{}}}\n", "fn g() {}\n".repeat(50));

        assert_eq!(messages("src/b.rs", &(shipped.clone() + &tests)), [""; 0]);
        assert_eq!(messages("src/b.rs", &(shipped.clone() + "fn h() {}\n")).len(), 1);
        assert_eq!(messages("tests/b.rs", &(shipped + "fn h() {}\n")), [""; 0]);
    }

    #[test]
    fn a_function_of_sixty_one_lines_is_reported_where_it_begins() {
        let short = format!("\nfn f() {{\n{}}}\n", "    g();\n".repeat(58));
        let long = format!("\nfn f() {{\n{}}}\n", "    g();\n".repeat(59));

        assert_eq!(messages("src/b.rs", &short), [""; 0]);
        assert!(messages("src/b.rs", &long)[0].starts_with("crates/a/src/b.rs:2: fn f has 61"));
    }

    #[test]
    fn lines_are_measured_as_they_look() {
        for letter in ["τ", "q̇", "q̈"] {
            assert_eq!(messages("src/b.rs", &letter.repeat(100)), [""; 0]);
            assert_eq!(messages("src/b.rs", &letter.repeat(101)).len(), 1);
        }
    }

    #[test]
    fn a_line_with_an_address_may_be_long() {
        let line = format!("// https://example.org/{}", "a".repeat(100));

        assert_eq!(messages("src/b.rs", &line), [""; 0]);
    }
}
