//! Rust text → code: comments and literals blanked, tests cut, paths and modules read off.
//!
//! Blanks keep every line and column in place, so that a position in the code is one in the text.

mod blank;
mod shipped;
mod paths;
mod declarations;

pub(crate) use blank::blank;
pub(crate) use declarations::{Child, Item, children, functions, items};
pub(crate) use paths::{paths_from, public_uses};
pub(crate) use shipped::shipped;

/// Line, from 1, of the character at `position`.
pub(crate) fn line_of(code: &[char], position: usize) -> usize {
    1 + code.iter().take(position).filter(|&&c| c == '\n').count()
}

/// Whether `c` can be part of an identifier.
pub(crate) fn is_word(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

/// Whether `word` stands at `position`, as a whole word.
pub(crate) fn word_at(code: &[char], position: usize, word: &str) -> bool {
    let end = position + word.chars().count();
    end <= code.len()
        && code[position..end].iter().copied().eq(word.chars())
        && (position == 0 || !is_word(code[position - 1]))
        && code.get(end).is_none_or(|&c| !is_word(c))
}

/// The identifier that starts at `position`; empty if none does.
pub(crate) fn identifier(code: &[char], position: usize) -> String {
    code.iter().skip(position).take_while(|&&c| is_word(c)).collect()
}

/// First position at or after `position` that is not white space.
pub(crate) fn skip_space(code: &[char], position: usize) -> usize {
    let blanks = code.iter().skip(position).take_while(|c| c.is_whitespace()).count();
    position + blanks
}

/// Position after the block that starts at the first `{` from `position` on, or after the first `;`
/// outside brackets if that comes earlier. The end of the code if neither does.
pub(crate) fn end_of_item(code: &[char], position: usize) -> usize {
    let (mut braces, mut brackets) = (0_usize, 0_usize);
    for (at, &c) in code.iter().enumerate().skip(position) {
        match c {
            '(' | '[' => brackets += 1,
            ')' | ']' => brackets = brackets.saturating_sub(1),
            '{' => braces += 1,
            '}' if braces <= 1 => return at + 1,
            '}' => braces -= 1,
            ';' if braces == 0 && brackets == 0 => return at + 1,
            _ => {}
        }
    }
    code.len()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chars(text: &str) -> Vec<char> {
        text.chars().collect()
    }

    #[test]
    fn a_word_inside_another_is_not_found() {
        let code = chars("unsafe_fn fn x");

        assert!(!word_at(&code, 7, "fn"));
        assert!(word_at(&code, 10, "fn"));
    }

    #[test]
    fn an_item_ends_at_its_last_brace_or_its_semicolon() {
        let function = chars("fn f(x: [u8; 3]) { { } } rest");
        let statement = chars("use a::b; rest");

        assert_eq!(end_of_item(&function, 0), 24);
        assert_eq!(end_of_item(&statement, 0), 9);
    }

    #[test]
    fn lines_count_from_one() {
        let code = chars("a\nb\nc");

        assert_eq!([0, 2, 4].map(|position| line_of(&code, position)), [1, 2, 3]);
    }
}
