//! A model as files for other programs: code for controllers, robots for simulators.

use crate::physics::MassMatrix;
use crate::{Error, Result};
use std::env;
use std::env::consts::{ARCH, DLL_SUFFIX, OS};
use std::fs::{self, File};
use std::io;
use std::path::Path;
use std::process::{Command, Stdio};
use torquewise_export::{
    Precision, Program, fmu_archive, fmu_sources, onto_urdf, ros_package, to_c, to_isaac_lab,
    to_latex, to_mjcf, to_python, to_rust, to_urdf,
};
use torquewise_identify::samples;
use torquewise_model::{Model, to_json};

/// What is written: [`Target::NAMED`] says what each is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(missing_docs, reason = "a table says what each is")]
pub enum Target {
    C,
    Rust,
    Python,
    Latex,
    Fmu,
    Ros2,
    Urdf,
    Mjcf,
    IsaacLab,
    Json,
}

impl Target {
    /// All of them by their names, with what each is.
    pub const NAMED: [(&'static str, &'static str, Self); 10] = [
        ("c", "One file of C99", Self::C),
        ("rust", "One file of Rust without std", Self::Rust),
        ("python", "One file of Python", Self::Python),
        ("latex", "A LaTeX document", Self::Latex),
        ("fmu", "An FMI 2.0 unit for model exchange and co-simulation", Self::Fmu),
        ("ros2", "Sources of a ROS 2 package", Self::Ros2),
        ("urdf", "A robot for ROS, Pinocchio, Drake, Gazebo", Self::Urdf),
        ("mjcf", "A robot for MuJoCo", Self::Mjcf),
        ("isaaclab", "Armature and friction of the joints for Isaac Lab", Self::IsaacLab),
        ("json", "A model file, as fit writes it", Self::Json),
    ];

    /// Whether it is code, not a robot or a model.
    pub fn is_code(self) -> bool {
        !matches!(self, Self::Urdf | Self::Mjcf | Self::IsaacLab | Self::Json)
    }

    /// How the name of its file may end, the usual ending first; none for a package.
    pub fn endings(self) -> &'static [&'static str] {
        match self {
            Self::C => &["c", "h"],
            Self::Rust => &["rs"],
            Self::Python => &["py"],
            Self::Latex => &["tex"],
            Self::Fmu => &["fmu"],
            Self::Ros2 => &[],
            Self::Urdf => &["urdf"],
            Self::Mjcf => &["xml", "mjcf"],
            Self::IsaacLab | Self::Json => &["json"],
        }
    }
}

/// How it is written.
#[derive(Clone, Debug)]
pub struct ExportOptions<'a> {
    /// What the functions of C, an FMU or a ROS 2 package begin with.
    pub name: &'a str,
    /// Of the numbers of C and Rust.
    pub precision: Precision,
    /// Half width of the reversal of friction \[rad/s\]; as it was learned without.
    pub reversal: Option<f64>,
    /// Text of the URDF that inertia and friction are put into, and its joints that are held at 0.
    pub onto: Option<(&'a str, &'a [String])>,
    /// Whether an FMU is compiled for this machine, by the compiler in `CC`, else `cc`.
    pub binary: bool,
    /// Whether a model is written whose mass matrix is not positive definite.
    pub force: bool,
    /// How many models are written in place of the one, drawn from what its log does not tell, and
    /// the seed of the draws; for simulators that randomise an arm.
    pub samples: Option<(usize, u64)>,
    /// An empty folder for the work of the compiler; without, a temporary one of the system.
    pub work: Option<&'a Path>,
}

/// Files of a model.
#[derive(Debug)]
pub struct Exported {
    /// Path within the folder of a package, empty for a single file, and content.
    pub files: Vec<(String, Vec<u8>)>,
    /// The functions of code; none for a robot.
    pub program: Option<Program>,
    /// Version of the program and fingerprint of the model.
    pub version: String,
    /// What a robot file has no room for.
    pub left_out: Vec<String>,
    /// Why it should not move an arm: a mass matrix that was forced, a model without use.
    pub flaws: Vec<String>,
}

/// Writes a model for another program.
///
/// # Errors
/// [`Error::NotPositiveDefinite`] unless it is forced, [`Error::Export`], [`Error::Identify`] if there
/// is nothing to draw samples from, and
/// [`Error::NoCompiler`] or [`Error::Compiler`] for a unit with a binary.
///
/// ```no_run
/// # fn main() -> Result<(), torquewise::Error> {
/// use torquewise::Model;
/// use torquewise::exported::{ExportOptions, Target, export};
///
/// let arm = Model::load("arm.json")?;
/// let code = export(&arm, Target::Rust, &ExportOptions::named("arm"))?;
/// println!("{}", String::from_utf8_lossy(&code.files[0].1));
/// # Ok(())
/// # }
/// ```
pub fn export(model: &Model, to: Target, options: &ExportOptions<'_>) -> Result<Exported> {
    let mut exported = export_one(model, to, options)?;
    if let Some((count, seed)) = options.samples {
        exported.files.clear();
        for (k, drawn) in (1..).zip(samples(model, count, seed)?) {
            let own = export_one(&drawn, to, options)?;
            let stem = format!("{}-{k:03}", options.name);
            exported.files.extend(own.files.into_iter().map(|(path, bytes)| {
                let file = match to.endings().first() {
                    Some(ending) => format!("{stem}.{ending}"),
                    None => format!("{stem}/{path}"),
                };
                (file, bytes)
            }));
        }
    }
    Ok(exported)
}

