//! XML text → nothing: refuses what would overwhelm the XML reader.
//!
//! The reader below urdf-rs recurses into elements and panics on names without prefix (`:name`).
//! It takes more for a tag than XML does, so this scan is strict and refuses what it cannot follow.

use crate::error::DynamicsError;

/// Elements within elements at most; a URDF needs 5, its extensions a few more.
const MAX_DEPTH: usize = 64;

/// Refuses elements nested so deep that a recursive reader would run out of stack, tags that are
/// not well formed, and declarations through which a small text can unfold into a huge one.
///
/// # Errors
/// [`DynamicsError::Depth`] or [`DynamicsError::Markup`], with the place.
pub(crate) fn check(text: &str) -> Result<(), DynamicsError> {
    let bytes = text.as_bytes();
    let refuse = |byte, what| Err(DynamicsError::Markup { byte, what });
    let mut depth = 0_usize;
    let mut at = 0;
    while let Some(start) = find(bytes, at, b"<") {
        let end = match &bytes[start..] {
            [b'<', b'!', b'-', b'-', ..] => find(bytes, start + 4, b"-->").map(|end| end + 3),
            [b'<', b'!', ..] => return refuse(start, "a <!DOCTYPE or <![CDATA[ section"),
            [b'<', b'?', ..] => find(bytes, start + 2, b"?>").map(|end| end + 2),
            [b'<', b'/', ..] => {
                depth = depth.saturating_sub(1);
                find(bytes, start + 2, b">").map(|end| end + 1)
            }
            _ => {
                let end = tag_end(bytes, start + 1);
                let empty = end.is_some_and(|end| bytes[..end].ends_with(b"/>"));
                depth += usize::from(!empty);
                end
            }
        };
        if depth > MAX_DEPTH {
            return Err(DynamicsError::Depth { byte: start, limit: MAX_DEPTH });
        }
        let Some(end) = end else {
            return refuse(start, "a tag that is cut or not well formed");
        };
        if bytes[start..].starts_with(b"<?") && bytes[start + 2..end - 2].contains(&b'?') {
            return refuse(start, "a `?` within <? ?>");
        }
        at = end;
    }
    Ok(())
}

/// Place of the first `wanted` at or after `from`.
fn find(bytes: &[u8], from: usize, wanted: &[u8]) -> Option<usize> {
    let tail = bytes.get(from..)?;
    let found = tail.windows(wanted.len()).position(|window| window == wanted)?;
    Some(from + found)
}

/// Place after `name key="value" …>` or `…/>`; `None` if the text at `at` reads otherwise.
fn tag_end(bytes: &[u8], at: usize) -> Option<usize> {
    let mut at = name_end(bytes, at)?;
    loop {
        let next = past_blanks(bytes, at);
        match bytes.get(next)? {
            b'>' => return Some(next + 1),
            b'/' => return (*bytes.get(next + 1)? == b'>').then_some(next + 2),
            _ => {}
        }
        let equals = past_blanks(bytes, name_end(bytes, next)?);
        if *bytes.get(equals)? != b'=' {
            return None;
        }
        let open = past_blanks(bytes, equals + 1);
        let quote = *bytes.get(open)?;
        if quote != b'"' && quote != b'\'' {
            return None;
        }
        at = find(bytes, open + 1, &[quote])? + 1;
    }
}

/// Place after the name at `at`; `None` if there is none, or it starts with its colon.
fn name_end(bytes: &[u8], at: usize) -> Option<usize> {
    let is_name = |b: &u8| b.is_ascii_alphanumeric() || b"_-.:".contains(b) || !b.is_ascii();
    let length = bytes.get(at..)?.iter().take_while(|b| is_name(b)).count();
    (length > 0 && bytes[at] != b':').then_some(at + length)
}

fn past_blanks(bytes: &[u8], at: usize) -> usize {
    let tail = bytes.get(at..).unwrap_or_default();
    at + tail.iter().take_while(|b| b" \t\r\n".contains(b)).count()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plain_urdf_passes() {
        let text = "<?xml version='1.0'?><!-- <deep> --><robot name = 'a>b' xmlns:x=\"u\"\n><l/>\
                    <x:l a='/'  b=\"'\" /></robot >";

        assert!(check(text).is_ok());
    }

    #[test]
    fn many_elements_side_by_side_are_not_deep() {
        let text = format!("<robot>{}</robot>", "<link name='a/'><x/></link>".repeat(500));

        assert!(check(&text).is_ok());
    }

    #[test]
    fn a_hundred_thousand_open_elements_are_refused() {
        let error = check(&"<a>".repeat(100_000)).unwrap_err();

        assert!(matches!(error, DynamicsError::Depth { byte: 192, limit: 64 }));
    }

    #[test]
    fn tags_that_a_lenient_reader_would_nest_are_refused() {
        let hidden = [
            "<a b></a>=''>",
            "<a\"><b><b>\">",
            "<a b=''<c>",
            "<? ? > <b> ?>",
            "< a>",
            "<a / >",
            "<a :b='1'/>",
            "<a b='1':c='2'/>",
            "<a b",
            "<",
        ];

        for text in hidden {
            assert!(matches!(check(text), Err(DynamicsError::Markup { byte: 0, .. })), "{text}");
        }
    }

    #[test]
    fn a_document_type_with_entities_is_refused() {
        let error = check("<!DOCTYPE a [<!ENTITY b 'bbbb'>]><robot/>").unwrap_err();

        assert!(matches!(error, DynamicsError::Markup { byte: 0, .. }));
    }
}
