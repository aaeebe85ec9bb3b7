//! `export`: a model as source code, an FMU, a ROS 2 package or a robot file.

use crate::arguments::{Word, choice, fitting};
use crate::files::{create_folder, read_text, work_folder};
use crate::{CliError, Outcome, Result, Table, check_files, read_model, write_whole};
use clap::{Args, value_parser};
use serde_json::json;
use std::fs;
use std::path::{Path, PathBuf};
use torquewise::export::{Precision, Program, Quantity, test_vectors};
use torquewise::exported::{self, ExportOptions, Exported, Target, function_name};
use torquewise::model::Model;

/// Write a model as code for a controller, or as a robot for a simulator
///
/// Code holds torque, gravity, coriolis, inertia and friction; robot files hold links, rotors and
/// friction.
#[derive(Args, Debug)]
pub(crate) struct Arguments {
    /// Model file
    model: PathBuf,
    /// What to write
    #[arg(long, value_parser = choice(&Target::NAMED))]
    to: Target,
    /// File to write, for ros2 and samples a new folder
    #[arg(short, long, value_name = "PATH")]
    output: PathBuf,
    /// Precision of the numbers, for c and rust
    #[arg(help_heading = "Code", long, value_parser = choice(&PRECISIONS), default_value = "double")]
    precision: Precision,
    /// URDF of the arm to put inertia and friction into, all else of it kept, for urdf
    #[arg(help_heading = "Robot", long, value_name = "ROBOT.urdf")]
    onto: Option<PathBuf>,
    /// Joints of that URDF that are held at 0, where names do not tell
    #[arg(help_heading = "Robot", long, value_name = "JOINT")]
    #[arg(value_delimiter = ',', requires = "onto")]
    lock: Vec<String>,
    /// What the functions begin with, for c, fmu and ros2 [default: the name of the file]
    #[arg(help_heading = "Code", long, value_name = "NAME")]
    name: Option<String>,
    /// Half width of the reversal of friction, 0 for the exact sign [default: as it was learned]
    ///
    /// A learner smooths reversals for the noise of measured velocities. A desired velocity has
    /// none: 0.002 tracks better.
    #[arg(help_heading = "Code", long, value_name = "RAD/S")]
    #[arg(value_parser = fitting(|width: &f64| width.is_finite() && *width >= 0.0, "expected 0 or more radians per second"))]
    reversal: Option<f64>,
    /// Write so many models in place of the one into a new folder, drawn from its covariance
    ///
    /// Each is an arm that the log may as well be of, all of them physical: what a simulator
    /// randomises a robot by.
    #[arg(long, value_name = "N", value_parser = value_parser!(u32).range(1..=100_000))]
    samples: Option<u32>,
    /// Seed of the samples, and of the states of test vectors
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Also write 1000 states and what the model returns there, FILE.vectors.csv
    #[arg(help_heading = "Code", long)]
    test_vectors: bool,
    /// Write an fmu of sources alone
    #[arg(help_heading = "Code", long)]
    no_binary: bool,
    /// Export a model whose mass matrix is not positive definite all the same
    #[arg(long)]
    force: bool,
}

const PRECISIONS: [Word<Precision>; 2] =
    [("double", "64 bits", Precision::Double), ("float", "32 bits", Precision::Single)];

const TEST_STATES: usize = 1000;

pub(crate) fn run(arguments: &Arguments) -> Result<Outcome> {
    let Arguments { to, output, .. } = arguments;
    check_usage(arguments)?;
    let vectors = arguments.test_vectors.then(|| output.with_extension("vectors.csv"));
    check_paths(arguments, vectors.as_ref())?;
    let model = read_model(&arguments.model)?;
    let onto = arguments.onto.as_ref().map(|onto| read_text(onto)).transpose()?;
    let has_binary = *to == Target::Fmu && !arguments.no_binary;
    let work = has_binary.then(work_folder).transpose()?;
    // The name given, or that of the file, with whatever C does not allow replaced.
    let stem = output.file_stem().unwrap_or_default().to_string_lossy();
    let options = ExportOptions {
        name: &arguments.name.clone().unwrap_or_else(|| function_name(&stem)),
        precision: arguments.precision,
        reversal: arguments.reversal,
        onto: onto.as_ref().map(|text| (&text[..], &arguments.lock[..])),
        binary: has_binary,
        force: arguments.force,
        samples: arguments.samples.map(|count| (count as usize, arguments.seed)),
        work: work.as_deref(),
    };
    let exported = exported::export(&model, *to, &options)?;
    match &exported.files[..] {
        [(path, bytes)] if path.is_empty() => write_whole(output, bytes)?,
        files => {
            create_folder(output)?;
            for (path, bytes) in files {
                let file = output.join(path);
                file.parent().map_or(Ok(()), create_folder)?;
                write_whole(&file, bytes)?;
            }
        }
    }
    if let Some(file) = &vectors {
        let model = arguments.reversal.map_or_else(|| model.clone(), |w| model.with_reversal(w));
        write_whole(file, test_vectors(&model, TEST_STATES, arguments.seed)?)?;
    }
    let (outcome, what) = match &exported.program {
        None => (robot(arguments, &model, &exported), "model"),
        Some(program) => (outcome(arguments, &model, program, vectors.as_deref()), "code"),
    };
    let flaws = exported.flaws.into_iter();
    let warnings = flaws.map(|flaw| format!("{flaw}: do not let this {what} move an arm"));
    Ok(Outcome { warnings: warnings.collect(), ..outcome })
}

