//! A model as code: every target is written, what is refused leaves nothing behind.

use crate::terminal::Terminal;

#[test]
fn every_target_is_written_and_named() {
    let terminal = Terminal::with_model();

    for (target, file, sign) in [
        ("c", "arm.c", "void arm_torque("),
        ("c --precision float", "my-arm.h", "void my_arm_torque(const float q[2]"),
        ("rust", "arm.rs", "pub fn torque<F: Math>("),
        ("python", "arm.py", "def torque(q, dq, ddq):"),
        ("latex", "arm.tex", r"\end{document}"),
    ] {
        terminal.done(&format!("export model.json --to {target} -o {file}"));
        assert!(terminal.read(file).contains(sign), "{target}");
    }
    terminal.done("export model.json --to fmu --no-binary -o arm.fmu");
    terminal.done("export model.json --to ros2 -o package --name arm");
    assert!(terminal.read("package/package.xml").contains("<name>arm_feed_forward</name>"));
}

#[test]
fn test_vectors_lie_beside_the_code() {
    let terminal = Terminal::with_model();

    let said = terminal.json("export model.json --to c -o arm.c --test-vectors");

    assert_eq!(said["test_vectors"], "arm.vectors.csv");
    assert_eq!(terminal.read("arm.vectors.csv").lines().count(), 1001);
    assert!(said["costs"]["torque"]["operations"].as_u64().unwrap() > 0);
}

#[test]
fn what_cannot_be_exported_is_refused() {
    let terminal = Terminal::with_model();
    terminal.done("export model.json --to ros2 -o package --name arm");

    for (line, code) in [
        ("export model.json --to ada -o arm.adb", 2),
        ("export model.json --to python -o arm.py --precision float", 2),
        ("export model.json --to rust -o arm.rs --name arm", 2),
        ("export model.json --to c -o arm.c --no-binary", 2),
        ("export model.json --to c -o arm.py", 1),
        ("export model.json --to c -o arm.c --name 3arm", 1),
        ("export model.json --to ros2 -o package", 1),
        ("export model.json --to c -o arm.c --reversal -1", 2),
        ("export model.json --to c -o arm.c --reversal wide", 2),
        ("export missing.json --to c -o arm.c", 1),
    ] {
        terminal.fails(code, line, &[]);
    }
}
