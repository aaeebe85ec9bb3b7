//! From c sources to shared library, by the compiler of the machine.

use crate::error::CliError;
use std::env;
use std::env::consts::{ARCH, DLL_SUFFIX, OS};
use std::fs;
use std::path::Path;
use std::process::Command;

/// Where FMI 2.0 wants the binary of this machine, and its bytes.
///
/// - `sources`: path within the unit and text; those under `sources/` that end in `_fmu.c` and
///   `.c` are compiled together
///
/// # Errors
/// [`CliError::NoCompiler`], [`CliError::Compiler`] with what it says, or [`CliError::Write`].
pub(crate) fn binary(
    sources: &[(String, String)],
    name: &str,
) -> Result<(String, Vec<u8>), CliError> {
    let compiler = env::var("CC").ok().filter(|cc| !cc.is_empty()).unwrap_or_else(|| "cc".into());
    let in_folder = |source| CliError::Write { file: env::temp_dir(), source };
    let folder = tempfile::tempdir().map_err(in_folder)?;
    let mut command = Command::new(&compiler);
    command.current_dir(folder.path()).args(["-std=c99", "-O2", "-fPIC", "-shared"]);
    command.arg("-fvisibility=hidden");
    for (path, text) in sources {
        let Some(file) = path.strip_prefix("sources/") else { continue };
        fs::write(folder.path().join(file), text).map_err(in_folder)?;
        command.arg(file);
    }
    let library = format!("{name}{DLL_SUFFIX}");
    let ran = command.args(["-o", &library, "-lm"]).output();
    let output =
        ran.map_err(|source| CliError::NoCompiler { compiler: compiler.clone(), source })?;
    if !output.status.success() {
        let complaint = String::from_utf8_lossy(&output.stderr).trim().to_owned();
        return Err(CliError::Compiler { compiler, complaint });
    }
    let bytes = fs::read(Path::new(folder.path()).join(&library)).map_err(in_folder)?;
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
