//! From program to sources of a ROS 2 package: a node that feeds the torque of a desired motion
//! forward, and one that publishes external torque.

use crate::c::{check_name, inclusion, to_c};
use crate::error::ExportError;
use crate::program::{Precision, Program};

const FEED_FORWARD: &str = include_str!("assets/feed_forward.cpp");
const EXTERNAL_TORQUE: &str = include_str!("assets/external_torque.cpp");

/// The files of the package: path within it and text.
///
/// The node `feed_forward` reads `joint_states` and `~/reference`, adds to the torque of the
/// desired motion a proportional and a derivative correction, bounds it and publishes it to
/// `effort_controller/commands`, where `effort_controllers/JointGroupEffortController` listens.
/// The node `external_torque` reads `joint_states` with effort and publishes what others put on the
/// joints to `~/external_torque`, and whether it is above thresholds to `~/contact`.
///
/// # Errors
/// [`ExportError::Name`] if the name is no C identifier.
pub fn ros_package(program: &Program, name: &str) -> Result<Vec<(String, String)>, ExportError> {
    check_name(name)?;
    // What ROS allows: lower case, and no two underscores in a row.
    let package = format!("{}_feed_forward", name.to_lowercase().trim_end_matches('_'));
    let package = package.split('_').filter(|part| !part.is_empty()).collect::<Vec<_>>().join("_");
    let n = program.n_joints();
    let node = |source: &str| {
        format!(
            "// {}\n\n{}constexpr int N = {}_JOINTS;\n\n{source}",
            program.version(),
            inclusion(program, name),
            name.to_uppercase(),
        )
    };
    let zeros = vec!["0.0"; n].join(", ");
    let parameters = format!(
        "feed_forward:\n  ros__parameters:\n    # N m per joint; the node does not start without.\n\
         \x20   max_effort: [{zeros}]\n    # N m/rad and N m s/rad.\n\
         \x20   kp: [{zeros}]\n    kd: [{zeros}]\n    \
         # Gravity of the first step alone.\n    gravity_only: false\n"
    );
    let external = format!(
        "external_torque:\n  ros__parameters:\n    # Hz\n    bandwidth: 10.0\n    \
         # N m per joint, 0 for none: `torquewise residuals` prints them.\n    \
         thresholds: [{zeros}]\n    \
         # s between joint states after which the observer starts anew.\n    longest_gap: 0.1\n"
    );
    Ok(vec![
        ("package.xml".into(), manifest(&package)),
        ("CMakeLists.txt".into(), build(&package, name)),
        ("config/feed_forward.yaml".into(), parameters),
        (format!("src/{name}.c"), to_c(program, name, Precision::Double)?),
        ("config/external_torque.yaml".into(), external),
        ("src/feed_forward.cpp".into(), node(FEED_FORWARD)),
        ("src/external_torque.cpp".into(), node(EXTERNAL_TORQUE)),
    ])
}

const DEPENDS: [&str; 4] = ["rclcpp", "sensor_msgs", "std_msgs", "trajectory_msgs"];

fn manifest(package: &str) -> String {
    let depends = DEPENDS.map(|name| format!("  <depend>{name}</depend>\n")).concat();
    format!(
        "<?xml version=\"1.0\"?>\n<package format=\"3\">\n  <name>{package}</name>\n  \
         <version>0.1.0</version>\n  \
         <description>Torque of a desired motion, and external torque, by a reconstructed \
         model</description>\n  \
         <maintainer email=\"you@example.com\">you</maintainer>\n  \
         <license>Proprietary</license>\n  <buildtool_depend>ament_cmake</buildtool_depend>\n\
         {depends}  <exec_depend>effort_controllers</exec_depend>\n  <export>\n    \
         <build_type>ament_cmake</build_type>\n  </export>\n</package>\n"
    )
}

fn build(package: &str, name: &str) -> String {
    let find = DEPENDS.map(|name| format!("find_package({name} REQUIRED)\n")).concat();
    let messages = DEPENDS.iter().filter(|name| name.ends_with("_msgs"));
    let targets: Vec<String> = messages.map(|name| format!(" ${{{name}_TARGETS}}")).collect();
    let targets = targets.concat();
    format!(
        "cmake_minimum_required(VERSION 3.16)\nproject({package} C CXX)\n\n\
         set(CMAKE_C_STANDARD 99)\nset(CMAKE_CXX_STANDARD 17)\n\
         if(NOT CMAKE_BUILD_TYPE)\n  set(CMAKE_BUILD_TYPE Release)\nendif()\n\n\
         find_package(ament_cmake REQUIRED)\n{find}\n\
         foreach(node feed_forward external_torque)\n  \
         add_executable(${{node}} src/${{node}}.cpp src/{name}.c)\n  \
         target_include_directories(${{node}} PRIVATE src)\n  \
         target_link_libraries(${{node}} m rclcpp::rclcpp{targets})\nendforeach()\n\n\
         install(TARGETS feed_forward external_torque DESTINATION lib/${{PROJECT_NAME}})\n\
         install(DIRECTORY config DESTINATION share/${{PROJECT_NAME}})\n\n\
         ament_package()\n"
    )
}
