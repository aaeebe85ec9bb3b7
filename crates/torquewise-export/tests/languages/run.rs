//! From exported code to its values: compiled, run, its output read.

use crate::models::State;
use crate::witness::{lines, parsed};
use std::fs;
use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};
use torquewise_export::{Program, Quantity, fmu_sources};

/// Runs a command that must succeed, and returns what it prints.
pub(crate) fn output(command: &mut Command, input: &str) -> String {
    command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().unwrap();
    let mut stdin = child.stdin.take().unwrap();
    let input = input.to_owned();
    // Else both ends of the pipe may wait for each other.
    let writer = std::thread::spawn(move || drop(stdin.write_all(input.as_bytes())));
    let output = child.wait_with_output().unwrap();
    writer.join().unwrap();
    let complaint = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{command:?}: {complaint}");
    String::from_utf8(output.stdout).unwrap()
}

/// Whether a program is there; a machine of the workshop must have it.
pub(crate) fn has(program: &str) -> bool {
    let found = Command::new(program).arg("--version").output().is_ok();
    assert!(found || std::env::var_os("CI").is_none(), "{program} is missing");
    if !found {
        eprintln!("skipped: there is no {program}");
    }
    found
}

/// Values of all functions of a C file at some states.
pub(crate) fn c(folder: &Path, code: &str, real: &str, states: &[State]) -> Vec<Vec<f64>> {
    let n = states[0][0].len();
    let calls: Vec<String> = Quantity::ALL
        .iter()
        .map(|quantity| {
            let (arguments, count) = (quantity.signals().join(", "), count(*quantity, n));
            let name = quantity.name();
            format!(
                "        arm_{name}({arguments}, y);\n        \
                 for (int k = 0; k < {count}; k++) printf(\"%.17g \", (double)y[k]);\n"
            )
        })
        .collect();
    let calls = calls.concat();
    let main = format!(
        "#define ARM_DECLARATIONS_ONLY\n#include \"arm.c\"\n#include <stdio.h>\n\
         static int read(double *x) {{ return scanf(\"%lf\", x) == 1; }}\n\
         int main(void) {{\n    {real} x[{}], *q = x, *dq = x + {n}, *ddq = x + {}, *tau = ddq, y[{}];\n    \
         for (;;) {{\n        for (int k = 0; k < {}; k++) {{\n            double z;\n            \
         if (!read(&z)) return 0;\n            x[k] = ({real})z;\n        }}\n{calls}        \
         puts(\"\");\n    }}\n}}\n",
        3 * n,
        2 * n,
        n * n,
        3 * n
    );
    run_c(folder, code, &main, states)
}

/// What a main file prints that is compiled with a C file and fed some states.
fn run_c(folder: &Path, code: &str, main: &str, states: &[State]) -> Vec<Vec<f64>> {
    fs::write(folder.join("arm.c"), code).unwrap();
    fs::write(folder.join("main.c"), main).unwrap();
    let mut compiler = Command::new("cc");
    compiler.args(["-Wall", "-Wextra", "-Werror", "-std=c99", "-pedantic", "-O1"]);
    output(compiler.current_dir(folder).args(["main.c", "arm.c", "-o", "run", "-lm"]), "");
    parsed(&output(&mut Command::new(folder.join("run")), &lines(states)))
}

/// Samples after which a path is forgotten and followed anew.
pub(crate) const RESET: usize = 250;
/// K \[1/s\] of the momentum observer, and the time between samples \[s\].
pub(crate) const OBSERVED: [f64; 2] = [60.0, 1e-3];

/// Torque, friction, external torque and the acceleration of that torque of a C file along a path.
pub(crate) fn c_along(folder: &Path, code: &str, way: &[State]) -> Vec<Vec<f64>> {
    let n = way[0][0].len();
    let [gain, dt] = OBSERVED;
    let main = format!(
        "#define ARM_DECLARATIONS_ONLY\n#include \"arm.c\"\n#include <stdio.h>\n\
         int main(void) {{\n    arm_state state;\n    arm_observer observer;\n    \
         double x[3 * {n}], y[4 * {n}];\n    \
         for (int row = 0;; row++) {{\n        \
         for (int k = 0; k < 3 * {n}; k++) if (scanf(\"%lf\", x + k) != 1) return 0;\n        \
         if (row % {RESET} == 0) arm_reset(&state), arm_observer_reset(&observer);\n        \
         arm_step(&state, x);\n        arm_torque_after(&state, x + {n}, x + 2 * {n}, y);\n        \
         arm_friction_after(&state, x + {n}, y + {n});\n        \
         arm_observer_step(&observer, {gain:?}, {dt:?}, x, x + {n}, x + 2 * {n}, y + 2 * {n});\n\
         \x20       arm_forward_dynamics_after(&state, x + {n}, y, y + 3 * {n});\n        \
         for (int k = 0; k < 4 * {n}; k++) printf(\"%.17g \", y[k]);\n        \
         puts(\"\");\n    }}\n}}\n"
    );
    run_c(folder, code, &main, way)
}

