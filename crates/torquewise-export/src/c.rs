//! From program to one file of C99: no allocation, no library but `math.h`.

use crate::error::ExportError;
use crate::graph::{Function, Id};
use crate::program::{Memory, Precision, Program, Quantity};
use crate::text::{Body, Language, signal_of};
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
    let (upper, real) = (name.to_uppercase(), real(precision));
    let mut text = format!("/* {}\n{} */\n", program.version(), introduction(program, name));
    let mut put = |line: &str| {
        text.push_str(line);
        text.push('\n');
    };
    put(&format!("#ifndef {upper}_H\n#define {upper}_H\n"));
    put("#ifdef __cplusplus\nextern \"C\" {\n#endif\n");
    put(&format!("#define {upper}_JOINTS {}", program.n_joints()));
    put(&format!("#define {upper}_STEPS {}\n", program.steps));
    put(&format!("const char *{name}_version(void);"));
    put(&format!("int {name}_joints(void);"));
    put("/* Null for a joint that is not one of 0 to joints - 1. */");
    put(&format!("const char *{name}_joint_name(int joint);"));
    for quantity in Quantity::ALL {
        put(&format!("{};", signature(program, name, quantity, real)));
    }
    if let Some(memory) = &program.memory {
        put(&memory_declarations(program, memory, name, real));
    }
    put(&observer_declarations(program, name, real));
    put("\n#ifdef __cplusplus\n}\n#endif\n\n#endif\n");
    put(&format!("#ifndef {upper}_DECLARATIONS_ONLY\n\n#include <math.h>\n"));
    put(&identity(program, name));
    put(&signs(program, real));
    for (quantity, roots) in &program.functions {
        put(&function(program, name, (*quantity, roots), precision));
    }
    if let Some(memory) = &program.memory {
        put(&memory_functions(program, memory, name, precision));
    }
    put(&observer_functions(program, name, precision));
    put("#endif");
    Ok(text)
}

/// The state of Dahl elements and the declarations of its functions.
fn memory_declarations(program: &Program, memory: &Memory, name: &str, real: &str) -> String {
    let (n, count) = (program.n_joints(), memory.states.len());
    let mut text = format!(
        "\n/* What friction remembers: call {name}_reset once and {name}_step at every sample of \
         q.\n   Functions that end in _after are at the last sample; {name}_torque and \
         {name}_friction have no\n   memory and are as after a long way in the direction of \
         dq.\n\n   step                            {}\n   torque_after                    {} */\n\
         #define {}_ELEMENTS {count}\n\
         typedef struct {{\n    {real} q[{n}];\n    {real} x[{count}];\n    int started;\n}} \
         {name}_state;\n\
         void {name}_reset({name}_state *state);\n{};",
        program.cost_of(&memory.states),
        program.cost_of(&memory.after[0].1),
        name.to_uppercase(),
        step_signature(program, name, real)
    );
    for (quantity, _) in &memory.after {
        // Writing to a String cannot fail.
        let _ = write!(text, "\n{};", after_signature(program, name, *quantity, real));
    }
    text
}

fn step_signature(program: &Program, name: &str, real: &str) -> String {
    format!("void {name}_step({name}_state *state, const {real} q[{}])", program.n_joints())
}

fn after_signature(program: &Program, name: &str, quantity: Quantity, real: &str) -> String {
    let n = program.n_joints();
    let signals = Memory::signals(quantity).map(|signal| format!("const {real} {signal}[{n}], "));
    let (result, signals) = (quantity.result(), signals.collect::<String>());
    let quantity = quantity.name();
    format!(
        "void {name}_{quantity}_after(const {name}_state *state, {signals}{real} {result}[{n}])"
    )
}

fn memory_functions(
    program: &Program,
    memory: &Memory,
    name: &str,
    precision: Precision,
) -> String {
    let (real, language) = (real(precision), C(precision));
    let (n, count, zero) = (program.n_joints(), memory.states.len(), language.constant(0.0));
    let mut lines = vec![
        format!("void {name}_reset({name}_state *state)\n{{"),
        format!("    for (int j = 0; j < {n}; j++) state->q[j] = {zero};"),
        format!("    for (int k = 0; k < {count}; k++) state->x[k] = {zero};"),
        "    state->started = 0;\n}\n".into(),
        format!("{}\n{{", step_signature(program, name, real)),
        format!("    for (int j = 0; j < {n} && !state->started; j++) state->q[j] = q[j];"),
    ];
    let body = Body::of(&program.graph, &memory.states, &language);
    lines.extend(statements(&body, precision, &["q"], "state->x"));
    lines.push(format!("    for (int j = 0; j < {n}; j++) state->q[j] = q[j];"));
    lines.push("    state->started = 1;\n}\n".into());
    for (quantity, roots) in &memory.after {
        let body = Body::of(&program.graph, roots, &language);
        let arguments: Vec<&str> =
            ["state"].into_iter().chain(Memory::signals(*quantity)).collect();
        lines.push(format!("{}\n{{", after_signature(program, name, *quantity, real)));
        lines.extend(statements(&body, precision, &arguments, quantity.result()));
        lines.push("}\n".into());
    }
    lines.join("\n")
}

