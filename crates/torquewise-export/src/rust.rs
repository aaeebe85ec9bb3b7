//! From program to one file of Rust without `std`: sine and cosine by a trait.

use crate::error::ExportError;
use crate::graph::{Function, Id};
use crate::program::{Memory, Precision, Program, Quantity};
use crate::template::filled;
use crate::text::{Angle, Body, Language, signal_of};
use minijinja::context;

struct Rust(Precision);

impl Language for Rust {
    fn constant(&self, value: f64) -> String {
        match self.0 {
            Precision::Double => format!("{value:?}"),
            #[expect(clippy::cast_possible_truncation, reason = "single precision is asked for")]
            Precision::Single => format!("{:?}", value as f32),
        }
    }

    fn call(&self, function: Function, argument: &str) -> String {
        match function {
            Function::Tanh => format!("F::tanh({argument})"),
            Function::Exp => format!("F::exp({argument})"),
            Function::Sign => format!("sign({argument})"),
            Function::Positive => format!("positive({argument})"),
            Function::Abs => format!("abs({argument})"),
            Function::Reciprocal => format!("1.0/({argument})"),
        }
    }
}

/// A file of Rust that needs `core` alone, a crate or a module; see `docs/export.md`.
///
/// # Errors
/// [`ExportError::NotSingle`] if a constant is too large for the precision.
pub fn to_rust(program: &Program, precision: Precision) -> Result<String, ExportError> {
    program.check_precision(precision)?;
    let real = if precision == Precision::Single { "f32" } else { "f64" };
    let n = program.n_joints();
    // What is no argument is read from the state.
    let function = |quantity: Quantity, roots: &[Id], arguments: &[&str]| {
        let body = Body::of(&program.graph, roots, &Rust(precision));
        let row = format!("[{real}; JOINTS]");
        context! {
            doc => format!("{}: {}", quantity.formula(), program.cost_of(roots)),
            name => quantity.name(),
            signals => signals(arguments, &body, real),
            result => if quantity.is_matrix() { format!("[{row}; JOINTS]") } else { row },
            lines => statements(&body, arguments, quantity.is_matrix().then_some(n)),
        }
    };
    let functions = program.functions.iter();
    let functions =
        functions.map(|(quantity, roots)| function(*quantity, roots, quantity.signals()));
    let memory = program.memory.as_ref().map(|memory| {
        let body = Body::of(&program.graph, &memory.states, &Rust(precision));
        let after = memory.after.iter().map(|(quantity, roots)| {
            function(*quantity, roots, &Memory::signals(*quantity).collect::<Vec<_>>())
        });
        context! {
            elements => memory.states.len(),
            step_cost => program.cost_of(&memory.states).to_string(),
            step => statements(&body, &["q"], None),
            after => after.collect::<Vec<_>>(),
        }
    });
    let momentum = Body::of(&program.graph, &program.momentum, &Rust(precision));
    filled(
        include_str!("templates/model.rs.j2"),
        context! {
            real, n, memory,
            steps => program.steps,
            version => program.version(),
            quoted_version => format!("{:?}", program.version()),
            remarks => program.remarks(),
            joints => program.joints.iter().map(|joint| format!("{joint:?}")).collect::<Vec<_>>(),
            has_sign => program.calls(Function::Sign),
            has_positive => program.calls(Function::Positive),
            has_abs => program.calls(Function::Abs),
            functions => functions.collect::<Vec<_>>(),
            momentum => context! {
                signals => signals(&["q", "dq"], &momentum, real),
                lines => statements(&momentum, &["q", "dq"], Some(n)),
                cost => program.cost_of(&program.momentum).to_string(),
            },
        },
    )
}

/// Arguments of a function; those that it does not read begin with `_`.
fn signals(names: &[&str], body: &Body, real: &str) -> String {
    let argument = |signal: &&str| {
        let unused = if body.reads(signal) { "" } else { "_" };
        format!("{unused}{signal}: &[{real}; JOINTS]")
    };
    names.iter().map(argument).collect::<Vec<_>>().join(", ")
}

/// The statements of a function, its results last; what is no argument is read from its state.
///
/// - `columns`: in which results are set, if they are a matrix
fn statements(body: &Body, arguments: &[&str], columns: Option<usize>) -> Vec<String> {
    let mut lines = Vec::new();
    for &input in &body.inputs {
        let (signal, joint) = signal_of(input);
        let from = match signal {
            _ if arguments.contains(&signal) => signal,
            "x" => "self.x",
            _ => "self.q",
        };
        lines.push(format!("let {signal}{} = {from}[{joint}];", joint + 1));
    }
    for &Angle { joint, sin, cos } in &body.angles {
        let j = joint + 1;
        let name = |held: bool, letter: char| {
            if held { format!("{letter}{j}") } else { "_".to_owned() }
        };
        lines.push(format!("let ({}, {}) = F::sin_cos(q{j});", name(sin, 's'), name(cos, 'c')));
    }
    lines.extend(body.steps.iter().map(|(step, expression)| format!("let {step} = {expression};")));
    lines.extend(body.listed("", columns));
    lines
}
