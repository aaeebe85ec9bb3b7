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

fn replaced<const N: usize>(text: &str, words: [(&str, &str); N]) -> String {
    words.iter().fold(text.to_owned(), |text, (word, by)| text.replace(word, by))
}

/// A call of each function: its name, its arguments, the number of its results, and whether they
/// are a matrix.
fn calls(n: usize, call: impl Fn(&str, &[&str], usize, bool) -> String) -> String {
    let call = |quantity: &Quantity| {
        let is_matrix = quantity.is_matrix();
        let count = if is_matrix { n * n } else { n };
        call(quantity.name(), quantity.signals(), count, is_matrix)
    };
    Quantity::ALL.iter().map(call).collect()
}

/// Writes a file, and the folder that it is in.
pub(crate) fn write(file: &Path, text: &str) {
    fs::create_dir_all(file.parent().unwrap()).unwrap();
    fs::write(file, text).unwrap();
}

/// Compiles a main file and others of C in a folder to a program `run`, and parses what that prints
/// of some states.
fn compiled(folder: &Path, main: &str, others: &[&str], states: &[State]) -> Vec<Vec<f64>> {
    fs::write(folder.join("main.c"), main).unwrap();
    let mut compiler = Command::new("cc");
    compiler.args(["-Wall", "-Wextra", "-Werror", "-std=c99", "-pedantic", "-O1", "main.c"]);
    output(compiler.current_dir(folder).args(others).args(["-o", "run", "-lm"]), "");
    parsed(&output(&mut Command::new(folder.join("run")), &lines(states)))
}

/// Values of all functions of a C file at some states.
pub(crate) fn c(folder: &Path, code: &str, real: &str, states: &[State]) -> Vec<Vec<f64>> {
    let calls = calls(states[0][0].len(), |name, signals, count, _| {
        format!("        arm_{name}({}, y);\n        SHOW({count});\n", signals.join(", "))
    });
    let main = replaced(include_str!("states.c"), [("REAL", real), ("CALLS", &calls)]);
    fs::write(folder.join("arm.c"), code).unwrap();
    compiled(folder, &main, &["arm.c"], states)
}

/// Samples after which a path is forgotten and followed anew.
pub(crate) const RESET: usize = 250;
/// K \[1/s\] of the momentum observer, and the time between samples \[s\].
pub(crate) const OBSERVED: [f64; 2] = [60.0, 1e-3];

/// Code along a path, its numbers filled in.
fn along(text: &str) -> String {
    let [gain, dt] = OBSERVED.map(|number| format!("{number:?}"));
    replaced(text, [("RESET", &RESET.to_string()), ("GAIN", &gain), ("STEP", &dt)])
}

/// What stands above the line `for way in EACH:` of statements, and what is done for each state.
fn before_and_calls(text: &str) -> (&str, &str) {
    text.split_once("for way in EACH:\n").unwrap_or(("", text))
}

/// Torque, friction, external torque and the acceleration of that torque of a C file along a path.
pub(crate) fn c_along(folder: &Path, code: &str, way: &[State]) -> Vec<Vec<f64>> {
    fs::write(folder.join("arm.c"), code).unwrap();
    compiled(folder, &along(include_str!("along.c")), &["arm.c"], way)
}

/// The same by the functions of FMI, called as an importer does, along a path.
pub(crate) fn unit(folder: &Path, program: &Program, states: &[State]) -> Vec<Vec<f64>> {
    let sources = fmu_sources(program, "arm").unwrap();
    let guid = sources[0].1.split("guid=\"").nth(1).unwrap().split('"').next().unwrap();
    for (path, text) in &sources {
        write(&folder.join(path), text);
    }
    let main = along(include_str!("importer.c"));
    let n = states[0][0].len().to_string();
    let main = replaced(&main, [("JOINTS", &n), ("THE_GUID", guid)]);
    compiled(folder, &main, &["sources/arm.c", "sources/arm_fmu.c"], states)
}

/// Values of all functions of a Rust file at some states; compiled alone too, without `std`.
pub(crate) fn rust(folder: &Path, code: &str, states: &[State]) -> Vec<Vec<f64>> {
    let calls = calls(states[0][0].len(), |name, signals, _, is_matrix| {
        let arguments = signals.iter().map(|signal| format!("&{},", signal.replace("tau", "_tau")));
        let flat = if is_matrix { ".concat()" } else { "" };
        format!("row.extend(arm::{name}::<Std>({}){flat});\n", arguments.collect::<String>())
    });
    run_rust(folder, code, &calls, states)
}

/// The same of a Rust file.
pub(crate) fn rust_along(folder: &Path, code: &str, way: &[State]) -> Vec<Vec<f64>> {
    run_rust(folder, code, &along(include_str!("along.rs.txt")), way)
}

/// What statements on `q`, `dq`, `ddq` add to `row`, with a Rust file as `arm`.
fn run_rust(folder: &Path, code: &str, text: &str, states: &[State]) -> Vec<Vec<f64>> {
    let (before, calls) = before_and_calls(text);
    let main = include_str!("driver.rs.txt");
    let main = replaced(main, [("BEFORE", before), ("CALLS", calls)]);
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
    let calls = calls(states[0][0].len(), |name, signals, count, is_matrix| {
        let call = format!("arm.{name}({})", signals.join(", "));
        let flat = if is_matrix { format!("sum({call}, [])") } else { call };
        format!("    add(lambda: {flat}, {count})\n")
    });
    run_python(folder, code, &calls, states)
}

/// The same of a Python file.
pub(crate) fn python_along(folder: &Path, code: &str, way: &[State]) -> Vec<Vec<f64>> {
    run_python(folder, code, &along(include_str!("along.py")), way)
}

/// What statements on `q`, `dq`, `ddq` add to `y`, with a Python file as `arm`.
fn run_python(folder: &Path, code: &str, text: &str, states: &[State]) -> Vec<Vec<f64>> {
    let (before, calls) = before_and_calls(text);
    let words = [("NUMBER", include_str!("number.py")), ("BEFORE", before), ("CALLS", calls)];
    fs::write(folder.join("arm.py"), code).unwrap();
    fs::write(folder.join("main.py"), replaced(include_str!("driver.py"), words)).unwrap();
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