/// The momentum observer and the declarations of its functions.
fn observer_declarations(program: &Program, name: &str, real: &str) -> String {
    let n = program.n_joints();
    let friction = match program.memory {
        Some(_) => format!("    {name}_state friction;\n"),
        None => String::new(),
    };
    format!(
        "\n/* External torque by the momentum observer: call {name}_observer_reset once and\n   \
         {name}_observer_step at every sample, dt [s] after the last, with the torque of the \
         motors.\n   external [N m] follows what others put on the joints as a low-pass; gain \
         [1/s] is 2 pi times\n   its bandwidth [Hz].\n\n   \
         observer_step                   {} */\n\
         typedef struct {{\n{friction}    {real} last[{}];\n    {real} external[{n}];\n    \
         int started;\n}} {name}_observer;\n\
         void {name}_observer_reset({name}_observer *observer);\n{};",
        program.cost_of(&program.momentum),
        2 * n,
        observer_signature(program, name, real)
    )
}

fn observer_signature(program: &Program, name: &str, real: &str) -> String {
    let n = program.n_joints();
    format!(
        "void {name}_observer_step(\n    {name}_observer *observer, {real} gain, {real} dt, \
         const {real} q[{n}], const {real} dq[{n}],\n    const {real} tau[{n}], {real} \
         external[{n}])"
    )
}

fn observer_functions(program: &Program, name: &str, precision: Precision) -> String {
    let (real, language, n) = (real(precision), C(precision), program.n_joints());
    let [zero, half, one] = [0.0, 0.5, 1.0].map(|number| language.constant(number));
    let exp = language.call(Function::Exp, "-gain*dt");
    let body = Body::of(&program.graph, &program.momentum, &language);
    let (parameter, argument, mut arguments) = match program.memory {
        Some(_) => (format!("const {name}_state *state, "), "&observer->friction, ", vec!["state"]),
        None => (String::new(), "", vec![]),
    };
    arguments.extend(["q", "dq"]);
    let mut lines = vec![format!(
        "static void {name}_momentum(\n    {parameter}const {real} q[{n}], const {real} dq[{n}], \
         {real} now[{}])\n{{",
        2 * n
    )];
    lines.extend(statements(&body, precision, &arguments, "now"));
    lines.push(format!("}}\n\nvoid {name}_observer_reset({name}_observer *observer)\n{{"));
    if program.memory.is_some() {
        lines.push(format!("    {name}_reset(&observer->friction);"));
    }
    lines.push(format!(
        "    for (int k = 0; k < {}; k++) observer->last[k] = {zero};\n    \
         for (int j = 0; j < {n}; j++) observer->external[j] = {zero};\n    \
         observer->started = 0;\n}}\n\n{}\n{{\n    {real} now[{}];",
        2 * n,
        observer_signature(program, name, real),
        2 * n
    ));
    if program.memory.is_some() {
        lines.push(format!("    {name}_step(&observer->friction, q);"));
    }
    lines.push(format!(
        "    {name}_momentum({argument}q, dq, now);\n    \
         for (int j = 0; j < {n}; j++) now[{n} + j] += tau[j];\n    \
         if (observer->started && dt > {zero}) {{\n        \
         const {real} stays = {exp};\n        \
         for (int j = 0; j < {n}; j++) {{\n            \
         const {real} rate = (now[j] - observer->last[j])/dt;\n            \
         const {real} own = {half}*(now[{n} + j] + observer->last[{n} + j]);\n            \
         observer->external[j] = stays*observer->external[j] + ({one} - stays)*(rate - own);\n        \
         }}\n    }}\n    \
         for (int k = 0; k < {}; k++) observer->last[k] = now[k];\n    \
         for (int j = 0; j < {n}; j++) external[j] = observer->external[j];\n    \
         observer->started = 1;\n}}\n",
        2 * n
    ));
    lines.join("\n")
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

fn real(precision: Precision) -> &'static str {
    match precision {
        Precision::Double => "double",
        Precision::Single => "float",
    }
}

