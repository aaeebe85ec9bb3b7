//! XML text → nothing: refuses what would overwhelm the XML reader.

use crate::error::DynamicsError;

/// Elements within elements at most; a URDF needs 5, its extensions a few more.
const MAX_DEPTH: usize = 64;

/// Refuses elements nested so deep that a recursive reader would run out of stack, and the
/// declarations through which a small text can unfold into a huge one.
///
/// # Errors
/// [`DynamicsError::Depth`] or [`DynamicsError::Markup`], with the place.
pub(crate) fn check(text: &str) -> Result<(), DynamicsError> {
    let bytes = text.as_bytes();
    let mut depth = 0_usize;
    let mut at = 0;
    while let Some(step) = bytes
        .get(at..)
        .and_then(|rest| rest.iter().position(|&b| b == b'<'))
    {
        let start = at + step;
        let rest = &bytes[start..];
        at = start
            + match rest {
                [b'<', b'!', b'-', b'-', ..] => past(rest, 4, b"-->"),
                [b'<', b'?', ..] => past(rest, 2, b"?>"),
                [b'<', b'!', ..] => {
                    let what = "a <!DOCTYPE or <![CDATA[ section";
                    return Err(DynamicsError::Markup { byte: start, what });
                }
                [b'<', b'/', ..] => {
                    depth = depth.saturating_sub(1);
                    past(rest, 2, b">")
                }
                _ => {
                    let length = tag_length(rest);
                    depth += usize::from(!rest[..length].ends_with(b"/>"));
                    length
                }
            };
        if depth > MAX_DEPTH {
            return Err(DynamicsError::Depth {
                byte: start,
                limit: MAX_DEPTH,
            });
        }
    }
    Ok(())
}

/// Bytes up to and with the first `end` after `from`, or all.
fn past(rest: &[u8], from: usize, end: &[u8]) -> usize {
    rest.get(from..)
        .and_then(|tail| tail.windows(end.len()).position(|window| window == end))
        .map_or(rest.len(), |found| from + found + end.len())
}

/// Bytes of an opening tag; a `>` within quotes does not close it.
fn tag_length(rest: &[u8]) -> usize {
    let mut quote = None;
    for (index, &byte) in rest.iter().enumerate() {
        match (quote, byte) {
            (None, b'>') => return index + 1,
            (None, b'"' | b'\'') => quote = Some(byte),
            (Some(open), _) if open == byte => quote = None,
            _ => {}
        }
    }
    rest.len()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plain_urdf_passes() {
        let text = "<?xml version='1.0'?><!-- <deep> --><robot name='a>b'><link/></robot>";

        assert!(check(text).is_ok());
    }

    #[test]
    fn many_elements_side_by_side_are_not_deep() {
        let text = format!(
            "<robot>{}</robot>",
            "<link name='a/'><x/></link>".repeat(500)
        );

        assert!(check(&text).is_ok());
    }

    #[test]
    fn a_hundred_thousand_open_elements_are_refused() {
        let error = check(&"<a>".repeat(100_000)).unwrap_err();

        assert!(matches!(
            error,
            DynamicsError::Depth {
                byte: 192,
                limit: 64
            }
        ));
    }

    #[test]
    fn a_document_type_with_entities_is_refused() {
        let error = check("<!DOCTYPE a [<!ENTITY b 'bbbb'>]><robot/>").unwrap_err();

        assert!(matches!(error, DynamicsError::Markup { byte: 0, .. }));
    }
}
