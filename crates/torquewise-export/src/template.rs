//! From template and values to text.

use crate::error::ExportError;
use minijinja::{Environment, UndefinedBehavior, Value};

/// A template filled with values; what is no value is an error.
pub(crate) fn filled(template: &str, values: Value) -> Result<String, ExportError> {
    let mut environment = Environment::new();
    environment.set_undefined_behavior(UndefinedBehavior::SemiStrict);
    environment.set_trim_blocks(true);
    environment.set_lstrip_blocks(true);
    environment.set_keep_trailing_newline(true);
    Ok(environment.render_str(template, values)?)
}
