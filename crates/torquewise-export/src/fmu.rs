//! A program as an FMI 2.0 unit for model exchange and co-simulation, sources and binary.

use crate::c::{C, check_name, inclusion};
use crate::text::Language;
use crate::{Precision, Program, Quantity, Result, filled, to_c};
use minijinja::context;
use std::io::{Cursor, Write};
use zip::ZipWriter;
use zip::result::ZipError;
use zip::write::SimpleFileOptions;

const WRAPPER: &str = include_str!("assets/fmu.c");

/// The files of a unit but its binary: path within the unit and text.
///
/// Inputs are `q[i]`, `dq[i]`, `ddq[i]` and the torque of the motors `effort[i]`, the parameter is
/// `bandwidth` \[Hz\] of the momentum observer; outputs are `tau[i]`, `gravity[i]`, `coriolis[i]`,
/// `inertia[i,j]`, `friction[i]`, `step1[i]`, `coriolis_matrix[i,j]`, `inverse_inertia[i,j]`,
/// `forward_dynamics[i]` and the external torque `external[i]`; joints from 1, SI units. `sources/NAME_fmu.c` and
/// `sources/NAME.c`, compiled together as C99, make the binary.
///
/// # Errors
/// `ExportError::Name` if the name is no C identifier.
pub fn fmu_sources(program: &Program, name: &str) -> Result<Vec<(String, String)>> {
    check_name(name)?;
    let code = to_c(program, name, Precision::Double)?;
    let wrapper = format!(
        "/* {} */\n\n{}#define N {}\n#define GUID {}\n\n{WRAPPER}",
        program.version(),
        inclusion(program, name),
        program.n_joints(),
        C(Precision::Double).quoted(&guid(program)),
    );
    Ok(vec![
        ("modelDescription.xml".into(), description(program, name)?),
        (format!("sources/{name}.c"), code),
        (format!("sources/{name}_fmu.c"), wrapper),
    ])
}

/// The unit itself, a ZIP archive.
///
/// - `sources`: of [`fmu_sources`]
/// - `binary`: path within the unit, such as `binaries/linux64/NAME.so`, and bytes
///
/// # Errors
/// `ExportError::Archive` if the archive grows too large.
pub fn fmu_archive(sources: &[(String, String)], binary: Option<(&str, &[u8])>) -> Result<Vec<u8>> {
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    // The same model gives the same bytes: the archive holds no time of day.
    let options = SimpleFileOptions::default().last_modified_time(zip::DateTime::default());
    let texts = sources.iter().map(|(path, text)| (path.as_str(), text.as_bytes()));
    for (path, bytes) in texts.chain(binary) {
        archive.start_file(path, options)?;
        archive.write_all(bytes).map_err(ZipError::from)?;
    }
    Ok(archive.finish()?.into_inner())
}

fn guid(program: &Program) -> String {
    format!("{{torquewise-{:016x}}}", program.fingerprint)
}

/// A unit of joints that turn, where so many of them, up to two, slide.
fn slid(unit: &str, slides: usize) -> String {
    match slides {
        0 => unit.to_owned(),
        1 => unit.replace("N.m", "N").replace("rad", "m").replace("kg.m2", "kg.m"),
        _ => unit.replace("(kg.m2)", "kg").replace("kg.m2", "kg"),
    }
}

fn description(program: &Program, name: &str) -> Result<String> {
    let (n, kinds) = (program.n_joints(), program.model.kinds());
    let of_joint = |joint: usize| format!("joint {}", program.model.joints[joint]);
    let vector = |name: &str, unit: &'static str| -> Vec<[String; 3]> {
        let own = |joint| slid(unit, usize::from(kinds.slides(joint)));
        (0..n).map(|j| [format!("{name}[{}]", j + 1), own(j), of_joint(j)]).collect()
    };
    let signals = [("q", "rad"), ("dq", "rad/s"), ("ddq", "rad/s2"), ("effort", "N.m")];
    let inputs: Vec<_> = signals.iter().flat_map(|(signal, unit)| vector(signal, unit)).collect();
    let mut outputs = Vec::new();
    for quantity in Quantity::ALL {
        let name = if quantity == Quantity::Torque { "tau" } else { quantity.name() };
        let unit = match quantity {
            Quantity::Inertia => "kg.m2",
            Quantity::CoriolisMatrix => "kg.m2/s",
            Quantity::InverseInertia => "1/(kg.m2)",
            Quantity::ForwardDynamics => "rad/s2",
            _ => "N.m",
        };
        if quantity.is_matrix() {
            outputs.extend((0..n * n).map(|place| {
                let (i, j) = (place / n, place % n);
                let text = format!("{} by {}", of_joint(i), of_joint(j));
                let slides = [i, j].into_iter().filter(|&k| kinds.slides(k)).count();
                [format!("{name}[{},{}]", i + 1, j + 1), slid(unit, slides), text]
            }));
        } else {
            outputs.extend(vector(name, unit));
        }
    }
    outputs.extend(vector("external", "N.m"));
    filled(
        "xml",
        include_str!("templates/modelDescription.xml.j2"),
        context! {
            name, inputs, outputs,
            slides => !kinds.all_turn(),
            parameter => 4 * n,
            guid => guid(program),
            version => env!("CARGO_PKG_VERSION"),
        },
    )
}
