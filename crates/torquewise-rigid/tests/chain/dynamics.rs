//! Masses at a known geometry; the best chains are found first.

use crate::twins::{arm, drawn, errors, largest, rows, sines};
use torquewise_rigid::search::UNWATCHED;
use torquewise_rigid::{Chain, Geometry, Search, refine, search};
use torquewise_sim::Arm;

#[test]
fn masses_fitted_at_the_true_geometry_leave_nothing_and_at_a_wrong_one_something() {
    for n in [3, 5] {
        let truth = drawn(n, 20 + n as u64);
        let [rows, test] =
            [(20.0, 3), (10.0, 4)].map(|(s, seed)| rows(&sines(&arm(&truth), s, seed)));
        let search = |ridge| Search { ridge, rounds: 0, ..Search::default() };
        let mut wrong = truth.clone();
        let mut parameters = wrong.geometry.parameters().to_vec();
        parameters[2] += 0.05;
        wrong.geometry = Geometry::new(&parameters).unwrap();

        let found = refine(&rows, &truth, &[], &search(1e-14), UNWATCHED).unwrap();
        let astray = refine(&rows, &wrong, &[], &search(1e-4), UNWATCHED).unwrap();

        assert_eq!(found.geometry, truth.geometry);
        let left = errors(&found, &test);
        assert!(largest(&left) < 1e-9, "{n} joints: {left:?}");
        assert!(largest(&errors(&astray, &rows)) > 1e-3, "{n} joints");
    }
}

#[test]
fn chains_come_best_first() {
    let arm = Arm::builtin("puma560-3").unwrap();
    let rows = rows(&sines(&arm, 10.0, 1));
    // Few rounds leave some starts behind.
    let plan = Search { starts: 4, rounds: 2, weighings: 1, ..Search::default() };

    let found = search(&rows, &plan, UNWATCHED).unwrap().chains;

    let score = |chain: &Chain| -> f64 { chain.residual_rms.iter().map(|rms| rms.ln()).sum() };
    let scores: Vec<f64> = found.iter().map(score).collect();
    assert_eq!(found.len(), 4);
    assert!(scores.is_sorted(), "{scores:?}");
}

#[test]
fn an_arm_whose_first_axis_points_down_and_its_upright_mirror_image_need_the_same_torque() {
    let mut down = drawn(4, 3);
    let mut parameters = down.geometry.parameters().to_vec();
    parameters[..2].copy_from_slice(&[3.0, 0.3]);
    down.geometry = Geometry::new(&parameters).unwrap();
    let rows = rows(&sines(&arm(&down), 10.0, 1));

    let up = down.clone().upright();

    assert!(down.geometry.gravity()[2] > 9.0 && up.geometry.gravity()[2] < -9.0);
    assert!(largest(&errors(&up, &rows)) < 1e-12);
    assert_eq!(up.clone().upright().geometry, up.geometry);
}
