//! ROS 2 packages checked without ROS: manifest, CMake, C++ against stand-ins.

use crate::models::{energies, remembers};
use crate::run::{self, write};
use std::path::Path;
use std::process::Command;
use torquewise_export::{Program, ros_package};
use torquewise_model::Model;

/// Packages that the node needs, and the headers it includes.
const HEADERS: [(&str, &str); 5] = [
    ("rclcpp", "rclcpp.hpp"),
    ("sensor_msgs", "msg/joint_state.hpp"),
    ("std_msgs", "msg/float64_multi_array.hpp"),
    ("std_msgs", "msg/bool.hpp"),
    ("trajectory_msgs", "msg/joint_trajectory_point.hpp"),
];

/// The package of an arm of that name in `package`, and the headers it needs in `stand_in`.
fn written(folder: &Path, name: &str, model: &Model) {
    let program = Program::of(model).unwrap();
    for (path, text) in ros_package(&program, name).unwrap() {
        write(&folder.join("package").join(path), &text);
    }
    for (package, header) in HEADERS {
        write(&folder.join("stand_in").join(package).join(header), "#include \"ros.hpp\"\n");
    }
    write(&folder.join("stand_in/ros.hpp"), include_str!("ros.hpp"));
}

/// Whether a command can be run here; not every machine that tests has it.
fn can(command: &mut Command) -> bool {
    let can = command.output().is_ok_and(|output| output.status.success());
    if !can {
        eprintln!("skipped: cannot run {command:?}");
    }
    can
}

#[test]
fn the_node_compiles_against_the_names_it_uses() {
    if !run::has("c++") {
        return;
    }
    for model in [energies(3, 25, 1), remembers(energies(3, 25, 1))] {
        let folder = tempfile::tempdir().unwrap();
        written(folder.path(), "arm", &model);

        for node in ["feed_forward", "external_torque"] {
            let mut compiler = Command::new("c++");
            compiler.args(["-std=c++17", "-Wall", "-Wextra", "-Werror", "-fsyntax-only"]);
            compiler.args(["-Istand_in", &format!("package/src/{node}.cpp")]);
            run::output(compiler.current_dir(folder.path()), "");
        }
    }
}

/// As CMake finds an installed package: what it offers is a target of its own name.
fn stand_in_config(package: &str) -> String {
    match package {
        "ament_cmake" => include_str!("ament_cmake.cmake").into(),
        _ => include_str!("stand_in.cmake").replace("PACKAGE", package),
    }
}

#[test]
fn cmake_accepts_the_package_and_compiles_the_node() {
    if !can(Command::new("cmake").arg("--version")) || !run::has("c++") {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    written(folder.path(), "Arm__1", &energies(3, 25, 1));
    for package in HEADERS.iter().map(|(package, _)| *package).chain(["ament_cmake"]) {
        let config = format!("stand_in/{package}/{package}Config.cmake");
        write(&folder.path().join(config), &stand_in_config(package));
    }

    let cmake = |arguments: &[&str]| {
        let mut cmake = Command::new("cmake");
        run::output(cmake.current_dir(folder.path()).args(arguments), "")
    };
    let prefix = format!("-DCMAKE_PREFIX_PATH={}", folder.path().join("stand_in").display());
    let strict = ["-Wdev", "-Werror=dev", "--warn-uninitialized"];
    let of_package = ["-S", "package", "-B", "build", "-G", "Unix Makefiles", &prefix];
    cmake(&[&of_package, &strict[..]].concat());
    // The stand-ins have nothing to link to: the objects are all there can be.
    for object in ["src/feed_forward.o", "src/external_torque.o", "src/Arm__1.o"] {
        cmake(&["--build", "build", "--target", object]);
    }

    let objects = folder.path().join("build/CMakeFiles/feed_forward.dir/src");
    assert!(objects.join("feed_forward.cpp.o").exists() && objects.join("Arm__1.c.o").exists());
}

#[test]
fn the_manifest_is_of_format_3() {
    let mut python = Command::new("python3");
    if !can(python.args(["-c", "import catkin_pkg.package"])) {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    written(folder.path(), "Arm__1", &energies(3, 25, 1));

    // Refuses unknown tags, missing ones and names that ROS does not allow.
    let check = "from catkin_pkg.package import parse_package as parse\nfound = []\n\
                 package = parse('package', warnings=found)\npackage.validate(warnings=found)\n\
                 print(package.package_format, package.name, package.get_build_type(), found)\n";
    let mut python = Command::new("python3");
    let text = run::output(python.current_dir(folder.path()).args(["-c", check]), "");

    assert_eq!(text, "3 arm_1_feed_forward ament_cmake []\n");
}
