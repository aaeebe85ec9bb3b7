//! From program to one file of Rust without `std`: sine and cosine by a trait.

use crate::error::ExportError;
use crate::graph::{Function, Id};
use crate::program::{Memory, Precision, Program, Quantity};
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
    if let Some(memory) = &program.memory {
        text += &state(program, memory, precision, real);
    }
    text += &observer(program, precision, real);
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
    let row = format!("[{real}; JOINTS]");
    let (result, columns) = if quantity.is_matrix() {
        (format!("[{row}; JOINTS]"), Some(program.n_joints()))
    } else {
        (row, None)
    };
    let (name, signals) =
        (quantity.name(), signals(quantity.signals().iter().copied(), &body, real));
    let mut lines = vec![
        format!("/// {}: {}", quantity.formula(), program.cost(quantity)),
        format!("pub fn {name}<F: Math>({signals}) -> {result} {{"),
    ];
    let inner = statements(&body, quantity.signals(), columns);
    lines.extend(inner.iter().map(|line| format!("    {line}")));
    lines.push("}\n".into());
    lines.join("\n")
}

/// Arguments of a function; those that it does not read begin with `_`.
fn signals(names: impl Iterator<Item = &'static str>, body: &Body, real: &str) -> String {
    let argument = |signal| {
        let unused = if body.reads(signal) { "" } else { "_" };
        format!("{unused}{signal}: &[{real}; JOINTS]")
    };
    names.map(argument).collect::<Vec<_>>().join(", ")
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

/// What friction remembers, as a struct.
fn state(program: &Program, memory: &Memory, precision: Precision, real: &str) -> String {
    let (count, language) = (memory.states.len(), Rust(precision));
    let mut text = format!(
        "\n/// What friction remembers: give `step` every sample of q.\n///\n\
         /// What ends in `_after` is at the last sample; `torque` and `friction` have no memory \
         and are as after\n/// a long way in the direction of dq.\n\
         #[derive(Clone, Copy, Debug, PartialEq)]\npub struct State {{\n    \
         q: [{real}; JOINTS],\n    x: [{real}; {count}],\n    started: bool,\n}}\n\n\
         impl Default for State {{\n    fn default() -> Self {{\n        \
         State {{ q: [0.0; JOINTS], x: [0.0; {count}], started: false }}\n    }}\n}}\n\n\
         impl State {{\n    /// Forgets the way so far.\n    pub fn reset(&mut self) {{\n        \
         *self = Self::default();\n    }}\n"
    );
    let body = Body::of(&program.graph, &memory.states, &language);
    let next = statements(&body, &["q"], None).into_iter().map(|line| format!("    {line}"));
    let mut lines = vec![
        "if !self.started {".into(),
        "    self.q = *q;".into(),
        "}".into(),
        "self.x = {".into(),
    ];
    lines.extend(next);
    lines.extend(["};", "self.q = *q;", "self.started = true;"].map(String::from));
    let doc = format!("Takes the next sample of q: {}", program.cost_of(&memory.states));
    let head = format!("step<F: Math>(&mut self, q: &[{real}; JOINTS])");
    text += &method(&doc, &head, &lines);
    for (quantity, roots) in &memory.after {
        let body = Body::of(&program.graph, roots, &language);
        let arguments: Vec<&str> = Memory::signals(*quantity).collect();
        let signals = signals(Memory::signals(*quantity), &body, real);
        let doc = format!("{}: {}", quantity.formula(), program.cost_of(roots));
        let head =
            format!("{}_after<F: Math>(&self, {signals}) -> [{real}; JOINTS]", quantity.name());
        text += &method(&doc, &head, &statements(&body, &arguments, None));
    }
    text + "}\n"
}

/// The momentum observer, as a struct.
fn observer(program: &Program, precision: Precision, real: &str) -> String {
    let body = Body::of(&program.graph, &program.momentum, &Rust(precision));
    let inner = statements(&body, &["q", "dq"], Some(program.n_joints()));
    let (signals, cost) =
        (signals(["q", "dq"].into_iter(), &body, real), program.cost_of(&program.momentum));
    let result = format!("[[{real}; JOINTS]; 2]");
    let (momentum, [field, start, step, now]) = if program.memory.is_some() {
        let doc = "Momentum, and the part of its change that is neither motor nor external.";
        let head = format!("momentum<F: Math>(&self, {signals}) -> {result}");
        let method = method(doc, &head, &inner).replace("    pub fn", "    fn");
        let own = [
            "    friction: State,\n",
            "friction: State::default(), ",
            "self.friction.step::<F>(q);\n        ",
            "self.friction.momentum::<F>(q, dq)",
        ];
        (format!("\nimpl State {{{}}}\n", method.trim_start_matches('\n').to_owned()), own)
    } else {
        let lines = inner.join("\n    ");
        let function = format!(
            "\n/// Momentum, and the part of its change that is neither motor nor external.\n\
             fn momentum<F: Math>({signals}) -> {result} {{\n    {lines}\n}}\n"
        );
        (function, ["", "", "", "momentum::<F>(q, dq)"])
    };
    let row = format!("[{real}; JOINTS]");
    format!(
        "{momentum}\n/// External torque by the momentum observer: give `step` every sample.\n\
         #[derive(Clone, Copy, Debug, PartialEq)]\npub struct Observer {{\n{field}    \
         last: {result},\n    external: {row},\n    started: bool,\n}}\n\n\
         impl Default for Observer {{\n    fn default() -> Self {{\n        \
         Observer {{ {start}last: [[0.0; JOINTS]; 2], external: [0.0; JOINTS], started: false }}\n\
         \x20   }}\n}}\n\n\
         impl Observer {{\n    /// Forgets the samples so far.\n    pub fn reset(&mut self) {{\n\
         \x20       *self = Self::default();\n    }}\n\n    \
         /// What others put on the joints [N m], low-passed: {cost}\n    ///\n    \
         /// `gain` [1/s] is 2 pi times the bandwidth [Hz], `dt` [s] the time since the last \
         sample, `tau` the\n    /// torque of the motors.\n    \
         pub fn step<F: Math>(\n        &mut self,\n        gain: {real},\n        dt: {real},\n\
         \x20       q: &{row},\n        dq: &{row},\n        tau: &{row},\n    ) -> {row} {{\n\
         \x20       {step}let mut now = {now};\n        \
         for j in 0..JOINTS {{\n            now[1][j] += tau[j];\n        }}\n        \
         if self.started && dt > 0.0 {{\n            let stays = F::exp(-gain * dt);\n            \
         for j in 0..JOINTS {{\n                \
         let rate = (now[0][j] - self.last[0][j]) / dt;\n                \
         let own = 0.5 * (now[1][j] + self.last[1][j]);\n                \
         self.external[j] = stays * self.external[j] + (1.0 - stays) * (rate - own);\n            \
         }}\n        }}\n        self.last = now;\n        self.started = true;\n        \
         self.external\n    }}\n}}\n"
    )
}

fn method(doc: &str, head: &str, lines: &[String]) -> String {
    let lines = lines.join("\n        ");
    format!("\n    /// {doc}\n    pub fn {head} {{\n        {lines}\n    }}\n")
}
