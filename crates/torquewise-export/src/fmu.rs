//! From program to FMU: an FMI 2.0 unit for model exchange and co-simulation, sources and binary.

use crate::c::{check_name, inclusion, quoted, to_c};
use crate::error::ExportError;
use crate::program::{Precision, Program, Quantity};
use crate::xml::Xml;
use std::io::{Cursor, Write};
use std::ops::Range;
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
const UNITS: [(&str, &[(&str, &str)]); 8] = [
    ("rad", &[("rad", "1")]),
    ("rad/s", &[("s", "-1"), ("rad", "1")]),
    ("rad/s2", &[("s", "-2"), ("rad", "1")]),
    ("N.m", &[("kg", "1"), ("m", "2"), ("s", "-2")]),
    ("kg.m2", &[("kg", "1"), ("m", "2")]),
    ("kg.m2/s", &[("kg", "1"), ("m", "2"), ("s", "-1")]),
    ("1/(kg.m2)", &[("kg", "-1"), ("m", "-2")]),
    ("Hz", &[("s", "-1")]),
];

fn description(program: &Program, name: &str) -> Result<String, ExportError> {
    let mut xml = Xml::new();
    xml.open(
        "fmiModelDescription",
        &[
            ("fmiVersion", "2.0"),
            ("modelName", name),
            ("guid", &guid(program)),
            ("description", "Torque model of a robot arm"),
            ("generationTool", concat!("torquewise ", env!("CARGO_PKG_VERSION"))),
            ("variableNamingConvention", "structured"),
            ("numberOfEventIndicators", "0"),
        ],
    );
    let identifier = ("modelIdentifier", name);
    let kinds: [(&str, &[(&str, &str)]); 2] = [
        ("ModelExchange", &[identifier]),
        ("CoSimulation", &[identifier, ("canHandleVariableCommunicationStepSize", "true")]),
    ];
    for (kind, attributes) in kinds {
        xml.open(kind, attributes);
        xml.open("SourceFiles", &[]);
        xml.leaf("File", &[("name", &format!("{name}.c"))]);
        xml.leaf("File", &[("name", &format!("{name}_fmu.c"))]);
        xml.close("SourceFiles");
        xml.close(kind);
    }
    xml.open("UnitDefinitions", &[]);
    for (unit, base) in UNITS {
        xml.open("Unit", &[("name", unit)]);
        xml.leaf("BaseUnit", base);
        xml.close("Unit");
    }
    xml.close("UnitDefinitions");
    let outputs = variables(program, &mut xml);
    xml.open("ModelStructure", &[]);
    for list in ["Outputs", "InitialUnknowns"] {
        xml.open(list, &[]);
        for index in outputs.clone() {
            // Counted from 1.
            xml.leaf("Unknown", &[("index", &(index + 1).to_string())]);
        }
        xml.close(list);
    }
    xml.close("ModelStructure");
    xml.close("fmiModelDescription");
    xml.finish()
}

/// Writes the variables in the order of their value references; which are outputs.
fn variables(program: &Program, xml: &mut Xml) -> Range<usize> {
    let n = program.n_joints();
    let mut rows: Vec<(String, &str, String)> = Vec::new();
    let of_joint = |joint: usize| format!("joint {}", program.joints[joint]);
    let vector = |name: &str, unit: &'static str| -> Vec<(String, &str, String)> {
        (0..n).map(|j| (format!("{name}[{}]", j + 1), unit, of_joint(j))).collect()
    };
    for (signal, unit) in [("q", "rad"), ("dq", "rad/s"), ("ddq", "rad/s2"), ("effort", "N.m")] {
        rows.extend(vector(signal, unit));
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
            rows.extend(vector(name, unit));
        }
    }
    rows.extend(vector("external", "N.m"));
    xml.open("ModelVariables", &[]);
    for (place, (name, unit, description)) in rows.iter().enumerate() {
        let (causality, variability, start) = match place {
            _ if place < 4 * n => ("input", "continuous", Some(("start", "0"))),
            _ if place == 4 * n => ("parameter", "tunable", Some(("start", "10"))),
            _ => ("output", "continuous", None),
        };
        xml.open(
            "ScalarVariable",
            &[
                ("name", name),
                ("valueReference", &place.to_string()),
                ("causality", causality),
                ("variability", variability),
                ("description", description),
            ],
        );
        xml.leaf("Real", &[("unit", *unit)].into_iter().chain(start).collect::<Vec<_>>());
        xml.close("ScalarVariable");
    }
    xml.close("ModelVariables");
    4 * n + 1..rows.len()
}
