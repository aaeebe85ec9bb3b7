//! From program to one file of Python that needs the standard library alone.

use crate::error::ExportError;
use crate::graph::{Function, Id};
use crate::program::{Memory, Program, Quantity};
use crate::template::filled;
use crate::text::{Body, Language};
use minijinja::context;
use std::fmt::Write;

struct Python;

impl Language for Python {
    fn constant(&self, value: f64) -> String {
        format!("{value:?}")
    }

    fn call(&self, function: Function, argument: &str) -> String {
        match function {
            Function::Tanh => format!("tanh({argument})"),
            Function::Exp => format!("exp({argument})"),
            Function::Sign => format!("_sign({argument})"),
            Function::Positive => format!("_positive({argument})"),
            Function::Abs => format!("abs({argument})"),
            Function::Reciprocal => format!("1.0/({argument})"),
        }
    }
}

/// A Python module with the functions `torque`, `gravity` and so on; see `docs/export.md`.
///
/// # Errors
/// [`ExportError::Template`] if it cannot be written.
#[expect(clippy::too_many_lines, reason = "one value of the template after the other")]
pub fn to_python(program: &Program) -> Result<String, ExportError> {
    let n = program.n_joints();
    // Signals by the names of their entries, steps, results.
    let lines = |roots: &[Id], read: Vec<String>, results: &str, columns: Option<usize>| {
        let body = Body::of(&program.graph, roots, &Python);
        read.into_iter()
            .chain(steps(&body))
            .chain(body.listed(results, columns))
            .collect::<Vec<_>>()
    };
    let signals = |names: &[&str]| -> Vec<String> {
        names.iter().map(|signal| unpacked(signal, n, signal)).collect()
    };
    let doc = |quantity: Quantity, roots: &[Id]| {
        format!("{}: {}", quantity.formula(), program.cost_of(roots))
    };
    let functions = program.functions.iter().map(|(quantity, roots)| {
        let columns = quantity.is_matrix().then_some(n);
        context! {
            name => quantity.name(),
            signals => quantity.signals().to_vec(),
            doc => doc(*quantity, roots),
            lines => lines(roots, signals(quantity.signals()), "return ", columns),
        }
    });
    let memory = program.memory.as_ref().map(|memory| {
        let count = memory.states.len();
        let after = memory.after.iter().map(|(quantity, roots)| {
            let own: Vec<&str> = Memory::signals(*quantity).collect();
            let state = vec![unpacked("q", n, "self._q"), unpacked("x", count, "self._x")];
            context! {
                name => quantity.name(),
                signals => [&["self"], &own[..]].concat(),
                doc => doc(*quantity, roots),
                lines => lines(roots, [state, signals(&own)].concat(), "return ", None),
            }
        });
        let read = vec![
            unpacked("q", n, "q"),
            unpacked("last", n, "q if self._q is None else self._q"),
            unpacked("x", count, "self._x"),
        ];
        let mut step = lines(&memory.states, read, "self._x = ", None);
        step.push(format!("self._q = ({})", names("q", n)));
        context! {
            elements => count,
            step_cost => program.cost_of(&memory.states).to_string(),
            step,
            after => after.collect::<Vec<_>>(),
        }
    });
    let mut read = signals(&["q", "dq"]);
    read.extend(program.memory.iter().map(|memory| unpacked("x", memory.states.len(), "x")));
    filled(
        include_str!("templates/model.py.j2"),
        context! {
            n, memory,
            steps => program.steps,
            version => program.version(),
            quoted_version => quoted(&program.version()),
            remarks => program.remarks(),
            joints => program.joints.iter().map(|joint| quoted(joint)).collect::<Vec<_>>(),
            has_sign => program.calls(Function::Sign),
            has_positive => program.calls(Function::Positive),
            functions => functions.collect::<Vec<_>>(),
            momentum => lines(&program.momentum, read, "return ", Some(n)),
            momentum_cost => program.cost_of(&program.momentum).to_string(),
        },
    )
}

/// The entries of a sequence by their names; refuses a sequence of another length.
fn unpacked(signal: &str, count: usize, from: &str) -> String {
    format!("{} = {from}", names(signal, count))
}

/// `q1, q2`; `q1,` of one.
fn names(signal: &str, count: usize) -> String {
    let names: Vec<String> = (1..=count).map(|place| format!("{signal}{place}")).collect();
    let comma = if count == 1 { "," } else { "" };
    names.join(", ") + comma
}

/// The statements before the results.
fn steps(body: &Body) -> impl Iterator<Item = String> {
    let angles = body.angles.iter().flat_map(|angle| {
        let j = angle.joint + 1;
        let sin = angle.sin.then(|| format!("s{j} = sin(q{j})"));
        sin.into_iter().chain(angle.cos.then(|| format!("c{j} = cos(q{j})")))
    });
    angles.chain(body.steps.iter().map(|(step, expression)| format!("{step} = {expression}")))
}

/// A string literal: whatever is not plain by its code.
fn quoted(text: &str) -> String {
    let mut quoted = String::from("\"");
    for letter in text.chars() {
        match letter {
            '"' | '\\' => {
                quoted.push('\\');
                quoted.push(letter);
            }
            ' '..='~' => quoted.push(letter),
            // Writing to a String cannot fail.
            _ => drop(write!(quoted, "\\U{:08x}", u32::from(letter))),
        }
    }
    quoted.push('"');
    quoted
}