/// The same by the functions of FMI, called as an importer does, along a path.
pub(crate) fn unit(folder: &Path, program: &Program, states: &[State]) -> Vec<Vec<f64>> {
    let n = states[0][0].len();
    let sources = fmu_sources(program, "arm").unwrap();
    let guid = sources[0].1.split("guid=\"").nth(1).unwrap().split('"').next().unwrap();
    for (path, text) in &sources {
        let file = folder.join(path);
        fs::create_dir_all(file.parent().unwrap()).unwrap();
        fs::write(file, text).unwrap();
    }
    let main = include_str!("importer.c").replace("JOINTS", &n.to_string());
    let main = main.replace("RESET", &RESET.to_string());
    let [gain, dt] = OBSERVED.map(|number| format!("{number:?}"));
    let main = main.replace("GAIN", &gain).replace("STEP", &dt);
    fs::write(folder.join("main.c"), main.replace("THE_GUID", guid)).unwrap();
    let mut compiler = Command::new("cc");
    compiler.args(["-Wall", "-Wextra", "-Werror", "-std=c99", "-pedantic", "-O1", "main.c"]);
    compiler.args(["sources/arm.c", "sources/arm_fmu.c", "-o", "run", "-lm"]);
    output(compiler.current_dir(folder), "");
    parsed(&output(&mut Command::new(folder.join("run")), &lines(states)))
}

/// Number of results of a function.
fn count(quantity: Quantity, n: usize) -> usize {
    if quantity.is_matrix() { n * n } else { n }
}

/// Values of all functions of a Rust file at some states; compiled alone too, without `std`.
pub(crate) fn rust(folder: &Path, code: &str, states: &[State]) -> Vec<Vec<f64>> {
    let calls: Vec<String> = Quantity::ALL
        .iter()
        .map(|quantity| {
            let signal = |name: &&str| format!("&{}", name.replace("tau", "_tau"));
            let arguments: Vec<_> = quantity.signals().iter().map(signal).collect();
            let (name, arguments) = (quantity.name(), arguments.join(", "));
            let flat = if quantity.is_matrix() { ".concat()" } else { "" };
            format!("        row.extend(arm::{name}::<Std>({arguments}){flat});\n")
        })
        .collect();
    let calls = calls.concat();
    run_rust(folder, code, ("", &calls), states)
}

/// The same of a Rust file.
pub(crate) fn rust_along(folder: &Path, code: &str, way: &[State]) -> Vec<Vec<f64>> {
    let [gain, dt] = OBSERVED;
    let before = "    let mut state = arm::State::default();\n    \
                  let mut observer = arm::Observer::default();\n";
    let calls = format!(
        "        if _row % {RESET} == 0 {{ state.reset(); observer.reset(); }}\n        \
         state.step::<Std>(&q);\n        \
         let tau = state.torque_after::<Std>(&dq, &ddq);\n        row.extend(tau);\n        \
         row.extend(state.friction_after::<Std>(&dq));\n        \
         row.extend(observer.step::<Std>({gain:?}, {dt:?}, &q, &dq, &ddq));\n        \
         row.extend(state.forward_dynamics_after::<Std>(&dq, &tau));\n"
    );
    run_rust(folder, code, (before, &calls), way)
}

/// What statements on `q`, `dq`, `ddq` add to `row`, with a Rust file as `arm`.
fn run_rust(
    folder: &Path,
    code: &str,
    (before, calls): (&str, &str),
    states: &[State],
) -> Vec<Vec<f64>> {
    let n = states[0][0].len();
    let main = format!(
        "#![deny(warnings)]\n#[allow(dead_code)] mod arm;\nstruct Std;\n\
         impl arm::Math for Std {{\n    \
         fn sin_cos(x: f64) -> (f64, f64) {{ x.sin_cos() }}\n    \
         fn exp(x: f64) -> f64 {{ x.exp() }}\n    fn tanh(x: f64) -> f64 {{ x.tanh() }}\n}}\n\
         fn main() {{\n{before}    \
         for (_row, line) in std::io::stdin().lines().enumerate() {{\n        \
         let line = line.unwrap();\n        let words = line.split_whitespace();\n        \
         let x: Vec<f64> = words.map(|x| x.parse().unwrap()).collect();\n\
         \x20       let part = |k: usize| -> [f64; {n}] {{\n\
         \x20           std::array::from_fn(|j| x[k * {n} + j])\n        }};\n\
         \x20       let (q, dq, ddq) = (part(0), part(1), part(2));\n        let _tau = ddq;\n        \
         let mut row: Vec<f64> = Vec::new();\n{calls}        \
         row.iter().for_each(|y| print!(\"{{y:?}} \"));\n        println!();\n\
         \x20   }}\n}}\n"
    );
    fs::write(folder.join("arm.rs"), code).unwrap();
    fs::write(folder.join("main.rs"), main).unwrap();
    let rustc = |arguments: &[&str]| {
        let mut compiler = Command::new("rustc");
        compiler.current_dir(folder).args(["--edition", "2021"]).args(arguments);
        output(&mut compiler, "");
    };
    assert!(code.contains("#![no_std]"));
    rustc(&["-D", "warnings", "--crate-type", "lib", "arm.rs"]);
    rustc(&["-C", "opt-level=1", "main.rs", "-o", "run"]);
    parsed(&output(&mut Command::new(folder.join("run")), &lines(states)))
}

