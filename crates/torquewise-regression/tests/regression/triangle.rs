//! The R factor of rows against the rows themselves.

use faer::Mat;
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use torquewise_regression::error::SparseError;
use torquewise_regression::triangle::Triangle;

fn random(seed: u64, rows: usize, columns: usize) -> Mat<f64> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    Mat::from_fn(rows, columns, |_, _| rng.random_range(-1.0..1.0_f64))
}

fn factor(rows: &Mat<f64>, cuts: &[usize]) -> Triangle {
    let mut triangle = Triangle::new(rows.ncols());
    let mut first = 0;
    for &end in cuts.iter().chain([&rows.nrows()]) {
        triangle.add(rows.subrows(first, end - first)).expect("as many columns");
        first = end;
    }
    triangle
}

/// RᵀR and XᵀX are both rounded some ten times per row summed.
fn assert_factors(triangle: &Triangle, rows: &Mat<f64>) {
    let r = triangle.r();
    assert_eq!(triangle.rows(), rows.nrows());
    assert!((0..r.ncols()).all(|j| (j + 1..r.nrows()).all(|i| r[(i, j)] == 0.0)));
    let difference = (r.transpose() * &r - rows.transpose() * rows).norm_max();
    let tolerance = 16.0 * f64::EPSILON * (1.0 + rows.squared_norm_l2());
    assert!(difference <= tolerance, "{difference:e} > {tolerance:e}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn r_transposed_times_r_is_the_gram_matrix_however_the_rows_are_cut(
        seed in 0..u64::MAX,
        columns in 1..14_usize,
        rows in 0..2_500_usize,
        cuts in prop::collection::vec(any::<prop::sample::Index>(), 0..4),
    ) {
        let x = random(seed, rows, columns);
        let mut cuts: Vec<usize> = cuts.iter().map(|cut| cut.index(rows + 1)).collect();
        cuts.sort_unstable();

        let triangle = factor(&x, &cuts);

        assert_factors(&triangle, &x);
    }

    #[test]
    fn triangles_merge_in_any_order(
        seed in 0..u64::MAX,
        columns in 1..10_usize,
        sizes in [0..400_usize, 0..400, 0..400],
    ) {
        let x = random(seed, sizes.iter().sum(), columns);
        let (second, third) = (sizes[0], sizes[0] + sizes[1]);
        let part = |first, count| factor(&x.subrows(first, count).to_owned(), &[]);
        let parts = [part(0, sizes[0]), part(second, sizes[1]), part(third, sizes[2])];

        for order in [[0, 1, 2], [2, 0, 1], [1, 2, 0]] {
            let mut merged = Triangle::new(columns);
            for place in order {
                let part: &Triangle = &parts[place];
                merged.merge(part).unwrap();
            }

            assert_factors(&merged, &x);
        }
    }
}

#[test]
fn r_keeps_what_a_gram_matrix_has_lost() {
    // Two columns 1e-9 apart: the Gram matrix has a condition of 1e18 and knows only their sum.
    let mut x = random(7, 500, 3);
    for row in 0..500 {
        x[(row, 1)] = x[(row, 0)] + 1e-9 * x[(row, 1)];
        x[(row, 2)] = 2.0 * x[(row, 0)] - x[(row, 1)];
    }

    let triangle = factor(&x, &[100, 200]);

    let r = triangle.r();
    let second = r[(1, 2)] / r[(1, 1)];
    let first = (r[(0, 2)] - r[(0, 1)] * second) / r[(0, 0)];
    // The condition is about 1e9, of which some ten roundings are 1e-6.
    assert!((first - 2.0).abs() < 1e-5 && (second + 1.0).abs() < 1e-5, "{first} {second}");
}

#[test]
fn rows_with_another_number_of_columns_are_refused() {
    let mut triangle = factor(&random(1, 20, 4), &[]);
    let before = triangle.r().to_owned();

    let added = triangle.add(random(2, 5, 3).as_ref());
    let merged = triangle.merge(&factor(&random(2, 5, 5), &[]));

    assert!(matches!(added, Err(SparseError::Shape { found: 3, expected: 4, .. })));
    assert!(matches!(merged, Err(SparseError::Shape { found: 5, expected: 4, .. })));
    assert_eq!((triangle.r(), triangle.rows()), (before, 20));
}
