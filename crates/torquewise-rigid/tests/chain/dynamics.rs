//! The torque of a chain is that of the arm, and its power goes nowhere.

use crate::twins::{arm, chain, drawn, errors, largest, puma, rows, sines};
use faer::Mat;
use torquewise_rigid::{Geometry, Rows, Search, fit};

const DOWN: [f64; 3] = [0.0, 0.0, -9.81];

#[test]
fn arms_at_all_angles_are_chains() {
    let drawn = (0..12).map(|seed| drawn(1 + seed % 6, seed as u64));
    for links in drawn.chain([puma()]) {
        let chain = chain(&links, [0.4, -0.7]);
        let motion = sines(&arm(&links, chain.geometry.gravity()), 4.0, 2);

        let errors = errors(&chain, &rows(&motion));

        assert!(largest(&errors) < 1e-11, "{} joints: {errors:?}", links.len());
    }
}

#[test]
fn masses_fitted_at_the_true_geometry_leave_nothing() {
    for n in [3, 5] {
        let links = drawn(n, 20 + n as u64);
        let arm = arm(&links, DOWN);
        let truth = chain(&links, [0.0; 2]);
        let search = Search { ridge: 1e-14, ..Search::default() };

        let found = fit(&rows(&sines(&arm, 20.0, 3)), &truth, &search).unwrap();

        assert_eq!(found.geometry, truth.geometry);
        let errors = errors(&found, &rows(&sines(&arm, 10.0, 4)));
        assert!(largest(&errors) < 1e-9, "{n} joints: {errors:?}");
    }
}

#[test]
fn a_wrong_geometry_leaves_something() {
    let arm = arm(&puma(), DOWN);
    let rows = rows(&sines(&arm, 20.0, 3));
    let mut wrong = chain(&puma(), [0.0; 2]);
    let mut parameters = wrong.geometry.parameters().to_vec();
    parameters[2] += 0.05;
    wrong.geometry = Geometry::new(&parameters).unwrap();

    let found = fit(&rows, &wrong, &Search::default()).unwrap();

    assert!(largest(&errors(&found, &rows)) > 1e-3);
}

/// The joints go around and come back with the speed they had: what they took they gave back.
#[test]
fn the_work_of_a_closed_motion_is_zero() {
    let (n, m) = (4, 400);
    let chain = chain(&drawn(n, 9), [0.3, 0.2]);
    let angle = |row: usize, joint: usize| {
        let turn = std::f64::consts::TAU * row as f64 / m as f64;
        ((joint % 3 + 1) as f64, turn, joint as f64)
    };
    let signal = |of: fn(f64, f64) -> f64| {
        Mat::from_fn(m, n, |row, joint| {
            let (rate, turn, phase) = angle(row, joint);
            of(rate, rate * turn + phase)
        })
    };
    let q = signal(|_, x| x.sin());
    let dq = signal(|rate, x| rate * x.cos());
    let ddq = signal(|rate, x| -rate * rate * x.sin());
    let none = vec![Mat::zeros(m, 0); n];
    let rows = Rows::new([q.as_ref(), dq.as_ref(), ddq.as_ref(), q.as_ref()], &none).unwrap();

    let torque = chain.torque(&rows);

    let power = |row: usize| -> f64 { (0..n).map(|j| torque[j * m + row] * dq[(row, j)]).sum() };
    // The sum over the rows of a smooth periodic motion is the integral to the last digits.
    let work: f64 = (0..m).map(power).sum();
    let moved: f64 = (0..m).map(|row| power(row).abs()).sum();
    assert!(work.abs() < 1e-11 * moved, "{work} of {moved}");
}
