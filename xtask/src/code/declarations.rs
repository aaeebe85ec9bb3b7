//! Code → declarations: modules in reading order, functions with their lengths, named items.

use crate::code::{end_of_item, identifier, line_of, skip_space, word_at};

/// A module declared by `mod name;`.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Child {
    /// Its name, which is that of its file.
    pub(crate) name: String,
    /// Line of the declaration, from 1.
    pub(crate) line: usize,
}

/// A named item: its keyword, name and lines.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Item {
    /// `fn`, `struct`, `enum`, `trait`, `type`, `const`, `static` or `mod`.
    pub(crate) keyword: &'static str,
    /// Its name.
    pub(crate) name: String,
    /// Line of the keyword, from 1.
    pub(crate) line: usize,
    /// Lines from the keyword to the end of the item.
    pub(crate) n_lines: usize,
    /// Whether it is plainly `pub` and stands outside every block.
    pub(crate) is_public: bool,
}

const KEYWORDS: [&str; 8] = ["fn", "struct", "enum", "trait", "type", "const", "static", "mod"];

/// The modules a file declares, in the order it declares them.
pub(crate) fn children(code: &[char]) -> Vec<Child> {
    let declared = items(code).into_iter().filter(|item| item.keyword == "mod");
    declared
        .filter(|item| ends_in_semicolon(code, item))
        .map(|item| Child { name: item.name, line: item.line })
        .collect()
}

fn ends_in_semicolon(code: &[char], item: &Item) -> bool {
    let text: String = code.iter().collect();
    let line = text.lines().nth(item.line - 1).unwrap_or_default();
    line.trim_end().ends_with(';')
}

/// Every function that has a body, or is declared without one.
pub(crate) fn functions(code: &[char]) -> Vec<Item> {
    items(code).into_iter().filter(|item| item.keyword == "fn").collect()
}

/// Every named item, in order.
pub(crate) fn items(code: &[char]) -> Vec<Item> {
    let mut depth = 0_usize;
    let mut found = Vec::new();
    for at in 0..code.len() {
        match code[at] {
            '{' => depth += 1,
            '}' => depth = depth.saturating_sub(1),
            _ => {}
        }
        let Some(keyword) = KEYWORDS.into_iter().find(|word| word_at(code, at, word)) else {
            continue;
        };
        let name = identifier(code, skip_space(code, at + keyword.len()));
        // `fn(f64)` is a type, `*const T` and `&'static T` are pointers, `const fn` is met again.
        let is_keyword = KEYWORDS.contains(&name.as_str()) || name == "unsafe";
        if name.is_empty() || is_keyword || at > 0 && matches!(code[at - 1], '*' | '\'') {
            continue;
        }
        let (line, end) = (line_of(code, at), end_of_item(code, at));
        found.push(Item {
            keyword,
            name,
            line,
            n_lines: line_of(code, end - 1) - line + 1,
            is_public: depth == 0 && follows_pub(code, at),
        });
    }
    found
}

/// Whether the line of `at` begins with a plain `pub`.
fn follows_pub(code: &[char], at: usize) -> bool {
    let start = code[..at].iter().rposition(|&c| c == '\n').map_or(0, |newline| newline + 1);
    let first = skip_space(code, start);
    word_at(code, first, "pub") && code.get(first + 3) != Some(&'(')
}

#[cfg(test)]
mod tests {
    use super::*;

    fn code(text: &str) -> Vec<char> {
        text.chars().collect()
    }

    #[test]
    fn modules_come_in_the_order_they_are_declared() {
        let found = children(&code("pub mod term;\nmod library;\nmod inline { }\n"));

        let names: Vec<&str> = found.iter().map(|child| child.name.as_str()).collect();
        assert_eq!(names, ["term", "library"]);
    }

    #[test]
    fn a_function_is_as_long_as_its_braces_say() {
        let text =
            "impl A {\n    pub fn f(\n        x: [f64; 3],\n    ) -> f64 {\n        {}\n    }\n}";

        let found = functions(&code(text));

        assert_eq!((found[0].line, found[0].n_lines), (2, 5));
        assert!(!found[0].is_public, "it is public in its type, not in the module");
    }

    #[test]
    fn a_pointer_declares_nothing() {
        assert_eq!(items(&code("x: fn(f64) -> f64, y: *const T, z: &'static str")), []);
    }

    #[test]
    fn a_const_function_is_one_item() {
        let found = items(&code("pub const fn order() -> usize { 3 }"));

        assert_eq!(found.len(), 1);
        assert_eq!((found[0].keyword, found[0].is_public), ("fn", true));
    }

    #[test]
    fn pub_crate_is_not_public() {
        assert!(!items(&code("pub(crate) struct Item;"))[0].is_public);
    }
}
