//! Program → one file of Python that needs the standard library alone.

use crate::error::ExportError;
use crate::graph::{Function, Id};
use crate::program::{Program, Quantity};
use crate::text::{Body, Language};
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
        }
    }
}

/// A Python module with the functions `torque`, `gravity` and so on; see `docs/export.md`.
///
/// # Errors
/// [`ExportError::Memory`] if friction remembers the path.
pub fn to_python(program: &Program) -> Result<String, ExportError> {
    program.check_memoryless("Python")?;
    let mut text = format!(
        "\"\"\"{}\n\nq [rad], dq [rad/s], ddq [rad/s^2] are sequences with one number per joint; \
         results are lists,\ntau [N m], and a list of rows for inertia [kg m^2].\n{}\n\"\"\"\n\n\
         from math import cos, exp, sin, tanh\n\n\
         __all__ = [\n    \"VERSION\",\n    \"JOINTS\",\n    \"JOINT_NAMES\",\n    \"STEPS\",\n",
        program.version(),
        program.remarks().join("\n"),
    );
    for quantity in Quantity::ALL {
        // Writing to a String cannot fail.
        let _ = writeln!(text, "    \"{}\",", quantity.name());
    }
    let names: Vec<String> =
        program.joints.iter().map(|joint| format!("    {},\n", quoted(joint))).collect();
    let _ = write!(
        text,
        "]\n\nVERSION = {}\nJOINTS = {}\nJOINT_NAMES = (\n{})\nSTEPS = {}\n\n\n",
        quoted(&program.version()),
        program.n_joints(),
        names.concat(),
        program.steps
    );
    if program.calls(Function::Sign) {
        text += "def _sign(x):\n    return float((x > 0.0) - (x < 0.0))\n\n\n";
    }
    if program.calls(Function::Positive) {
        text += "def _positive(x):\n    return float(x > 0.0)\n\n\n";
    }
    let functions = program.functions.iter();
    let functions = functions.map(|(quantity, roots)| function(program, *quantity, roots));
    text += &functions.collect::<Vec<_>>().join("\n\n");
    Ok(text)
}

fn function(program: &Program, quantity: Quantity, roots: &[Id]) -> String {
    let (n, body) = (program.n_joints(), Body::of(&program.graph, roots, &Python));
    let mut lines = vec![
        format!("def {}({}):", quantity.name(), quantity.signals().join(", ")),
        format!("    \"\"\"{}: {}\"\"\"", quantity.formula(), program.cost(quantity)),
    ];
    // Unpacking refuses a sequence of another length.
    for signal in quantity.signals() {
        let names: Vec<String> = (1..=n).map(|joint| format!("{signal}{joint}")).collect();
        let comma = if n == 1 { "," } else { "" };
        lines.push(format!("    {}{comma} = {signal}", names.join(", ")));
    }
    for angle in &body.angles {
        let j = angle.joint + 1;
        if angle.sin {
            lines.push(format!("    s{j} = sin(q{j})"));
        }
        if angle.cos {
            lines.push(format!("    c{j} = cos(q{j})"));
        }
    }
    for (step, expression) in &body.steps {
        lines.push(format!("    {step} = {expression}"));
    }
    lines.push("    return [".into());
    if quantity == Quantity::Inertia {
        for row in body.results.chunks(n.max(1)) {
            lines.push("        [".into());
            lines.extend(row.iter().map(|entry| format!("            {entry},")));
            lines.push("        ],".into());
        }
    } else {
        lines.extend(body.results.iter().map(|entry| format!("        {entry},")));
    }
    lines.push("    ]\n".into());
    lines.join("\n")
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