/// What is said of a robot file, and what it has no room for.
fn robot(arguments: &Arguments, model: &Model, exported: &Exported) -> Outcome {
    let Exported { version, left_out, files, .. } = exported;
    let notes = left_out.iter().map(|part| format!("not in the file: {part}")).collect();
    let holds = match arguments.to {
        Target::Json => "",
        Target::IsaacLab => ": armature, breakaway, dry and viscous friction",
        _ => ": links, rotors, viscous and dry friction",
    };
    let text = format!(
        "{version}\n{} joints{holds}\n\nwritten: {}{}\n",
        model.n_joints(),
        arguments.samples.map(|count| format!("{count} models drawn, ")).unwrap_or_default(),
        arguments.output.display()
    );
    let json = json!({
        "version": version,
        "joints": model.joints,
        "left_out": left_out,
        "output": arguments.output,
        "files": files.iter().map(|(path, _)| path).filter(|path| !path.is_empty()).collect::<Vec<_>>(),
    });
    Outcome { text, json, notes, ..Outcome::default() }
}

fn check_usage(arguments: &Arguments) -> Result<()> {
    let Arguments { to, precision, name, no_binary, .. } = arguments;
    let single = *precision == Precision::Single && !matches!(to, Target::C | Target::Rust);
    let named = name.is_some() && !matches!(to, Target::C | Target::Fmu | Target::Ros2);
    let is_one_code = to.is_code() && arguments.samples.is_none();
    let all = [
        (single, "--precision float is for --to c and rust"),
        (arguments.onto.is_some() && *to != Target::Urdf, "--onto is for --to urdf"),
        (arguments.test_vectors && !is_one_code, "--test-vectors is for the code of one model"),
        (named, "--name is for --to c, fmu and ros2"),
        (*no_binary && *to != Target::Fmu, "--no-binary is for --to fmu"),
    ];
    all.into_iter()
        .find(|(is_misplaced, _)| *is_misplaced)
        .map_or(Ok(()), |(_, text)| Err(CliError::Usage(format!("{text}: leave it out"))))
}

fn check_paths(arguments: &Arguments, vectors: Option<&PathBuf>) -> Result<()> {
    let Arguments { to, output, .. } = arguments;
    let inputs = std::iter::once(&arguments.model).chain(&arguments.onto);
    let vectors = vectors.map(|file| (file.as_path(), &[][..]));
    if *to != Target::Ros2 && arguments.samples.is_none() {
        return check_files(inputs, vectors.into_iter().chain([(output.as_path(), to.endings())]));
    }
    let is_full = || fs::read_dir(output).is_ok_and(|mut entries| entries.next().is_some());
    if output.exists() && is_full() {
        return Err(CliError::refused(output, "exists and is not empty", "name a new folder"));
    }
    check_files(inputs, vectors)
}

fn outcome(
    arguments: &Arguments,
    model: &Model,
    program: &Program,
    vectors: Option<&Path>,
) -> Outcome {
    let mut table = Table::new(["function", "+ - * /", "sin cos exp tanh"]);
    let mut costs = json!({});
    for quantity in Quantity::ALL {
        let (cost, name) = (program.cost(quantity), quantity.name());
        table.row(name, [cost.operations.to_string(), cost.functions.to_string()]);
        costs[name] = json!({ "operations": cost.operations, "functions": cost.functions });
    }
    let mut text = format!(
        "{}\n{} joints, {} coefficients\n\n{}\nwritten: {}\n",
        program.version(),
        model.n_joints(),
        model.n_coefficients(),
        table.text(),
        arguments.output.display()
    );
    text.extend(vectors.map(|file| format!("test vectors: {}\n", file.display())));
    let json = json!({
        "version": program.version(),
        "joints": model.joints,
        "coefficients": model.n_coefficients(),
        "costs": costs,
        "output": arguments.output,
        "test_vectors": vectors,
    });
    Outcome { text, json, ..Outcome::default() }
}
