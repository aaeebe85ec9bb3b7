//! From program to sources of a ROS 2 package: a node that feeds the torque of a desired motion
//! forward.

use crate::c::{check_name, inclusion, to_c};
use crate::error::ExportError;
use crate::program::{Precision, Program};

const NODE: &str = include_str!("assets/feed_forward.cpp");

/// The files of the package: path within it and text.
///
/// The node `feed_forward` reads `joint_states` and `~/reference`, adds to the torque of the
/// desired motion a proportional and a derivative correction, bounds it and publishes it to
/// `effort_controller/commands`, where `effort_controllers/JointGroupEffortController` listens.
///
/// # Errors
/// [`ExportError::Name`] if the name is no C identifier.
pub fn ros_package(program: &Program, name: &str) -> Result<Vec<(String, String)>, ExportError> {
    check_name(name)?;
    // What ROS allows: lower case, and no two underscores in a row.
    let package = format!("{}_feed_forward", name.to_lowercase().trim_end_matches('_'));
    let package = package.split('_').filter(|part| !part.is_empty()).collect::<Vec<_>>().join("_");
    let n = program.n_joints();
    let node = format!(
        "// {}\n\n{}constexpr int N = {}_JOINTS;\n\n{NODE}",
        program.version(),
        inclusion(program, name),
        name.to_uppercase(),
    );
    let zeros = vec!["0.0"; n].join(", ");
    let parameters = format!(
        "feed_forward:\n  ros__parameters:\n    # N m per joint; the node does not start without.\n\
         \x20   max_effort: [{zeros}]\n    # N m/rad and N m s/rad.\n\
         \x20   kp: [{zeros}]\n    kd: [{zeros}]\n    \
         # Gravity of the first step alone.\n    gravity_only: false\n"
    );
    Ok(vec![
        ("package.xml".into(), manifest(&package)),
        ("CMakeLists.txt".into(), build(&package, name)),
        ("config/feed_forward.yaml".into(), parameters),
        (format!("src/{name}.c"), to_c(program, name, Precision::Double)?),
        ("src/feed_forward.cpp".into(), node),
    ])
}

const DEPENDS: [&str; 4] = ["rclcpp", "sensor_msgs", "std_msgs", "trajectory_msgs"];

fn manifest(package: &str) -> String {
    let depends = DEPENDS.map(|name| format!("  <depend>{name}</depend>\n")).concat();
    format!(
        "<?xml version=\"1.0\"?>\n<package format=\"3\">\n  <name>{package}</name>\n  \
         <version>0.1.0</version>\n  \
         <description>Torque of a desired motion, by a reconstructed model</description>\n  \
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
         add_executable(feed_forward src/feed_forward.cpp src/{name}.c)\n\
         target_include_directories(feed_forward PRIVATE src)\n\
         target_link_libraries(feed_forward m rclcpp::rclcpp{targets})\n\n\
         install(TARGETS feed_forward DESTINATION lib/${{PROJECT_NAME}})\n\
         install(DIRECTORY config DESTINATION share/${{PROJECT_NAME}})\n\n\
         ament_package()\n"
    )
}