fn introduction(program: &Program, name: &str) -> String {
    let upper = name.to_uppercase();
    let mut text = format!(
        "\n   q [rad], dq [rad/s], ddq [rad/s^2], tau [N m], m [kg m^2], one entry per joint.\n   \
         Results may be written over arguments. Compile this file, and where its functions are\n   \
         called write #define {upper}_DECLARATIONS_ONLY before #include.\n"
    );
    for quantity in Quantity::ALL {
        // Writing to a String cannot fail.
        let _ = write!(
            text,
            "\n   {:18}{:24}{}",
            quantity.name(),
            quantity.formula(),
            program.cost(quantity)
        );
    }
    text + "\n\n   " + &program.remarks().join("\n   ")
}

/// `void arm_torque(const double q[3], const double dq[3], const double ddq[3], double tau[3])`
fn signature(program: &Program, name: &str, quantity: Quantity, real: &str) -> String {
    let n = program.n_joints();
    let signals = quantity.signals().iter().map(|signal| format!("const {real} {signal}[{n}]"));
    let count = if quantity.is_matrix() { n * n } else { n };
    let result = format!("{real} {}[{count}]", quantity.result());
    let arguments: Vec<String> = signals.chain([result]).collect();
    format!("void {name}_{}({})", quantity.name(), arguments.join(", "))
}

fn identity(program: &Program, name: &str) -> String {
    let upper = name.to_uppercase();
    let names: Vec<String> = program.joints.iter().map(|joint| quoted(joint)).collect();
    format!(
        "const char *{name}_version(void)\n{{\n    return {};\n}}\n\n\
         int {name}_joints(void)\n{{\n    return {upper}_JOINTS;\n}}\n\n\
         const char *{name}_joint_name(int joint)\n{{\n    \
         static const char *const names[] = {{\n        {}\n    }};\n    \
         return joint >= 0 && joint < {upper}_JOINTS ? names[joint] : 0;\n}}\n",
        quoted(&program.version()),
        names.join(",\n        ")
    )
}

fn signs(program: &Program, real: &str) -> String {
    let zero = if real == "float" { "0.0f" } else { "0.0" };
    let one = if real == "float" { "1.0f" } else { "1.0" };
    let mut text = String::new();
    if program.calls(Function::Sign) {
        // Writing to a String cannot fail.
        let _ = writeln!(
            text,
            "static {real} sign({real} x)\n{{\n    \
             return ({real})((x > {zero}) - (x < {zero}));\n}}"
        );
    }
    if program.calls(Function::Positive) {
        let _ = writeln!(
            text,
            "static {real} positive({real} x)\n{{\n    return x > {zero} ? {one} : {zero};\n}}"
        );
    }
    text
}

fn function(
    program: &Program,
    name: &str,
    (quantity, roots): (Quantity, &[Id]),
    precision: Precision,
) -> String {
    let body = Body::of(&program.graph, roots, &C(precision));
    let mut lines = vec![signature(program, name, quantity, real(precision)), "{".into()];
    lines.extend(statements(&body, precision, quantity.signals(), quantity.result()));
    lines.push("}\n".into());
    lines.join("\n")
}

/// The statements of a function; what is no argument is read from its state.
///
/// - `result`: where results are written, one after the other
fn statements(body: &Body, precision: Precision, arguments: &[&str], result: &str) -> Vec<String> {
    let (real, mut lines) = (real(precision), Vec::new());
    let suffix = if precision == Precision::Single { "f" } else { "" };
    for &input in &body.inputs {
        let (signal, joint) = signal_of(input);
        let from = match signal {
            _ if arguments.contains(&signal) => signal,
            "x" => "state->x",
            _ => "state->q",
        };
        lines.push(format!("    const {real} {signal}{} = {from}[{joint}];", joint + 1));
    }
    for angle in &body.angles {
        let j = angle.joint + 1;
        for (letter, function, _) in
            [('s', "sin", angle.sin), ('c', "cos", angle.cos)].iter().filter(|(_, _, held)| *held)
        {
            lines.push(format!("    const {real} {letter}{j} = {function}{suffix}(q{j});"));
        }
    }
    for (step, expression) in &body.steps {
        lines.push(format!("    const {real} {step} = {expression};"));
    }
    for (place, expression) in body.results.iter().enumerate() {
        lines.push(format!("    {result}[{place}] = {expression};"));
    }
    let state_is_read = body.inputs.iter().any(|&input| !arguments.contains(&signal_of(input).0));
    let is_read = |argument: &str| body.reads(argument) || argument == "state" && state_is_read;
    for argument in arguments.iter().filter(|argument| !is_read(argument)) {
        lines.push(format!("    (void){argument};"));
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
