//! A program as one file of C99: no allocation, no library but `math.h`.

use crate::text::{Body, Language, number, quoted, signal_of, values};
use crate::{ExportError, Function, Precision, Program, Result, Role, filled};
use minijinja::context;

pub(crate) struct C(pub(crate) Precision);

impl C {
    /// Type of a number, and the end of literals and functions of it.
    fn real(&self) -> (&'static str, &'static str) {
        if self.0 == Precision::Single { ("float", "f") } else { ("double", "") }
    }
}

impl Language for C {
    fn constant(&self, value: f64) -> String {
        number(value, self.0) + self.real().1
    }

    fn name(&self, function: Function) -> String {
        let (_, f) = self.real();
        match function {
            Function::Tanh => format!("tanh{f}"),
            Function::Exp => format!("exp{f}"),
            Function::Sign => "sign".into(),
            Function::Positive => "positive".into(),
            Function::Abs => format!("fabs{f}"),
            Function::Reciprocal => format!("1.0{f}/"),
        }
    }

    /// A string literal: bytes beyond ASCII by their octal codes, and no trigraphs.
    fn quoted(&self, text: &str) -> String {
        quoted(text.bytes().map(char::from), "\"\\?", |byte| format!("\\{byte:03o}"))
    }

    fn statements(&self, body: &Body, role: Role, program: &Program) -> Vec<String> {
        let (real, f) = self.real();
        let signals = role.signals();
        let named = |(name, value): &(String, String)| format!("const {real} {name} = {value};");
        let mut lines: Vec<String> = body.read(&signals, "state->").iter().map(named).collect();
        for (joint, angle) in &body.angles {
            let j = joint + 1;
            lines.extend(angle.sin.then(|| format!("const {real} s{j} = sin{f}(q{j});")));
            lines.extend(angle.cos.then(|| format!("const {real} c{j} = cos{f}(q{j});")));
        }
        lines.extend(body.steps.iter().map(named));
        let (result, has_state) = match role {
            Role::Function(quantity) => (quantity.result(), false),
            Role::After(quantity) => (quantity.result(), true),
            Role::Step => ("state->x", false),
            Role::Momentum => ("now", program.n_elements > 0),
        };
        let results = body.results.iter().enumerate();
        lines.extend(results.map(|(k, expression)| format!("{result}[{k}] = {expression};")));
        let is_state = |&input| !signals.contains(&signal_of(input).0);
        if has_state && !body.inputs.iter().any(is_state) {
            lines.push("(void)state;".into());
        }
        let unread = signals.iter().filter(|signal| !body.reads(signal));
        lines.extend(unread.map(|signal| format!("(void){signal};")));
        lines
    }
}

/// A file of C99 with the functions `NAME_torque`, `NAME_gravity` and so on; see `docs/export.md`.
///
/// - `name`: what every function begins with, a C identifier
///
/// # Errors
/// [`ExportError::Name`] if the name is none, [`ExportError::NotSingle`] if a constant is too large
/// for the precision.
pub fn to_c(program: &Program, name: &str, precision: Precision) -> Result<String> {
    check_name(name)?;
    program.check_precision(precision)?;
    let language = C(precision);
    let ((real, f), upper) = (language.real(), name.to_uppercase());
    let values = context! { name, upper, real, f, ..values(program, &language) };
    filled("code", include_str!("templates/model.c.j2"), values)
}

/// The first lines of a file that calls the functions of a C file as MODEL(name); they define
/// REMEMBERS where friction does.
pub(crate) fn inclusion(program: &Program, name: &str) -> String {
    let remembers = if program.n_elements > 0 { "#define REMEMBERS\n" } else { "" };
    format!(
        "#define {}_DECLARATIONS_ONLY\n#include \"{name}.c\"\n\n\
         #define MODEL(function) {name}_##function\n{remembers}",
        name.to_uppercase()
    )
}

pub(crate) fn check_name(name: &str) -> Result<()> {
    let mut letters = name.chars();
    let first = letters.next().is_some_and(|letter| letter.is_ascii_alphabetic());
    if first && letters.all(|letter| letter.is_ascii_alphanumeric() || letter == '_') {
        Ok(())
    } else {
        Err(ExportError::Name { name: name.into() })
    }
}