fn export_one(model: &Model, to: Target, options: &ExportOptions<'_>) -> Result<Exported> {
    let flaw = MassMatrix::of(model)?.flaw();
    if let (Some(flaw), false) = (&flaw, options.force) {
        return Err(Error::NotPositiveDefinite { flaw: flaw.clone() });
    }
    let model = &options.reversal.map_or_else(|| model.clone(), |w| model.with_reversal(w));
    let program = Program::of(model)?;
    let version = program.version();
    let single = |text: String| vec![(String::new(), text.into_bytes())];
    let (mut files, mut left_out) = (Vec::new(), Vec::new());
    let ExportOptions { name, precision, .. } = *options;
    match to {
        Target::C => files = single(to_c(&program, name, precision)?),
        Target::Rust => files = single(to_rust(&program, precision)?),
        Target::Python => files = single(to_python(&program)?),
        Target::Latex => files = single(to_latex(model, &version)),
        Target::Fmu => files = vec![(String::new(), unit(&program, options)?)],
        Target::Ros2 => {
            let package = ros_package(&program, name)?;
            files.extend(package.into_iter().map(|(path, text)| (path, text.into_bytes())));
        }
        Target::Json => files = single(to_json(model)?),
        Target::Urdf | Target::Mjcf | Target::IsaacLab => {
            let robot = match (to, options.onto) {
                (Target::Urdf, Some((onto, locked))) => onto_urdf(model, onto, locked)?,
                (Target::Urdf, None) => to_urdf(model, &version)?,
                (Target::IsaacLab, _) => to_isaac_lab(model)?,
                _ => to_mjcf(model, &version)?,
            };
            (files, left_out) = (single(robot.text), robot.left_out);
        }
    }
    let program = to.is_code().then_some(program);
    let of_fit = model.training.useless().map(|own| format!("the verdict of its fit is {own}"));
    let flaws = flaw.into_iter().chain(of_fit).collect();
    Ok(Exported { files, program, version, left_out, flaws })
}

impl<'a> ExportOptions<'a> {
    /// The usual ones, with a name for the functions.
    pub fn named(name: &'a str) -> Self {
        Self {
            name,
            precision: Precision::Double,
            reversal: None,
            onto: None,
            binary: true,
            force: false,
            samples: None,
            work: None,
        }
    }
}

/// A name for functions from that of a file: whatever C does not allow is replaced.
pub fn function_name(stem: &str) -> String {
    let allowed = |letter: char| letter.is_ascii_alphanumeric();
    let name: String = stem.chars().map(|c| if allowed(c) { c } else { '_' }).collect();
    let plain = name.starts_with(|letter: char| letter.is_ascii_alphabetic());
    if plain { name } else { format!("arm{name}") }
}

fn unit(program: &Program, options: &ExportOptions<'_>) -> Result<Vec<u8>> {
    let sources = fmu_sources(program, options.name)?;
    if !options.binary {
        return Ok(fmu_archive(&sources, None)?);
    }
    let (path, bytes) = if let Some(folder) = options.work {
        binary(&sources, options.name, folder)?
    } else {
        let made = tempfile::tempdir();
        let made = made.map_err(|source| Error::NoCompiler { compiler: compiler(), source })?;
        binary(&sources, options.name, made.path())?
    };
    Ok(fmu_archive(&sources, Some((&path, &bytes)))?)
}

/// The compiler of C, with its arguments, that the environment names.
fn compiler() -> String {
    env::var("CC").ok().filter(|cc| !cc.is_empty()).unwrap_or_else(|| "cc".into())
}

/// Where FMI 2.0 wants the binary of this machine, and its bytes.
///
/// - `sources`: path within the unit and text; those under `sources/` that end in `_fmu.c` and
///   `.c` are compiled together
fn binary(sources: &[(String, String)], name: &str, folder: &Path) -> Result<(String, Vec<u8>)> {
    let compiler = compiler();
    let in_folder = |source: io::Error| Error::NoCompiler { compiler: compiler.clone(), source };
    // As for make, CC may hold arguments; a path may hold spaces.
    let mut words: Vec<&str> = compiler.split_whitespace().collect();
    if words.is_empty() || Path::new(&compiler).exists() {
        words = vec![&compiler];
    }
    let mut command = Command::new(words[0]);
    command.args(&words[1..]);
    command.current_dir(folder).args(["-std=c99", "-O2", "-fPIC", "-shared"]);
    command.arg("-fvisibility=hidden");
    for (path, text) in sources {
        let Some(file) = path.strip_prefix("sources/") else { continue };
        fs::write(folder.join(file), text).map_err(in_folder)?;
        command.arg(file);
    }
    let library = format!("{name}{DLL_SUFFIX}");
    let complaints = folder.join("complaints");
    command.args(["-o", &library, "-lm"]).stdin(Stdio::null()).stdout(Stdio::null());
    // What the compiler writes between goes where it is removed.
    command.env("TMPDIR", folder);
    command.stderr(File::create(&complaints).map_err(in_folder)?);
    if !command.status().map_err(in_folder)?.success() {
        let complaint = fs::read(&complaints).map_err(in_folder)?;
        let complaint = match String::from_utf8_lossy(&complaint).trim() {
            "" => "it says nothing".to_owned(),
            told => told.to_owned(),
        };
        return Err(Error::Compiler { compiler, complaint });
    }
    let bytes = fs::read(folder.join(&library)).map_err(in_folder)?;
    Ok((format!("binaries/{}/{library}", platform()), bytes))
}

/// The name FMI 2.0 gives this machine, which knows no others than x86.
fn platform() -> String {
    let system = match OS {
        "macos" => "darwin",
        "windows" => "win",
        other => other,
    };
    match ARCH {
        "x86" => format!("{system}32"),
        "x86_64" => format!("{system}64"),
        other => format!("{other}-{system}"),
    }
}
