//! Words and HTML for the templates of a page.

use crate::Result;
use minijinja::Value;
use serde::Serialize;

/// Words, escaped where a page writes them, or an equation, which is HTML already.
pub type Label = Value;

/// HTML that a template takes over as it is.
pub(crate) fn safe(html: &str) -> Value {
    Value::from_safe_string(html.to_owned())
}

/// Data as JSON that can stand within a script tag: no letter of it can end the tag or open a
/// comment.
pub(crate) fn script_json(data: &impl Serialize) -> Result<String> {
    let escape = |json: String, c: char| json.replace(c, &format!("\\u{:04x}", u32::from(c)));
    let unsafe_letters = ['<', '>', '&', '\u{2028}', '\u{2029}'];
    Ok(unsafe_letters.into_iter().fold(serde_json::to_string(data)?, escape))
}
