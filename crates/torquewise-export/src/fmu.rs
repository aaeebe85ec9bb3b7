//! From program to FMU: an FMI 2.0 unit for model exchange and co-simulation, sources and binary.

use crate::c::{check_name, inclusion, quoted, to_c};
use crate::error::ExportError;
use crate::program::{Precision, Program, Quantity};
use std::fmt::Write as _;
use std::io::{Cursor, Write as _};
use zip::ZipWriter;
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
/// [`ExportError::Name`] if the name is no C identifier.
pub fn fmu_sources(program: &Program, name: &str) -> Result<Vec<(String, String)>, ExportError> {
    check_name(name)?;
    let code = to_c(program, name, Precision::Double)?;
    let wrapper = format!(
        "/* {} */\n\n{}#define N {}\n#define GUID {}\n\n{WRAPPER}",
        program.version(),
        inclusion(program, name),
        program.n_joints(),
        quoted(&guid(program)),
    );
    Ok(vec![
        ("modelDescription.xml".into(), description(program, name)),
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
/// [`ExportError::Archive`] or [`ExportError::Fill`] if the archive grows too large.
pub fn fmu_archive(
    sources: &[(String, String)],
    binary: Option<(&str, &[u8])>,
) -> Result<Vec<u8>, ExportError> {
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    // The same model gives the same bytes: the archive holds no time of day.
    let options = SimpleFileOptions::default().last_modified_time(zip::DateTime::default());
    let texts = sources.iter().map(|(path, text)| (path.as_str(), text.as_bytes()));
    for (path, bytes) in texts.chain(binary) {
        archive.start_file(path, options)?;
        archive.write_all(bytes)?;
    }
    Ok(archive.finish()?.into_inner())
}

/// Tells whether binary and description are of one model.
fn guid(program: &Program) -> String {
    format!("{{torquewise-{:016x}}}", program.fingerprint)
}

/// Units of the signals: name, and exponents of their base units.
const UNITS: [(&str, &str); 8] = [
    ("rad", r#"rad="1""#),
    ("rad/s", r#"s="-1" rad="1""#),
    ("rad/s2", r#"s="-2" rad="1""#),
    ("N.m", r#"kg="1" m="2" s="-2""#),
    ("kg.m2", r#"kg="1" m="2""#),
    ("kg.m2/s", r#"kg="1" m="2" s="-1""#),
    ("1/(kg.m2)", r#"kg="-1" m="-2""#),
    ("Hz", r#"s="-1""#),
];

fn description(program: &Program, name: &str) -> String {
    let n = program.n_joints();
    let files = format!(
        "    <SourceFiles>\n      <File name=\"{name}.c\"/>\n      \
         <File name=\"{name}_fmu.c\"/>\n    </SourceFiles>\n"
    );
    let units = UNITS.map(|(name, base)| {
        format!("    <Unit name=\"{name}\">\n      <BaseUnit {base}/>\n    </Unit>\n")
    });
    let units = units.concat();
    let (variables, outputs) = variables(program);
    let mut unknowns = String::new();
    // Counted from 1, after four inputs of each joint and the parameter.
    for index in 4 * n + 2..=4 * n + 1 + outputs {
        // Writing to a String cannot fail.
        let _ = writeln!(unknowns, "      <Unknown index=\"{index}\"/>");
    }
    format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<fmiModelDescription fmiVersion=\"2.0\" \
         modelName=\"{name}\" guid=\"{}\"\n  description=\"Torque model of a robot arm\" \
         generationTool=\"torquewise {}\"\n  variableNamingConvention=\"structured\" \
         numberOfEventIndicators=\"0\">\n  <ModelExchange modelIdentifier=\"{name}\">\n{files}  \
         </ModelExchange>\n  <CoSimulation modelIdentifier=\"{name}\" \
         canHandleVariableCommunicationStepSize=\"true\">\n{files}  </CoSimulation>\n  \
         <UnitDefinitions>\n{units}  </UnitDefinitions>\n  <ModelVariables>\n{variables}  \
         </ModelVariables>\n  <ModelStructure>\n    <Outputs>\n{unknowns}    </Outputs>\n    \
         <InitialUnknowns>\n{unknowns}    </InitialUnknowns>\n  </ModelStructure>\n\
         </fmiModelDescription>\n",
        guid(program),
        env!("CARGO_PKG_VERSION"),
    )
}

/// The variables as XML in the order of their value references, and how many are outputs.
fn variables(program: &Program) -> (String, usize) {
    let n = program.n_joints();
    let mut rows: Vec<(String, &str, String)> = Vec::new();
    let of_joint = |joint: usize| format!("joint {}", escaped(&program.joints[joint]));
    for (signal, unit) in [("q", "rad"), ("dq", "rad/s"), ("ddq", "rad/s2"), ("effort", "N.m")] {
        rows.extend((0..n).map(|j| (format!("{signal}[{}]", j + 1), unit, of_joint(j))));
    }
    rows.push(("bandwidth".into(), "Hz", "of external torque".into()));
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
            rows.extend((0..n * n).map(|place| {
                let (i, j) = (place / n, place % n);
                let text = format!("{} by {}", of_joint(i), of_joint(j));
                (format!("{name}[{},{}]", i + 1, j + 1), unit, text)
            }));
        } else {
            rows.extend((0..n).map(|j| (format!("{name}[{}]", j + 1), unit, of_joint(j))));
        }
    }
    rows.extend((0..n).map(|j| (format!("external[{}]", j + 1), "N.m", of_joint(j))));
    let mut text = String::new();
    for (place, (name, unit, description)) in rows.iter().enumerate() {
        let (causality, variability, start) = match place {
            _ if place < 4 * n => ("input", "continuous", " start=\"0\""),
            _ if place == 4 * n => ("parameter", "tunable", " start=\"10\""),
            _ => ("output", "continuous", ""),
        };
        // Writing to a String cannot fail.
        let _ = writeln!(
            text,
            "    <ScalarVariable name=\"{name}\" valueReference=\"{place}\" \
             causality=\"{causality}\" variability=\"{variability}\" description=\"{description}\">\n\
             \x20     <Real unit=\"{unit}\"{start}/>\n    </ScalarVariable>"
        );
    }
    (text, rows.len() - 4 * n - 1)
}

/// Text in which XML finds no tags.
pub(crate) fn escaped(text: &str) -> String {
    let mut escaped = String::new();
    for letter in text.chars() {
        match letter {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            letter if letter.is_control() => escaped.push(' '),
            letter => escaped.push(letter),
        }
    }
    escaped
}
