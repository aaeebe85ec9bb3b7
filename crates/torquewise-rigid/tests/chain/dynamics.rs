//! The power of a chain goes nowhere; the best chains are found first.

use crate::twins::{arm, drawn, errors, largest, rows, sines};
use faer::Mat;
use torquewise_rigid::search::UNWATCHED;
use torquewise_rigid::{Chain, Geometry, Rows, Search, fit, search};
use torquewise_sim::Arm;

#[test]
fn masses_fitted_at_the_true_geometry_leave_nothing_and_at_a_wrong_one_something() {
    for n in [3, 5] {
        let truth = drawn(n, 20 + n as u64);
        let [rows, test] =
            [(20.0, 3), (10.0, 4)].map(|(s, seed)| rows(&sines(&arm(&truth), s, seed)));
        let search = Search { ridge: 1e-14, ..Search::default() };
        let mut wrong = truth.clone();
        let mut parameters = wrong.geometry.parameters().to_vec();
        parameters[2] += 0.05;
        wrong.geometry = Geometry::new(&parameters).unwrap();

        let found = fit(&rows, &truth, &search).unwrap();
        let astray = fit(&rows, &wrong, &Search::default()).unwrap();

        assert_eq!(found.geometry, truth.geometry);
        let left = errors(&found, &test);
        assert!(largest(&left) < 1e-9, "{n} joints: {left:?}");
        assert!(largest(&errors(&astray, &rows)) > 1e-3, "{n} joints");
    }
}

/// The joints go around and come back with the speed they had: what they took they gave back.
#[test]
fn the_work_of_a_closed_motion_is_zero() {
    let (n, m) = (4, 400);
    let chain = drawn(n, 9);
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

#[test]
fn chains_come_best_first() {
    let arm = Arm::builtin("puma560-3").unwrap();
    let rows = rows(&sines(&arm, 10.0, 1));
    // Few rounds leave some starts behind.
    let plan = Search { starts: 4, finalists: 4, rounds: 2, weighings: 1, ..Search::default() };

    let found = search(&rows, &plan, UNWATCHED).unwrap().chains;

    let score = |chain: &Chain| -> f64 { chain.residual_rms.iter().map(|rms| rms.ln()).sum() };
    let scores: Vec<f64> = found.iter().map(score).collect();
    assert_eq!(found.len(), 4);
    assert!(scores.is_sorted(), "{scores:?}");
}
