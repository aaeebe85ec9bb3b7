//! Rust text → code: what stands in comments and in literals becomes blanks.

use crate::code::is_word;

/// The text with comments, strings and characters blanked; length and line breaks are kept.
pub(crate) fn blank(text: &str) -> Vec<char> {
    let mut code: Vec<char> = text.chars().collect();
    let mut at = 0;
    while at < code.len() {
        let Some(end) = end_of_hidden(&code, at) else {
            at += 1;
            continue;
        };
        for c in &mut code[at..end] {
            if *c != '\n' {
                *c = ' ';
            }
        }
        at = end;
    }
    code
}

/// Where the comment or literal that starts at `at` ends; `None` if none starts there.
fn end_of_hidden(code: &[char], at: usize) -> Option<usize> {
    match (code[at], code.get(at + 1)) {
        ('/', Some('/')) => Some(end_of_line(code, at)),
        ('/', Some('*')) => Some(end_of_block_comment(code, at)),
        ('"', _) => Some(end_of_string(code, at)),
        ('\'', _) => end_of_character(code, at),
        ('r', _) if starts_literal(code, at) => end_of_raw_string(code, at),
        _ => None,
    }
}

fn end_of_line(code: &[char], at: usize) -> usize {
    at + code[at..].iter().take_while(|&&c| c != '\n').count()
}

/// Block comments nest.
fn end_of_block_comment(code: &[char], start: usize) -> usize {
    let (mut at, mut depth) = (start, 0_usize);
    while at < code.len() {
        match (code[at], code.get(at + 1)) {
            ('/', Some('*')) => depth += 1,
            ('*', Some('/')) => depth -= 1,
            _ => {
                at += 1;
                continue;
            }
        }
        at += 2;
        if depth == 0 {
            return at;
        }
    }
    code.len()
}

fn end_of_string(code: &[char], start: usize) -> usize {
    let mut at = start + 1;
    while at < code.len() {
        match code[at] {
            '\\' => at += 2,
            '"' => return at + 1,
            _ => at += 1,
        }
    }
    code.len()
}

/// `None` for a lifetime, which has no closing quote.
fn end_of_character(code: &[char], start: usize) -> Option<usize> {
    if code.get(start + 1) == Some(&'\\') {
        let closing = code.iter().skip(start + 3).position(|&c| c == '\'')?;
        return Some(start + 3 + closing + 1);
    }
    (code.get(start + 2) == Some(&'\'')).then_some(start + 3)
}

/// `r` begins a raw string unless it is the last letter of a longer word; `br` and `cr` also do.
fn starts_literal(code: &[char], at: usize) -> bool {
    let before = |back: usize| at.checked_sub(back).map(|position| code[position]);
    match before(1) {
        Some('b' | 'c') => before(2).is_none_or(|c| !is_word(c)),
        Some(c) => !is_word(c),
        None => true,
    }
}

fn end_of_raw_string(code: &[char], start: usize) -> Option<usize> {
    let hashes = code[start + 1..].iter().take_while(|&&c| c == '#').count();
    let quote = start + 1 + hashes;
    if code.get(quote) != Some(&'"') {
        return None;
    }
    let closes = |at: usize| {
        code[at] == '"'
            && code[at + 1..].iter().take(hashes).filter(|&&c| c == '#').count() == hashes
    };
    let end = (quote + 1..code.len()).find(|&at| closes(at));
    Some(end.map_or(code.len(), |at| at + 1 + hashes))
}

#[cfg(test)]
mod tests {
    use super::blank;

    fn blanked(text: &str) -> String {
        blank(text).into_iter().collect()
    }

    #[test]
    fn comments_become_blanks_and_lines_stay() {
        assert_eq!(blanked("a // {\nb /* { /* } */ */ c"), "a     \nb                 c");
    }

    #[test]
    fn strings_become_blanks_with_their_escapes() {
        assert_eq!(blanked(r#"f("{\"{", 'x', '\'')"#), "f(      ,    ,     )");
    }

    #[test]
    fn raw_strings_end_at_their_own_hashes() {
        assert_eq!(blanked("r#\"{\"}\"# + br\"{\" + r"), "         + b     + r");
    }

    #[test]
    fn a_lifetime_is_code() {
        assert_eq!(blanked("fn f<'a>(x: &'a str) {}"), "fn f<'a>(x: &'a str) {}");
    }

    #[test]
    fn an_unclosed_literal_reaches_to_the_end() {
        assert_eq!(blanked("x \"abc"), "x     ");
    }
}
