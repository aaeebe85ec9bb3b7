//! Program → one file of Rust without `std`: sine and cosine by a trait.

use crate::error::ExportError;
use crate::graph::{Function, Id};
use crate::program::{Precision, Program, Quantity};
use crate::text::{Angle, Body, Language, signal_of};
use std::fmt::Write;

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
        }
    }
}

/// A file of Rust that needs `core` alone, a crate or a module; see `docs/export.md`.
///
/// # Errors
/// [`ExportError::NotSingle`] if a constant is too large for the precision,
/// [`ExportError::Memory`] if friction remembers the path.
pub fn to_rust(program: &Program, precision: Precision) -> Result<String, ExportError> {
    program.check_memoryless("Rust")?;
    program.check_precision(precision)?;
    let real = match precision {
        Precision::Double => "f64",
        Precision::Single => "f32",
    };
    let mut text = introduction(program, real);
    let names: Vec<String> =
        program.joints.iter().map(|joint| format!("    {joint:?},\n")).collect();
    // Writing to a String cannot fail.
    let _ = write!(
        text,
        "/// Which program wrote this, and from which model.\n\
         pub const VERSION: &str = {:?};\n\n\
         /// Number of joints.\npub const JOINTS: usize = {};\n\n\
         /// Steps in which the model was found; 0 if at once.\npub const STEPS: usize = {};\n\n\
         /// Names of the joints, base to tip.\n\
         pub const JOINT_NAMES: [&str; JOINTS] = [\n{}];\n\n\
         /// What `core` lacks.\npub trait Math {{\n    /// (sin x, cos x)\n    \
         fn sin_cos(x: {real}) -> ({real}, {real});\n    /// e to the power of x\n    \
         fn exp(x: {real}) -> {real};\n    /// Hyperbolic tangent of x\n    \
         fn tanh(x: {real}) -> {real};\n}}\n\n",
        program.version(),
        program.n_joints(),
        program.steps,
        names.concat(),
    );
    if program.calls(Function::Sign) {
        let _ = writeln!(
            text,
            "fn sign(x: {real}) -> {real} {{\n    \
             if x > 0.0 {{ 1.0 }} else if x < 0.0 {{ -1.0 }} else {{ 0.0 }}\n}}\n"
        );
    }
    if program.calls(Function::Positive) {
        let _ = writeln!(
            text,
            "fn positive(x: {real}) -> {real} {{\n    if x > 0.0 {{ 1.0 }} else {{ 0.0 }}\n}}\n"
        );
    }
    if program.calls(Function::Abs) {
        let _ = writeln!(
            text,
            "fn abs(x: {real}) -> {real} {{\n    if x < 0.0 {{ -x }} else {{ x }}\n}}\n"
        );
    }
    let functions = program.functions.iter();
    let functions = functions.map(|(q, roots)| function(program, *q, roots, precision, real));
    text += &functions.collect::<Vec<_>>().join("\n");
    Ok(text)
}

fn introduction(program: &Program, real: &str) -> String {
    let mut lines = vec![
        program.version(),
        String::new(),
        "q [rad], dq [rad/s], ddq [rad/s^2], tau [N m], m [kg m^2], one entry per joint.".into(),
        "A crate of its own, or a module; nothing but `core` is used. Sine, cosine and".into(),
        "what friction needs come from where you choose, with `std` from".into(),
        String::new(),
        "    struct Std;".into(),
        "    impl Math for Std {".into(),
        format!("        fn sin_cos(x: {real}) -> ({real}, {real}) {{ x.sin_cos() }}"),
        format!("        fn exp(x: {real}) -> {real} {{ x.exp() }}"),
        format!("        fn tanh(x: {real}) -> {real} {{ x.tanh() }}"),
        "    }".into(),
        "    let tau = torque::<Std>(&q, &dq, &ddq);".into(),
        String::new(),
        "and without it from the crate libm: sincos, exp and tanh, with f at the end for f32."
            .into(),
        String::new(),
    ];
    lines.extend(program.remarks().into_iter().map(String::from));
    let lines = lines.into_iter().map(|line| format!("// {line}").trim_end().to_owned());
    let lines: Vec<String> = lines.collect();
    // As a module it is told that only a crate can do without std, which is as well.
    format!("{}\n#![allow(unused_attributes)]\n#![no_std]\n\n", lines.join("\n"))
}

fn function(
    program: &Program,
    quantity: Quantity,
    roots: &[Id],
    precision: Precision,
    real: &str,
) -> String {
    let body = Body::of(&program.graph, roots, &Rust(precision));
    let arguments: Vec<String> = quantity
        .signals()
        .iter()
        .map(|signal| {
            let unused = if body.reads(signal) { "" } else { "_" };
            format!("{unused}{signal}: &[{real}; JOINTS]")
        })
        .collect();
    let row = format!("[{real}; JOINTS]");
    let result =
        if quantity == Quantity::Inertia { format!("[{row}; JOINTS]") } else { row.clone() };
    let mut lines = vec![
        format!("/// {}: {}", quantity.formula(), program.cost(quantity)),
        format!("pub fn {}<F: Math>({}) -> {result} {{", quantity.name(), arguments.join(", ")),
    ];
    for &input in &body.inputs {
        let (signal, joint) = signal_of(input);
        lines.push(format!("    let {signal}{} = {signal}[{joint}];", joint + 1));
    }
    for &Angle { joint, sin, cos } in &body.angles {
        let j = joint + 1;
        let name = |held: bool, letter: char| {
            if held { format!("{letter}{j}") } else { "_".to_owned() }
        };
        lines.push(format!("    let ({}, {}) = F::sin_cos(q{j});", name(sin, 's'), name(cos, 'c')));
    }
    for (step, expression) in &body.steps {
        lines.push(format!("    let {step} = {expression};"));
    }
    lines.push("    [".into());
    let columns = program.n_joints().max(1);
    if quantity == Quantity::Inertia {
        for row in body.results.chunks(columns) {
            lines.push("        [".into());
            lines.extend(row.iter().map(|entry| format!("            {entry},")));
            lines.push("        ],".into());
        }
    } else {
        lines.extend(body.results.iter().map(|entry| format!("        {entry},")));
    }
    lines.push("    ]\n}\n".into());
    lines.join("\n")
}
