//! Templates filled with values.

use crate::Result;
use minijinja::syntax::SyntaxConfig;
use minijinja::{AutoEscape, Environment, UndefinedBehavior, Value, escape_formatter};

/// A template filled with values; what is no value is an error.
///
/// - `kind`: `code`, or `xml`, of which all values are escaped, and control characters become blanks
pub(crate) fn filled(kind: &str, template: &str, values: Value) -> Result<String> {
    let mut environment = Environment::new();
    environment.set_undefined_behavior(UndefinedBehavior::SemiStrict);
    environment.set_auto_escape_callback(|kind| match kind {
        "xml" => AutoEscape::Custom("xml".into()),
        _ => AutoEscape::None,
    });
    environment.set_formatter(|out, state, value| match state.auto_escape() {
        AutoEscape::Custom(_) if value.is_safe() => Ok(write!(out, "{value}")?),
        AutoEscape::Custom(_) => {
            let text = value.to_string().replace(char::is_control, " ");
            Ok(out.write_str(&quick_xml::escape::escape(text))?)
        }
        _ => escape_formatter(out, state, value),
    });
    let syntax = SyntaxConfig::builder()
        .trim_blocks(true)
        .lstrip_blocks(true)
        .keep_trailing_newline(true)
        .build()?;
    environment.set_syntax(syntax);
    Ok(environment.render_named_str(kind, template, values)?)
}
