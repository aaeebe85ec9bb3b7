//! What a torque figure shows and what it refuses.

use crate::error::ReportError;
use crate::torque::torque_figure;
use faer::Mat;

fn joints() -> Vec<String> {
    vec!["hip".to_owned(), "knee <3>".to_owned()]
}

fn wave(rows: usize, size: f64) -> (Vec<f64>, Mat<f64>) {
    let t: Vec<f64> = (0..rows).map(|row| 0.01 * row as f64).collect();
    let tau = Mat::from_fn(rows, 2, |row, joint| size * (t[row] * (1.0 + joint as f64)).sin());
    (t, tau)
}

#[test]
fn a_figure_names_every_joint_curve_and_unit() {
    let (t, tau) = wave(500, 10.0);
    let predicted = faer::Scale(1.01) * &tau;

    let predictions = [("energy", predicted.as_ref())];
    let svg = torque_figure("Title", &joints(), &t, tau.as_ref(), &predictions).unwrap();

    for words in ["Title", "hip", "measured", "energy", "torque [N·m]", "time [s]", "sans-serif"] {
        assert!(svg.contains(words), "{words}");
    }
    assert!(svg.contains("knee &lt;3&gt;"), "markup in a name is escaped");
    assert!(svg.trim_end().ends_with("</svg>"));
}

#[test]
fn a_prediction_that_runs_away_stays_in_its_panel() {
    let (t, tau) = wave(500, 1.0);
    let wild = faer::Scale(1e6) * &tau;

    let predictions = [("wild", wild.as_ref())];
    let svg = torque_figure("Title", &joints(), &t, tau.as_ref(), &predictions).unwrap();

    let points = svg.split("points=\"").skip(1).filter_map(|rest| rest.split('"').next());
    let heights: Vec<f64> = points
        .flat_map(|points| points.split_whitespace())
        .filter_map(|point| point.split(',').nth(1)?.parse().ok())
        .collect();
    assert!(heights.len() > 500);
    let page = svg.split("viewBox=\"0 0 2000 ").nth(1).unwrap();
    let height: f64 = page.split('"').next().unwrap().parse().unwrap();
    assert!(heights.iter().all(|at| (0.0..height).contains(at)));
}

#[test]
fn a_million_rows_make_a_small_figure() {
    let (t, tau) = wave(1_000_000, 1.0);

    let svg = torque_figure("Title", &joints(), &t, tau.as_ref(), &[]).unwrap();

    assert!(svg.len() < 200_000, "{} bytes", svg.len());
}

#[test]
fn a_torque_that_never_changes_is_drawn() {
    let t = [0.0, 1.0];
    let tau = Mat::from_fn(2, 2, |_, _| 3.0);

    assert!(torque_figure("Title", &joints(), &t, tau.as_ref(), &[]).is_ok());
}

#[test]
fn signals_that_are_no_motion_are_refused() {
    let (t, tau) = wave(10, 1.0);
    let draw = |t: &[f64], tau: &Mat<f64>, other: &Mat<f64>| {
        torque_figure("Title", &joints(), t, tau.as_ref(), &[("other", other.as_ref())])
    };
    let (short, mut broken) = (Mat::zeros(9, 2), tau.clone());
    broken[(4, 1)] = f64::NAN;
    let mut backward = t.clone();
    backward.swap(3, 4);

    assert!(matches!(draw(&t, &short, &tau), Err(ReportError::Shape { rows: 9, .. })));
    assert!(matches!(draw(&t, &tau, &short), Err(ReportError::Shape { rows: 9, .. })));
    let refused = draw(&t, &tau, &broken);
    assert_eq!(refused, Err(ReportError::NotFinite { signal: "other".into(), row: 4 }));
    assert_eq!(draw(&backward, &tau, &tau), Err(ReportError::TimeOrder { row: 4 }));
    let none = torque_figure("Title", &[], &t, tau.as_ref(), &[]);
    assert_eq!(none, Err(ReportError::Empty { rows: 10, joints: 0 }));
}
