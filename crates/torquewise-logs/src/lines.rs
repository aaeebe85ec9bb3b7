//! Bytes → lines → fields: text split in bounded memory, whatever it holds.

use std::io::{self, BufRead, Read};
use std::ops::Range;

pub(crate) const MAX_LINE: usize = 1 << 20;

const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

/// The lines of a text, read one at a time into the same buffer.
pub(crate) struct Lines<R> {
    input: R,
    pub(crate) line: Vec<u8>,
    pub(crate) number: u64,
    /// Whether the text ends within the line.
    pub(crate) is_cut_off: bool,
}

impl<R: BufRead> Lines<R> {
    pub(crate) fn new(input: R) -> Self {
        Self { input, line: Vec::new(), number: 0, is_cut_off: false }
    }

    /// Reads the next line; its end (LF or CRLF) and a byte order mark are taken off. Of a line that is
    /// too long over [`MAX_LINE`] bytes are read; `false` at the end of the text.
    pub(crate) fn advance(&mut self) -> io::Result<bool> {
        self.line.clear();
        let limit = MAX_LINE as u64 + 2;
        if self.input.by_ref().take(limit).read_until(b'\n', &mut self.line)? == 0 {
            return Ok(false);
        }
        self.number += 1;
        self.is_cut_off = self.line.last() != Some(&b'\n');
        for end in [b'\n', b'\r'] {
            if self.line.last() == Some(&end) {
                self.line.pop();
            }
        }
        if self.number == 1 && self.line.starts_with(BYTE_ORDER_MARK) {
            self.line.drain(..BYTE_ORDER_MARK.len());
        }
        Ok(true)
    }
}

/// Puts the places of the fields of `line` into `fields`; quotes around a field are left out.
///
/// Returns `false` if a quoted field does not end in a quote followed by a comma or the line's end.
pub(crate) fn split(line: &[u8], fields: &mut Vec<Range<usize>>) -> bool {
    fields.clear();
    let mut start = 0;
    loop {
        let (field, next) = if line.get(start) == Some(&b'"') {
            let Some(close) = closing_quote(line, start + 1) else { return false };
            (start + 1..close, close + 1)
        } else {
            let length = line[start..].iter().position(|byte| *byte == b',');
            let end = length.map_or(line.len(), |length| start + length);
            (start..end, end)
        };
        fields.push(field);
        match line.get(next) {
            None => return true,
            Some(b',') => start = next + 1,
            Some(_) => return false,
        }
    }
}

fn closing_quote(line: &[u8], start: usize) -> Option<usize> {
    let mut at = start;
    loop {
        at += line.get(at..)?.iter().position(|byte| *byte == b'"')?;
        if line.get(at + 1) != Some(&b'"') {
            return Some(at);
        }
        at += 2;
    }
}

#[cfg(test)]
mod tests {
    use super::{Lines, MAX_LINE, split};
    use std::io::{BufReader, Read};

    fn fields(line: &str) -> Option<Vec<&str>> {
        let mut fields = Vec::new();
        split(line.as_bytes(), &mut fields).then(|| fields.into_iter().map(|f| &line[f]).collect())
    }

    #[test]
    fn fields_are_split_at_commas_outside_quotes_which_must_close() {
        assert_eq!(fields("a,b"), Some(vec!["a", "b"]));
        assert_eq!(fields(""), Some(vec![""]));
        assert_eq!(fields(",a,"), Some(vec!["", "a", ""]));
        assert_eq!(fields("\"a,b\",\"\",c"), Some(vec!["a,b", "", "c"]));
        assert_eq!(fields("\"a\"\"b\""), Some(vec!["a\"\"b"]));
        assert_eq!(fields("a\"b,c"), Some(vec!["a\"b", "c"]));
        for line in ["\"", "\"a", "\"a\"b,c", "\"a\"\"", "a,\"b"] {
            assert_eq!(fields(line), None, "{line}");
        }
    }

    #[test]
    fn a_line_of_the_longest_length_is_read() {
        let text = std::io::repeat(b'1').take(MAX_LINE as u64).chain(&b"\r\n2"[..]);
        let mut lines = Lines::new(BufReader::new(text));

        assert!(lines.advance().unwrap());
        assert_eq!(lines.line.len(), MAX_LINE);
        assert!(lines.advance().unwrap());
        assert_eq!(lines.line, b"2");
    }
}
