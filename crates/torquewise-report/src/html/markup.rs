//! HTML that a page takes over as it is: words, once they are escaped, and equations.

use crate::error::Result;
use minijinja::{HtmlEscape, Value};
use serde::Serialize;
use std::fmt;

/// Words or an equation, as HTML; words are escaped.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Label(String);

impl Label {
    /// Takes HTML as it is: an equation, or a figure.
    ///
    /// Whoever makes one from text answers for it: words of a user are a label by `from`.
    pub fn trusted(html: impl Into<String>) -> Self {
        Self(html.into())
    }

    /// The HTML.
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl fmt::Display for Label {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl From<&str> for Label {
    fn from(text: &str) -> Self {
        Self(HtmlEscape(text).to_string())
    }
}

impl From<String> for Label {
    fn from(text: String) -> Self {
        text.as_str().into()
    }
}

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
