//! Gains against least squares solved anew with each column.

use super::{Screen, UNSEEN};
use crate::orthonormal::orthonormal;
use faer::Mat;
use faer::linalg::solvers::SolveLstsq;

const ROWS: usize = 240;
const BLOCKS: [usize; 4] = [60, 50, 70, 60];

fn wave(i: usize, k: usize) -> f64 {
    (0.7 * (i * (k + 1)) as f64 + (k * k) as f64).sin()
}

/// Seven columns of rank six.
fn known() -> Mat<f64> {
    Mat::from_fn(ROWS, 7, |i, j| if j == 6 { wave(i, 1) - wave(i, 2) } else { wave(i, j) })
}

fn response() -> Vec<f64> {
    (0..ROWS).map(|i| wave(i, 0) + 0.3 * wave(i, 40) + 0.1 * wave(i, 11)).collect()
}

/// Three columns of their own, in part what the known ones say, and one that says nothing new.
fn tried() -> Mat<f64> {
    Mat::from_fn(ROWS, 4, |i, j| match j {
        3 => 2.0 * wave(i, 0) + wave(i, 5),
        _ => wave(i, j) + 0.5 * wave(i, [40, 11, 23][j]),
    })
}

/// What plain least squares leaves, column by column of full rank, and its residual on all rows
/// with coefficients from `rows` alone.
fn least_squares(columns: &Mat<f64>, response: &[f64], rows: &[usize]) -> Vec<f64> {
    let part = Mat::from_fn(rows.len(), columns.ncols(), |i, j| columns[(rows[i], j)]);
    let right = Mat::from_fn(rows.len(), 1, |i, _| response[rows[i]]);
    let found = part.col_piv_qr().solve_lstsq(&right);
    let fitted = columns * found;
    (0..ROWS).map(|i| response[i] - fitted[(i, 0)]).collect()
}

fn independent() -> Mat<f64> {
    Mat::from_fn(ROWS, 6, wave)
}

fn with(column: usize) -> Mat<f64> {
    let (known, tried) = (independent(), tried());
    Mat::from_fn(ROWS, 7, |i, j| if j < 6 { known[(i, j)] } else { tried[(i, column)] })
}

fn squares(x: &[f64]) -> f64 {
    x.iter().map(|x| x * x).sum()
}

fn screen() -> Screen {
    Screen::new(known(), &response(), &BLOCKS).unwrap()
}

#[test]
fn a_share_is_what_least_squares_gains_with_the_column() {
    let all: Vec<usize> = (0..ROWS).collect();
    let before = squares(&least_squares(&independent(), &response(), &all));

    let gains = screen().gains(tried().as_ref()).unwrap();

    for (column, gain) in gains.iter().enumerate().take(3) {
        let after = squares(&least_squares(&with(column), &response(), &all));
        let expected = 1.0 - after / before;
        // Two residuals by other ways, a dozen digits each.
        assert!((gain.share - expected).abs() < 1e-11, "{column}: {} {expected}", gain.share);
    }
    assert!(gains[0].share > 0.5, "the response holds this one: {}", gains[0].share);
}

#[test]
fn a_column_in_the_span_gains_nothing() {
    let gain = &screen().gains(tried().as_ref()).unwrap()[3];

    assert!(gain.share <= 0.0);
    assert!(gain.without.iter().all(|share| *share == 0.0));
}

#[test]
fn shares_without_a_block_are_those_of_the_other_rows() {
    let gains = screen().gains(tried().as_ref()).unwrap();

    let mut start = 0;
    for (block, rows) in BLOCKS.iter().enumerate() {
        let others: Vec<usize> = (0..ROWS).filter(|i| !(start..start + rows).contains(i)).collect();
        start += rows;
        let seen = |left: Vec<f64>| others.iter().map(|&i| left[i] * left[i]).sum::<f64>();
        let before = seen(least_squares(&independent(), &response(), &others));
        for (column, gain) in gains.iter().enumerate().take(3) {
            let after = seen(least_squares(&with(column), &response(), &others));
            let expected = 1.0 - after / before;
            // What UNSEEN holds back of coefficients.
            let tolerance = 10.0 * UNSEEN;
            let found = gain.without[block];
            assert!((found - expected).abs() < tolerance, "{block} {column}: {found} {expected}");
        }
    }
}

#[test]
fn what_is_left_is_the_residual_of_least_squares() {
    let screen = screen();
    let all: Vec<usize> = (0..ROWS).collect();

    let [before, after] = screen.left(tried().col_as_slice(1), None).unwrap();

    let expected = [
        least_squares(&independent(), &response(), &all),
        least_squares(&with(1), &response(), &all),
    ];
    for (found, expected) in [before, after].iter().zip(&expected) {
        for (a, b) in found.iter().zip(expected) {
            assert!((a - b).abs() < 1e-12, "{a} {b}");
        }
    }
}

#[test]
fn what_is_left_of_a_block_is_predicted_by_the_others() {
    let screen = screen();
    let held = screen.blocks()[2].clone();
    let others: Vec<usize> = (0..ROWS).filter(|i| !held.contains(i)).collect();

    let [before, after] = screen.left(tried().col_as_slice(0), Some(2)).unwrap();

    let expected = [
        least_squares(&independent(), &response(), &others),
        least_squares(&with(0), &response(), &others),
    ];
    for (found, expected) in [before, after].iter().zip(&expected) {
        for row in held.clone() {
            // What UNSEEN holds back of coefficients.
            let (a, b) = (found[row], expected[row]);
            assert!((a - b).abs() < 5.0 * UNSEEN, "{row}: {a} {b}");
        }
    }
}

#[test]
fn shapes_and_numbers_are_checked() {
    assert!(Screen::new(known(), &response()[1..], &BLOCKS).is_err());
    assert!(Screen::new(known(), &response(), &[10, 20]).is_err());
    let mut bad = response();
    bad[3] = f64::NAN;
    assert!(Screen::new(known(), &bad, &BLOCKS).is_err());
    assert!(screen().gains(Mat::zeros(3, 1).as_ref()).is_err());
    assert!(screen().left(&response(), Some(4)).is_err());
}

#[test]
fn a_response_that_is_explained_leaves_nothing_to_gain() {
    let response: Vec<f64> = (0..ROWS).map(|_| 0.0).collect();
    let screen = Screen::new(known(), &response, &BLOCKS).unwrap();

    let gains = screen.gains(tried().as_ref()).unwrap();

    assert!(gains.iter().all(|gain| gain.share == 0.0));
    assert_eq!(orthonormal(known()).ncols(), screen.rank());
}
