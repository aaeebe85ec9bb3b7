//! A ROS 2 package: a feed-forward node, and one that publishes external torque.

use crate::c::{check_name, inclusion};
use crate::{Precision, Program, Result, filled, to_c};
use minijinja::context;

/// The files of the package: path within it and text.
///
/// The node `feed_forward` reads `joint_states` and `~/reference`, adds to the torque of the
/// desired motion a proportional and a derivative correction, bounds it and publishes it to
/// `effort_controller/commands`, where `effort_controllers/JointGroupEffortController` listens.
/// The node `external_torque` reads `joint_states` with effort and publishes what others put on the
/// joints to `~/external_torque`, and whether it is above thresholds to `~/contact`.
///
/// # Errors
/// `ExportError::Name` if the name is no C identifier.
pub fn ros_package(program: &Program, name: &str) -> Result<Vec<(String, String)>> {
    check_name(name)?;
    // What ROS allows: lower case, and no two underscores in a row.
    let package = format!("{}_feed_forward", name.to_lowercase().trim_end_matches('_'));
    let package = package.split('_').filter(|part| !part.is_empty()).collect::<Vec<_>>().join("_");
    let file = |template: &str| {
        filled(
            "code",
            template,
            context! {
                package => package.as_str(),
                name,
                version => program.version(),
                inclusion => inclusion(program, name),
                upper => name.to_uppercase(),
                zeros => vec!["0.0"; program.n_joints()],
                depends => DEPENDS,
            },
        )
    };
    let head = file(NODE)?;
    let manifest = context! { package => package.as_str(), depends => DEPENDS };
    let manifest = filled("xml", include_str!("templates/package.xml.j2"), manifest)?;
    Ok(vec![
        ("package.xml".into(), manifest),
        ("CMakeLists.txt".into(), file(include_str!("templates/CMakeLists.txt.j2"))?),
        ("config/feed_forward.yaml".into(), file(include_str!("templates/feed_forward.yaml.j2"))?),
        (format!("src/{name}.c"), to_c(program, name, Precision::Double)?),
        (
            "config/external_torque.yaml".into(),
            file(include_str!("templates/external_torque.yaml.j2"))?,
        ),
        ("src/feed_forward.cpp".into(), head.clone() + include_str!("assets/feed_forward.cpp")),
        ("src/external_torque.cpp".into(), head + include_str!("assets/external_torque.cpp")),
    ])
}

const NODE: &str = "// {{ version }}\n\n{{ inclusion }}constexpr int N = {{ upper }}_JOINTS;\n\n";

const DEPENDS: [&str; 4] = ["rclcpp", "sensor_msgs", "std_msgs", "trajectory_msgs"];