/// Values of all functions of a Python file at some states.
pub(crate) fn python(folder: &Path, code: &str, states: &[State]) -> Vec<Vec<f64>> {
    let calls: Vec<String> = Quantity::ALL
        .iter()
        .map(|quantity| {
            let (name, arguments) = (quantity.name(), quantity.signals().join(", "));
            let count = count(*quantity, states[0][0].len());
            let flat = if quantity.is_matrix() { "sum(" } else { "list(" };
            let end = if quantity.is_matrix() { ", [])" } else { ")" };
            format!(
                "    try:\n        y += {flat}arm.{name}({arguments}){end}\n    \
                 except ZeroDivisionError:\n        y += [float(\"nan\")] * {count}\n"
            )
        })
        .collect();
    let calls = calls.concat();
    run_python(folder, code, ("", &calls), states)
}

/// The same of a Python file.
pub(crate) fn python_along(folder: &Path, code: &str, way: &[State]) -> Vec<Vec<f64>> {
    let [gain, dt] = OBSERVED;
    let before = "state = arm.State()\nobserver = arm.Observer()\ntry:\n    state.friction_after([0.0] * arm.JOINTS)\n    \
                  raise SystemExit(\"friction of a path that has not begun\")\n\
                  except ValueError:\n    pass\n";
    let calls = format!(
        "    if number % {RESET} == 0: state.reset(); observer.reset()\n    state.step(q)\n    \
         tau = state.torque_after(dq, ddq)\n    y += tau + state.friction_after(dq)\n    \
         y += observer.step({gain:?}, {dt:?}, q, dq, ddq)\n    \
         try:\n        y += state.forward_dynamics_after(dq, tau)\n    \
         except ZeroDivisionError:\n        y += [float(\"nan\")] * arm.JOINTS\n"
    );
    run_python(folder, code, (before, &calls), way)
}

/// What statements on `q`, `dq`, `ddq` add to `y`, with a Python file as `arm`.
fn run_python(
    folder: &Path,
    code: &str,
    (before, calls): (&str, &str),
    states: &[State],
) -> Vec<Vec<f64>> {
    let n = states[0][0].len();
    let main = format!(
        "import sys\nimport arm\n\n{}\n{before}for number, line in enumerate(sys.stdin):\n    \
         x = [Number(x) for x in line.split()]\n    q, dq, ddq = x[:{n}], x[{n}:{}], x[{}:]\n    tau = ddq\n    \
         y = []\n{calls}    print(*map(repr, y))\n",
        include_str!("number.py"),
        2 * n,
        2 * n
    );
    fs::write(folder.join("arm.py"), code).unwrap();
    fs::write(folder.join("main.py"), main).unwrap();
    let mut python = Command::new("python3");
    parsed(&output(python.current_dir(folder).arg("main.py"), &lines(states)))
}

/// Operations and functions that a Python file carries out in each of its functions.
pub(crate) fn counted(folder: &Path, code: &str) -> Vec<[usize; 2]> {
    fs::write(folder.join("arm.py"), code).unwrap();
    fs::write(folder.join("counting.py"), include_str!("counting.py")).unwrap();
    let line = |quantity: &Quantity| format!("{} {}\n", quantity.name(), quantity.signals().len());
    let calls: String = Quantity::ALL.iter().map(line).collect();
    let mut python = Command::new("python3");
    let text = output(python.current_dir(folder).arg("counting.py"), &calls);
    let numbers = |line: &str| -> [usize; 2] {
        let numbers: Vec<usize> = line.split(' ').map(|word| word.parse().unwrap()).collect();
        [numbers[0], numbers[1]]
    };
    text.lines().map(numbers).collect()
}

/// What pdflatex writes down of a document that it must typeset; `None` where there is no LaTeX.
pub(crate) fn typeset(folder: &Path, code: &str) -> Option<String> {
    if Command::new("pdflatex").arg("--version").output().is_err() {
        eprintln!("skipped: there is no pdflatex");
        return None;
    }
    fs::write(folder.join("arm.tex"), code).unwrap();
    let mut latex = Command::new("pdflatex");
    latex.args(["-interaction=nonstopmode", "-halt-on-error", "-draftmode", "arm.tex"]);
    let output = latex.current_dir(folder).output().unwrap();
    // Fonts and paths in it need not be UTF-8.
    let log = String::from_utf8_lossy(&fs::read(folder.join("arm.log")).unwrap()).into_owned();
    assert!(output.status.success(), "{log}");
    Some(log)
}
