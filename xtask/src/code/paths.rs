//! Code → paths: what a file imports from its own crate, and what it re-exports.

use crate::code::{end_of_item, identifier, line_of, skip_space, word_at};

/// A path written out in full, such as `crate::select::lasso`, and its line.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Reference {
    /// Segments, the first one included; a glob ends in `*`.
    pub(crate) segments: Vec<String>,
    /// Line, from 1, where the path begins.
    pub(crate) line: usize,
}

/// Every path that begins with the word `first` (`crate` or `super`), use trees spread out.
pub(crate) fn paths_from(code: &[char], first: &str) -> Vec<Reference> {
    let begins = |at: &usize| {
        word_at(code, *at, first) && !code[..*at].ends_with(&[':']) && is_path(code, *at, first)
    };
    let mut found = Vec::new();
    for at in (0..code.len()).filter(begins) {
        for segments in leaves(code, at) {
            found.push(Reference { segments, line: line_of(code, at) });
        }
    }
    found
}

fn is_path(code: &[char], at: usize, first: &str) -> bool {
    code[at + first.len()..].starts_with(&[':', ':'])
}

/// Re-exports: the leaves of every plain `pub use`, each with its line.
pub(crate) fn public_uses(code: &[char]) -> Vec<Reference> {
    let mut found = Vec::new();
    for at in (0..code.len()).filter(|&at| word_at(code, at, "pub")) {
        let word = skip_space(code, at + 3);
        if !word_at(code, word, "use") {
            continue;
        }
        let tree = skip_space(code, word + 3);
        for segments in leaves(&code[..end_of_use(code, tree)], tree) {
            found.push(Reference { segments, line: line_of(code, at) });
        }
    }
    found
}

fn end_of_use(code: &[char], tree: usize) -> usize {
    let length = code[tree..].iter().position(|&c| c == ';');
    length.map_or_else(|| end_of_item(code, tree), |length| tree + length)
}

/// The leaves of the path or use tree at `position`; a renamed leaf ends in its new name.
fn leaves(code: &[char], position: usize) -> Vec<Vec<String>> {
    let mut found = Vec::new();
    walk(code, position, &[], &mut found);
    found
}

/// Reads one tree, adds its leaves to `found`, and returns the position after it.
fn walk(code: &[char], position: usize, prefix: &[String], found: &mut Vec<Vec<String>>) -> usize {
    let mut path = prefix.to_vec();
    let mut at = skip_space(code, position);
    loop {
        match code.get(at) {
            Some('{') => return walk_group(code, at + 1, &path, found),
            Some('*') => {
                path.push("*".to_owned());
                at += 1;
            }
            _ => {
                let word = identifier(code, at);
                at += word.chars().count();
                if !word.is_empty() && word != "self" {
                    path.push(word);
                }
            }
        }
        if !code[at.min(code.len())..].starts_with(&[':', ':']) {
            break;
        }
        at = skip_space(code, at + 2);
    }
    let renamed = skip_space(code, at);
    if word_at(code, renamed, "as") {
        let name = skip_space(code, renamed + 2);
        let word = identifier(code, name);
        at = name + word.chars().count();
        path.pop();
        path.push(word);
    }
    if path.len() > prefix.len() || !prefix.is_empty() {
        found.push(path);
    }
    at
}

/// The trees between braces, separated by commas; `position` is after the opening brace.
fn walk_group(
    code: &[char],
    position: usize,
    prefix: &[String],
    found: &mut Vec<Vec<String>>,
) -> usize {
    let mut at = skip_space(code, position);
    while at < code.len() && code[at] != '}' {
        let next = skip_space(code, walk(code, at, prefix, found));
        at = match code.get(next) {
            Some(',') => skip_space(code, next + 1),
            Some('}') => next,
            // Not a use tree after all: give up on this group.
            _ => return next,
        };
    }
    at + 1
}

#[cfg(test)]
mod tests {
    use super::*;

    fn joined(references: &[Reference]) -> Vec<(String, usize)> {
        references.iter().map(|r| (r.segments.join("::"), r.line)).collect()
    }

    #[test]
    fn nested_groups_are_spread_out() {
        let code: Vec<char> = "use crate::{a::{B, c::D}, e, f as g};".chars().collect();

        let found = joined(&paths_from(&code, "crate"));

        let paths: Vec<&str> = found.iter().map(|(path, _)| path.as_str()).collect();
        assert_eq!(paths, ["crate::a::B", "crate::a::c::D", "crate::e", "crate::g"]);
    }

    #[test]
    fn a_path_in_an_expression_is_found_with_its_line() {
        let code: Vec<char> = "fn f() {\n  crate::gram::add(x)\n}".chars().collect();

        assert_eq!(joined(&paths_from(&code, "crate")), [("crate::gram::add".to_owned(), 2)]);
    }

    #[test]
    fn pub_crate_is_no_path() {
        let code: Vec<char> = "pub(crate) fn f() {}".chars().collect();

        assert_eq!(paths_from(&code, "crate"), []);
    }

    #[test]
    fn a_chain_of_supers_is_one_path() {
        let code: Vec<char> = "use super::super::gram;".chars().collect();

        let found = joined(&paths_from(&code, "super"));

        assert_eq!(found, [("super::super::gram".to_owned(), 1)]);
    }

    #[test]
    fn re_exports_are_listed_by_their_public_names() {
        let text = "pub use a::{B, C as D};\nuse e::F;\npub(crate) use g::H;\npub use i::*;";
        let code: Vec<char> = text.chars().collect();

        let found = joined(&public_uses(&code));

        let names: Vec<&str> = found.iter().filter_map(|(p, _)| p.rsplit("::").next()).collect();
        assert_eq!(names, ["B", "D", "*"]);
    }

    #[test]
    fn an_unclosed_group_ends_the_search() {
        let code: Vec<char> = "use crate::{a, b(".chars().collect();

        assert_eq!(paths_from(&code, "crate").len(), 2);
    }
}
