//! From program to one file of C99: no allocation, no library but `math.h`.

use crate::error::ExportError;
use crate::graph::{Function, Id};
use crate::program::{Memory, Precision, Program, Quantity};
use crate::template::filled;
use crate::text::{Body, Language, signal_of};
use minijinja::context;
use std::fmt::Write;

struct C(Precision);

impl Language for C {
    fn constant(&self, value: f64) -> String {
        match self.0 {
            Precision::Double => format!("{value:?}"),
            #[expect(clippy::cast_possible_truncation, reason = "single precision is asked for")]
            Precision::Single => format!("{:?}f", value as f32),
        }
    }

    fn call(&self, function: Function, argument: &str) -> String {
        let suffix = if self.0 == Precision::Single { "f" } else { "" };
        match function {
            Function::Tanh => format!("tanh{suffix}({argument})"),
            Function::Exp => format!("exp{suffix}({argument})"),
            Function::Sign => format!("sign({argument})"),
            Function::Positive => format!("positive({argument})"),
            Function::Abs => format!("fabs{suffix}({argument})"),
            Function::Reciprocal => format!("{}/({argument})", self.constant(1.0)),
        }
    }
}

/// A file of C99 with the functions `NAME_torque`, `NAME_gravity` and so on; see `docs/export.md`.
///
/// - `name`: what every function begins with, a C identifier
///
/// # Errors
/// [`ExportError::Name`] if the name is none, [`ExportError::NotSingle`] if a constant is too large
/// for the precision.
pub fn to_c(program: &Program, name: &str, precision: Precision) -> Result<String, ExportError> {
    check_name(name)?;
    program.check_precision(precision)?;
    let (n, real) =
        (program.n_joints(), if precision == Precision::Single { "float" } else { "double" });
    let lines = |roots: &[Id], arguments: &[&str], result| {
        statements(&Body::of(&program.graph, roots, &C(precision)), precision, arguments, result)
    };
    let signals = |names: &[&str]| -> String {
        let own: Vec<String> =
            names.iter().map(|signal| format!("const {real} {signal}[{n}], ")).collect();
        own.concat()
    };
    let function = |(quantity, roots): &(Quantity, Vec<Id>)| {
        let (own, result) = (quantity.name(), quantity.result());
        let (signals, count) = (signals(quantity.signals()), roots.len());
        context! {
            costs => format!("{own:18}{:24}{}", quantity.formula(), program.cost_of(roots)),
            head => format!("void {name}_{own}({signals}{real} {result}[{count}])"),
            lines => lines(roots, quantity.signals(), result),
        }
    };
    let after = |(quantity, roots): &(Quantity, Vec<Id>)| {
        let (own, result) = (quantity.name(), quantity.result());
        let arguments: Vec<&str> = Memory::signals(*quantity).collect();
        let signals = signals(&arguments);
        context! {
            head => format!(
                "void {name}_{own}_after(const {name}_state *state, {signals}{real} {result}[{n}])"
            ),
            lines => lines(roots, &[&["state"], &arguments[..]].concat(), result),
        }
    };
    let memory = program.memory.as_ref().map(|memory| {
        context! {
            elements => memory.states.len(),
            step_cost => program.cost_of(&memory.states).to_string(),
            torque_cost => program.cost_of(&memory.after[0].1).to_string(),
            step => lines(&memory.states, &["q"], "state->x"),
            after => memory.after.iter().map(after).collect::<Vec<_>>(),
        }
    });
    let state: &[&str] = if memory.is_some() { &["state"] } else { &[] };
    filled(
        include_str!("templates/model.c.j2"),
        context! {
            name, real, n, memory,
            upper => name.to_uppercase(),
            f => if precision == Precision::Single { "f" } else { "" },
            steps => program.steps,
            version => program.version(),
            quoted_version => quoted(&program.version()),
            remarks => program.remarks(),
            joints => program.joints.iter().map(|joint| quoted(joint)).collect::<Vec<_>>(),
            has_sign => program.calls(Function::Sign),
            has_positive => program.calls(Function::Positive),
            functions => program.functions.iter().map(function).collect::<Vec<_>>(),
            momentum => lines(&program.momentum, &[state, &["q", "dq"]].concat(), "now"),
            momentum_cost => program.cost_of(&program.momentum).to_string(),
        },
    )
}

/// The first lines of a file that calls the functions of a C file as MODEL(name); they define
/// REMEMBERS where friction does.
pub(crate) fn inclusion(program: &Program, name: &str) -> String {
    let remembers = if program.memory.is_some() { "#define REMEMBERS\n" } else { "" };
    format!(
        "#define {}_DECLARATIONS_ONLY\n#include \"{name}.c\"\n\n\
         #define MODEL(function) {name}_##function\n{remembers}",
        name.to_uppercase()
    )
}

/// Whether it can begin the name of a function in C.
pub(crate) fn check_name(name: &str) -> Result<(), ExportError> {
    let mut letters = name.chars();
    let first = letters.next().is_some_and(|letter| letter.is_ascii_alphabetic());
    if first && letters.all(|letter| letter.is_ascii_alphanumeric() || letter == '_') {
        Ok(())
    } else {
        Err(ExportError::Name { name: name.into() })
    }
}

/// The statements of a function; what is no argument is read from its state.
///
/// - `result`: where results are written, one after the other
fn statements(body: &Body, precision: Precision, arguments: &[&str], result: &str) -> Vec<String> {
    let mut lines = Vec::new();
    let real = if precision == Precision::Single { "float" } else { "double" };
    let suffix = if precision == Precision::Single { "f" } else { "" };
    for &input in &body.inputs {
        let (signal, joint) = signal_of(input);
        let from = match signal {
            _ if arguments.contains(&signal) => signal,
            "x" => "state->x",
            _ => "state->q",
        };
        lines.push(format!("const {real} {signal}{} = {from}[{joint}];", joint + 1));
    }
    for angle in &body.angles {
        let j = angle.joint + 1;
        for (letter, function, _) in
            [('s', "sin", angle.sin), ('c', "cos", angle.cos)].iter().filter(|(_, _, held)| *held)
        {
            lines.push(format!("const {real} {letter}{j} = {function}{suffix}(q{j});"));
        }
    }
    for (step, expression) in &body.steps {
        lines.push(format!("const {real} {step} = {expression};"));
    }
    for (place, expression) in body.results.iter().enumerate() {
        lines.push(format!("{result}[{place}] = {expression};"));
    }
    let state_is_read = body.inputs.iter().any(|&input| !arguments.contains(&signal_of(input).0));
    let is_read = |argument: &str| body.reads(argument) || argument == "state" && state_is_read;
    for argument in arguments.iter().filter(|argument| !is_read(argument)) {
        lines.push(format!("(void){argument};"));
    }
    lines
}

/// A string literal: bytes beyond ASCII by their octal codes, and no trigraphs.
pub(crate) fn quoted(text: &str) -> String {
    let mut quoted = String::from("\"");
    for byte in text.bytes() {
        match byte {
            b'"' | b'\\' | b'?' => {
                quoted.push('\\');
                quoted.push(char::from(byte));
            }
            b' '..=b'~' => quoted.push(char::from(byte)),
            // Writing to a String cannot fail.
            _ => drop(write!(quoted, "\\{byte:03o}")),
        }
    }
    quoted.push('"');
    quoted
}
