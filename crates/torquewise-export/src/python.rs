//! From program to one file of Python that needs the standard library alone.

use crate::graph::{Function, Id};
use crate::program::{Memory, Program, Quantity};
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
            Function::Reciprocal => format!("1.0/({argument})"),
        }
    }
}

/// A Python module with the functions `torque`, `gravity` and so on; see `docs/export.md`.
pub fn to_python(program: &Program) -> String {
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
    if program.memory.is_some() {
        text += "    \"State\",\n";
    }
    text += "    \"Observer\",\n";
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
        text += "def _sign(x):\n    return float(x > 0.0) - float(x < 0.0)\n\n\n";
    }
    if program.calls(Function::Positive) {
        text += "def _positive(x):\n    return float(x > 0.0)\n\n\n";
    }
    let functions = program.functions.iter();
    let functions = functions.map(|(quantity, roots)| function(program, *quantity, roots));
    text += &functions.collect::<Vec<_>>().join("\n\n");
    if let Some(memory) = &program.memory {
        text += &state(program, memory);
    }
    text + &observer(program)
}

fn function(program: &Program, quantity: Quantity, roots: &[Id]) -> String {
    let (n, body) = (program.n_joints(), Body::of(&program.graph, roots, &Python));
    let mut lines = vec![
        format!("def {}({}):", quantity.name(), quantity.signals().join(", ")),
        format!("    \"\"\"{}: {}\"\"\"", quantity.formula(), program.cost(quantity)),
    ];
    let unpacked = quantity.signals().iter().map(|signal| unpacked(signal, n, signal));
    let columns = quantity.is_matrix().then_some(n);
    let results = body.listed("return ", columns);
    lines.extend(unpacked.chain(steps(&body)).chain(results).map(|line| format!("    {line}")));
    lines.push(String::new());
    lines.join("\n")
}

/// What friction remembers, as a class.
fn state(program: &Program, memory: &Memory) -> String {
    let (n, count) = (program.n_joints(), memory.states.len());
    let body = Body::of(&program.graph, &memory.states, &Python);
    let mut step = vec![
        unpacked("q", n, "q"),
        unpacked("last", n, "q if self._q is None else self._q"),
        unpacked("x", count, "self._x"),
    ];
    step.extend(steps(&body).chain(body.listed("self._x = ", None)));
    step.push(format!("self._q = ({})", names("q", n)));
    let mut methods = vec![
        method("__init__", &[], "Knows nothing of the way so far.", &["self.reset()".into()]),
        method(
            "reset",
            &[],
            "Forgets the way so far.",
            &["self._q = None".into(), format!("self._x = [0.0] * {count}")],
        ),
        method(
            "step",
            &["q"],
            &format!("Takes the next sample of q: {}", program.cost_of(&memory.states)),
            &step,
        ),
    ];
    for (quantity, roots) in &memory.after {
        let body = Body::of(&program.graph, roots, &Python);
        let signals: Vec<&str> = Memory::signals(*quantity).collect();
        let mut lines: Vec<String> = vec![
            "if self._q is None:".into(),
            "    raise ValueError(\"give step() a sample of q first\")".into(),
            unpacked("q", n, "self._q"),
            unpacked("x", count, "self._x"),
        ];
        lines.extend(signals.iter().map(|signal| unpacked(signal, n, signal)));
        lines.extend(steps(&body).chain(body.listed("return ", None)));
        let doc = format!("{}: {}", quantity.formula(), program.cost_of(roots));
        methods.push(method(&format!("{}_after", quantity.name()), &signals, &doc, &lines));
    }
    format!(
        "\n\nclass State:\n    \
         \"\"\"What friction remembers: give `step` every sample of q.\n\n    \
         What ends in `_after` is at the last sample; `torque` and `friction` have no memory \
         and are as\n    after a long way in the direction of dq.\n    \"\"\"\n\n{}",
        methods.join("\n")
    )
}

/// The momentum observer, as a class.
fn observer(program: &Program) -> String {
    let n = program.n_joints();
    let body = Body::of(&program.graph, &program.momentum, &Python);
    let mut lines = vec![unpacked("q", n, "q"), unpacked("dq", n, "dq")];
    let [memory, start, step, call] = match &program.memory {
        Some(memory) => {
            lines.push(unpacked("x", memory.states.len(), "x"));
            [
                ", x",
                "\n        self._friction = State()",
                "\n        self._friction.step(q)",
                "q, dq, self._friction._x",
            ]
        }
        None => ["", "", "", "q, dq"],
    };
    lines.extend(steps(&body).chain(body.listed("return ", Some(n))));
    format!(
        "\n\ndef _momentum(q, dq{memory}):\n    \
         \"\"\"Momentum, and the part of its change that is neither motor nor external.\"\"\"\n    \
         {}\n\n\nclass Observer:\n    \
         \"\"\"External torque by the momentum observer: give `step` every sample.\"\"\"\n\n    \
         def __init__(self):\n        \"\"\"Has seen nothing.\"\"\"\n        self.reset()\n\n    \
         def reset(self):\n        \"\"\"Forgets the samples so far.\"\"\"\n        \
         self._last = None\n        self._external = [0.0] * {n}{start}\n\n    \
         def step(self, gain, dt, q, dq, tau):\n        \
         \"\"\"What others put on the joints [N m], low-passed: {}\n\n        \
         `gain` [1/s] is 2 pi times the bandwidth [Hz], `dt` [s] the time since the last sample,\n\
         \x20       `tau` the torque of the motors.\n        \"\"\"{step}\n        \
         momentum, change = _momentum({call})\n        \
         change = [change[j] + tau[j] for j in range({n})]\n        \
         if self._last is not None and dt > 0.0:\n            \
         stays = exp(-gain * dt)\n            for j in range({n}):\n                \
         rate = (momentum[j] - self._last[0][j]) / dt\n                \
         own = 0.5 * (change[j] + self._last[1][j])\n                \
         self._external[j] = stays * self._external[j] + (1.0 - stays) * (rate - own)\n        \
         self._last = (momentum, change)\n        return list(self._external)\n",
        lines.join("\n    "),
        program.cost_of(&program.momentum)
    )
}

fn method(name: &str, signals: &[&str], doc: &str, lines: &[String]) -> String {
    let (arguments, lines) = ([&["self"], signals].concat().join(", "), lines.join("\n        "));
    format!("    def {name}({arguments}):\n        \"\"\"{doc}\"\"\"\n        {lines}\n")
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
