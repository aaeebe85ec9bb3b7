//! Program → one file of C99: no allocation, no library but `math.h`.

use crate::error::ExportError;
use crate::graph::{Function, Id};
use crate::program::{Precision, Program, Quantity};
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
    put_memory(&mut put, &memory_declarations(program, name, real));
    put("\n#ifdef __cplusplus\n}\n#endif\n\n#endif\n");
    put(&format!("#ifndef {upper}_DECLARATIONS_ONLY\n\n#include <math.h>\n"));
    put(&identity(program, name));
    put(&signs(program, real));
    for (quantity, roots) in &program.functions {
        put(&function(program, name, (*quantity, roots), precision));
    }
    put_memory(&mut put, &memory(program, name, precision));
    put("#endif");
    Ok(text)
}

/// The state of Dahl elements and its functions; nothing where there are none.
fn memory_declarations(program: &Program, name: &str, real: &str) -> String {
    let (n, count) = (program.n_joints(), program.elements.len());
    if count == 0 {
        return String::new();
    }
    format!(
        "\n/* What friction remembers: call {name}_reset once and {name}_step at every sample of \
         q.\n   {name}_torque_after is the torque at the last sample; {name}_torque has no \
         memory and\n   takes friction as after a long way in the direction of dq. */\n\
         typedef struct {{\n    {real} q[{n}];\n    {real} x[{count}];\n    int started;\n}} \
         {name}_state;\n\
         void {name}_reset({name}_state *state);\n\
         void {name}_step({name}_state *state, const {real} q[{n}]);\n{};",
        after_signature(program, name, real)
    )
}

fn after_signature(program: &Program, name: &str, real: &str) -> String {
    let n = program.n_joints();
    format!(
        "void {name}_torque_after(const {name}_state *state, const {real} dq[{n}], \
         const {real} ddq[{n}], {real} tau[{n}])"
    )
}

/// x ← s + (x − s)·e^(−|Δq|/δ), s = sign Δq, and the torque at these states.
fn memory(program: &Program, name: &str, precision: Precision) -> String {
    if program.elements.is_empty() {
        return String::new();
    }
    let (real, language) = (real(precision), C(precision));
    let (n, count) = (program.n_joints(), program.elements.len());
    let [zero, one] = [0.0, 1.0].map(|value| language.constant(value));
    let joints: Vec<String> = program.elements.iter().map(|(j, _)| j.to_string()).collect();
    let travels: Vec<String> =
        program.elements.iter().map(|(_, travel)| language.constant(*travel)).collect();
    let exp = language.call(Function::Exp, "-(way*end)/travels[k]");
    let mut text = format!(
        "void {name}_reset({name}_state *state)\n{{\n    \
         for (int j = 0; j < {n}; j++) state->q[j] = {zero};\n    \
         for (int k = 0; k < {count}; k++) state->x[k] = {zero};\n    state->started = 0;\n}}\n\n\
         void {name}_step({name}_state *state, const {real} q[{n}])\n{{\n    \
         static const int joints[{count}] = {{{}}};\n    \
         static const {real} travels[{count}] = {{{}}};\n    \
         for (int k = 0; state->started && k < {count}; k++) {{\n        \
         const {real} way = q[joints[k]] - state->q[joints[k]];\n        \
         const {real} end = way < {zero} ? -{one} : {one};\n        \
         if (way != {zero}) state->x[k] = end + (state->x[k] - end)*{exp};\n    }}\n    \
         for (int j = 0; j < {n}; j++) state->q[j] = q[j];\n    state->started = 1;\n}}\n\n",
        joints.join(", "),
        travels.join(", ")
    );
    let body = Body::of(&program.graph, &program.after, &language);
    let mut lines = vec![after_signature(program, name, real), "{".into()];
    lines.extend(readings(&body, precision, "state->"));
    for (place, expression) in body.results.iter().enumerate() {
        lines.push(format!("    tau[{place}] = {expression};"));
    }
    for signal in ["dq", "ddq"].iter().filter(|signal| !body.reads(signal)) {
        lines.push(format!("    (void){signal};"));
    }
    lines.push("}\n".into());
    text += &lines.join("\n");
    text
}

fn put_memory(put: &mut impl FnMut(&str), text: &str) {
    if !text.is_empty() {
        put(text);
    }
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
            "\n   {:10}{:22}{}",
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
    let result = match quantity {
        Quantity::Inertia => format!("{real} m[{}]", n * n),
        _ => format!("{real} tau[{n}]"),
    };
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
    let (real, body) = (real(precision), Body::of(&program.graph, roots, &C(precision)));
    let mut lines = vec![signature(program, name, quantity, real), "{".into()];
    lines.extend(readings(&body, precision, ""));
    let result = if quantity == Quantity::Inertia { "m" } else { "tau" };
    for (place, expression) in body.results.iter().enumerate() {
        lines.push(format!("    {result}[{place}] = {expression};"));
    }
    for signal in quantity.signals().iter().filter(|signal| !body.reads(signal)) {
        lines.push(format!("    (void){signal};"));
    }
    lines.push("}\n".into());
    lines.join("\n")
}

/// The lines before the results; positions and elements are read from a state, if there is one.
fn readings(body: &Body, precision: Precision, state: &str) -> Vec<String> {
    let (real, mut lines) = (real(precision), Vec::new());
    let suffix = if precision == Precision::Single { "f" } else { "" };
    for &input in &body.inputs {
        let (signal, joint) = signal_of(input);
        let from = if matches!(signal, "q" | "x") { state } else { "" };
        lines.push(format!("    const {real} {signal}{} = {from}{signal}[{joint}];", joint + 1));
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
