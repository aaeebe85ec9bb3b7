//! A program as one file of Python that needs the standard library alone.

use crate::text::{Body, Language, number, quoted, values};
use crate::{Function, Precision, Program, Result, Role, filled};

pub(crate) struct Python;

impl Language for Python {
    fn constant(&self, value: f64) -> String {
        number(value, Precision::Double)
    }

    fn name(&self, function: Function) -> String {
        String::from(match function {
            Function::Tanh => "tanh",
            Function::Exp => "exp",
            Function::Sign => "_sign",
            Function::Positive => "_positive",
            Function::Abs => "abs",
            Function::Reciprocal => "1.0/",
        })
    }

    /// Whatever is not plain by its code.
    fn quoted(&self, text: &str) -> String {
        quoted(text.chars(), "\"\\", |letter| format!("\\U{letter:08x}"))
    }

    /// Signals by the names of their entries, steps, results; a sequence of another length is refused.
    fn statements(&self, body: &Body, role: Role, program: &Program) -> Vec<String> {
        let (n, elements) = (program.n_joints(), program.n_elements);
        let entries = |signal: &str, from: &str| {
            let count = if signal == "x" { elements } else { n };
            format!("{} = {from}", names(signal, count))
        };
        let [state, more]: [&[(&str, &str)]; 2] = match role {
            Role::After(_) => [&[("q", "self._q"), ("x", "self._x")], &[]],
            Role::Step => [&[], &[("last", "q if self._q is None else self._q"), ("x", "self._x")]],
            Role::Momentum if elements > 0 => [&[], &[("x", "x")]],
            _ => [&[], &[]],
        };
        let signals = role.signals().into_iter().map(|signal| (signal, signal));
        let read = state.iter().copied().chain(signals).chain(more.iter().copied());
        let mut lines: Vec<String> = read.map(|(signal, from)| entries(signal, from)).collect();
        for (joint, angle) in &body.angles {
            let j = joint + 1;
            lines.extend(angle.sin.then(|| format!("s{j} = sin(q{j})")));
            lines.extend(angle.cos.then(|| format!("c{j} = cos(q{j})")));
        }
        lines.extend(body.steps.iter().map(|(step, expression)| format!("{step} = {expression}")));
        if role == Role::Step {
            lines.extend(body.listed("self._x = ", None));
            lines.push(format!("self._q = ({})", names("q", n)));
        } else {
            lines.extend(body.listed("return ", role.columns(n)));
        }
        lines
    }
}

/// A Python module with the functions `torque`, `gravity` and so on; see `docs/export.md`.
///
/// # Errors
/// `ExportError::Template` if it cannot be written.
pub fn to_python(program: &Program) -> Result<String> {
    filled("code", include_str!("templates/model.py.j2"), values(program, &Python))
}

/// `q1, q2`; `q1,` of one.
fn names(signal: &str, count: usize) -> String {
    let names: Vec<String> = (1..=count).map(|place| format!("{signal}{place}")).collect();
    let comma = if count == 1 { "," } else { "" };
    names.join(", ") + comma
}
