//! Names → empty names: files, modules, types and functions are named for what they hold.

use crate::code::{Item, items};
use crate::violation::Violation;
use crate::workspace::Source;

/// Words that say nothing about what a thing is.
const BANNED: [&str; 10] =
    ["util", "utils", "helper", "helpers", "common", "misc", "manager", "data", "info", "new2"];

/// Every file, folder and item with an empty name: a banned word for functions and constants, a
/// banned word anywhere in the name for files, folders, modules and types.
pub(crate) fn check(source: &Source) -> Vec<Violation> {
    let parts = source.within.trim_end_matches(".rs").split('/');
    let mut violations: Vec<Violation> = parts
        .filter_map(|part| banned_word(part).map(|word| (part, word)))
        .map(|(part, word)| Violation::new(&source.path, 1, message("path part", part, word)))
        .collect();
    for item in items(&source.code) {
        if let Some(word) = judged(&item) {
            let message = message(item.keyword, &item.name, word);
            violations.push(Violation::new(&source.path, item.line, message));
        }
    }
    violations
}

fn message(what: &str, name: &str, word: &str) -> String {
    format!("{what} {name}: `{word}` says nothing: name it for what it holds or does")
}

fn judged(item: &Item) -> Option<&'static str> {
    match item.keyword {
        "fn" | "const" | "static" => BANNED.into_iter().find(|word| item.name == *word),
        _ => banned_word(&item.name),
    }
}

/// The banned word among those that snake or camel case makes up.
fn banned_word(name: &str) -> Option<&'static str> {
    let mut words = vec![String::new()];
    for c in name.chars() {
        if c == '_' || c == '-' || c.is_uppercase() {
            words.push(String::new());
        }
        if let Some(word) = words.last_mut().filter(|_| c != '_' && c != '-') {
            word.extend(c.to_lowercase());
        }
    }
    BANNED.into_iter().find(|banned| words.iter().any(|word| word == banned))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn is_reported(within: &str, text: &str) -> bool {
        !check(&Source::new("crates/a", &format!("crates/a/{within}"), text)).is_empty()
    }

    #[test]
    fn an_empty_file_name_is_reported() {
        assert!(is_reported("src/utils.rs", ""));
        assert!(is_reported("tests/common/mod.rs", ""));
        assert!(is_reported("src/matrix_helpers.rs", ""));
        assert!(!is_reported("src/gram.rs", ""));
    }

    #[test]
    fn a_type_may_not_hold_an_empty_word() {
        assert!(is_reported("src/a.rs", "pub struct LogInfo;"));
        assert!(is_reported("src/a.rs", "enum Data { A }"));
        assert!(!is_reported("src/a.rs", "struct Database;"));
    }

    #[test]
    fn a_function_may_be_about_data_but_not_be_called_so() {
        assert!(is_reported("src/a.rs", "fn data() {}"));
        assert!(!is_reported("src/a.rs", "fn data_rows() {}"));
    }

    #[test]
    fn a_variable_is_no_item() {
        assert!(!is_reported("src/a.rs", "fn f() { let data = 1; }"));
    }
}
