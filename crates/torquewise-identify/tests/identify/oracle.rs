//! From torques computed by Pinocchio to the energy library spans them exactly (E4).

#![expect(clippy::unwrap_used, reason = "a test may panic")]

use crate::support::{fit, percent};
use faer::Mat;
use std::path::PathBuf;
use torquewise_identify::Plan;
use torquewise_motion::{Motion, Signals};

/// The oracle file of an arm, or `None` where the shared folder is not there and need not be.
fn oracle(name: &str) -> Option<String> {
    let drive = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared");
    let shared = std::env::var_os("TORQUEWISE_SHARED").map_or_else(|| drive.into(), PathBuf::from);
    let path = shared.join("oracle").join(name);
    match std::fs::read_to_string(&path) {
        Ok(text) => Some(text),
        Err(error) if std::env::var_os("TORQUEWISE_SHARED_REQUIRED").is_some() => {
            panic!("{}: {error}", path.display())
        }
        Err(_) => {
            eprintln!("skipped: {} is not there", path.display());
            None
        }
    }
}

/// Every row of a file whose index has the given remainder modulo 2.
fn half(text: &str, n: usize, remainder: usize) -> Motion {
    let rows: Vec<Vec<f64>> = text
        .lines()
        .skip(1)
        .map(|line| line.split(',').map(|field| field.parse().unwrap()).collect())
        .enumerate()
        .filter_map(|(row, values)| (row % 2 == remainder).then_some(values))
        .collect();
    let signal = |first: usize| Mat::from_fn(rows.len(), n, |row, j| rows[row][1 + first * n + j]);
    Motion::new(Signals {
        joints: (1..=n).map(|joint| format!("joint{joint}")).collect(),
        t: rows.iter().map(|row| row[0]).collect(),
        q: signal(0),
        dq: signal(1),
        ddq: signal(2),
        tau: Some(signal(3)),
    })
    .unwrap()
}

#[test]
fn random_states_of_the_reference_arm_predict_held_out_states() {
    let Some(text) = oracle("puma560-3.csv") else { return };
    let (train, test) = (half(&text, 3, 0), half(&text, 3, 1));

    let found = fit(&train, &Plan::default());

    let errors = percent(&found.model, &test);
    assert_eq!(found.model.form.n_coefficients(), 23);
    assert!(errors.iter().all(|&percent| percent < 1e-7), "{errors:?}");
}
