//! A log written by another program is read to the numbers that stand in it.

use std::path::PathBuf;
use torquewise_logs::Logs;

/// The folder of reference values, or why the test is skipped.
fn shared() -> Option<PathBuf> {
    let default = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared");
    let folder = std::env::var_os("TORQUEWISE_SHARED").map_or(default.into(), PathBuf::from);
    if folder.is_dir() {
        return Some(folder);
    }
    let required = std::env::var("TORQUEWISE_SHARED_REQUIRED").is_ok_and(|value| value == "1");
    assert!(!required, "{} does not exist", folder.display());
    println!("skipped: {} does not exist", folder.display());
    None
}

#[test]
fn oracle_states_of_the_reference_arm_are_read_as_they_stand() {
    let Some(folder) = shared() else { return };
    let logs = Logs::open(&[folder.join("oracle/puma560-3.csv")]).unwrap();

    let parts = logs.read_all().unwrap();

    assert_eq!(
        (parts.len(), parts[0].n_rows(), parts[0].n_joints()),
        (1, 500, 3)
    );
    let first = &parts[0];
    assert_eq!(
        first.q()[(0, 0)].to_bits(),
        0.86055566142468631_f64.to_bits()
    );
    assert_eq!(
        first.ddq()[(0, 2)].to_bits(),
        (-3.2641171990746676_f64).to_bits()
    );
    assert_eq!(
        first.require_tau().unwrap()[(0, 1)].to_bits(),
        4.4826808173109569_f64.to_bits()
    );
}
