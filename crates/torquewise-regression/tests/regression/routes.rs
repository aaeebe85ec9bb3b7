//! From moments and rows to the same normal equations, on any machine.

use crate::random_design::{RandomDesign, any_design, samples};
use faer::Mat;
use proptest::prelude::*;
use rayon::ThreadPoolBuilder;
use torquewise_regression::accumulate::{Prepared, Route};
use torquewise_regression::atom::{Atom, Monomial, Phase, Wave};
use torquewise_regression::design::Design;
use torquewise_regression::error::SparseError;
use torquewise_regression::normal_equations::NormalEquations;
use torquewise_regression::row_sums::{RowAdder, RowSums};
use torquewise_regression::samples::{Evaluator, Samples};

const ROUTES: [Route; 2] = [Route::Moments, Route::Direct];

fn grams(random: &RandomDesign, route: Route, blocks: &[Samples]) -> Vec<NormalEquations> {
    let prepared = random.prepared(route);
    let mut sum = prepared.start();
    for block in blocks {
        sum.add(block).expect("blocks of the shape of the design");
    }
    sum.grams()
}

fn row_sums(prepared: &Prepared, blocks: &[Samples]) -> RowSums {
    let mut adder = RowAdder::new(prepared);
    for block in blocks {
        adder.push(block.clone()).expect("blocks of the shape of the design");
    }
    adder.finish().expect("sums within range")
}

/// Angles and variables are bounded, so an entry is a sum of m products of at most bᵢ·bⱼ: each
/// product is rounded some ten times on its way, the sum m times.
fn assert_same(found: &NormalEquations, expected: &NormalEquations, bounds: &[f64]) {
    let rounding = f64::EPSILON * (16.0 + expected.rows) * 4.0;
    assert_eq!(found.rows.to_bits(), expected.rows.to_bits());
    for (i, left) in bounds.iter().enumerate() {
        for (j, right) in bounds.iter().enumerate() {
            let difference = found.gram[(i, j)] - expected.gram[(i, j)];
            let tolerance = rounding * expected.rows * left * right;
            assert!(difference.abs() <= tolerance, "gram {i} {j}: {difference:e} > {tolerance:e}");
        }
        for response in 0..expected.cross.ncols() {
            let difference = found.cross[(i, response)] - expected.cross[(i, response)];
            let tolerance = rounding * expected.rows * left;
            assert!(difference.abs() <= tolerance, "cross {i} {response}: {difference:e}");
        }
    }
    for (found, expected) in found.energy.iter().zip(&expected.energy) {
        assert!((found - expected).abs() <= rounding * expected, "{found} {expected}");
    }
}

fn assert_all_same(found: &[NormalEquations], expected: &[NormalEquations], random: &RandomDesign) {
    assert_eq!(found.len(), expected.len());
    for (equation, (found, expected)) in found.iter().zip(expected).enumerate() {
        assert_same(found, expected, &random.bounds(equation));
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn an_evaluator_gives_the_values_that_the_formula_gives(
        random in any_design(),
        seed in 0..u64::MAX,
        rows in 0..300_usize,
    ) {
        let block = samples(&random, seed, rows);

        let columns = Evaluator::new(random.design()).columns(&block).unwrap();

        for (equation, values) in columns.iter().enumerate() {
            let expected = random.naive(equation, &block);
            for (j, bound) in random.bounds(equation).into_iter().enumerate() {
                for row in 0..rows {
                    let difference = values[(row, j)] - expected[(row, j)];
                    // The formula rounds its argument k·θ, which is below 32, then a dozen times.
                    prop_assert!(difference.abs() <= 64.0 * f64::EPSILON * bound);
                }
            }
        }
    }

    #[test]
    fn both_routes_give_the_sums_of_products_of_the_columns(
        random in any_design(),
        seed in 0..u64::MAX,
        rows in 0..600_usize,
    ) {
        let block = samples(&random, seed, rows);

        let by_moments = grams(&random, Route::Moments, std::slice::from_ref(&block));
        let by_rows = grams(&random, Route::Direct, std::slice::from_ref(&block));

        let columns = Evaluator::new(random.design()).columns(&block).unwrap();
        let plain: Vec<NormalEquations> = columns
            .iter()
            .enumerate()
            .map(|(equation, y)| {
                let responses = random.responses_of(equation, &block);
                NormalEquations {
                    gram: y.transpose() * y,
                    cross: y.transpose() * &responses,
                    energy: responses.col_iter().map(|y| y.squared_norm_l2()).collect(),
                    rows: rows as f64,
                }
            })
            .collect();
        assert_all_same(&by_moments, &plain, &random);
        assert_all_same(&by_rows, &plain, &random);
    }

    #[test]
    fn merging_two_halves_is_the_same_as_reading_all_rows(
        random in any_design(),
        seed in 0..u64::MAX,
        rows in [0..300_usize, 0..300],
    ) {
        let blocks = [samples(&random, seed, rows[0]), samples(&random, !seed, rows[1])];
        for route in ROUTES {
            let prepared = random.prepared(route);

            let mut merged = row_sums(&prepared, &blocks[..1]);
            merged.merge(&row_sums(&prepared, &blocks[1..])).unwrap();

            let merged = random.grams_of(&prepared, &merged);
            assert_all_same(&merged, &grams(&random, route, &blocks), &random);
        }
    }

    #[test]
    fn a_subset_of_columns_has_the_matching_part_of_the_gram_matrix(
        random in any_design(),
        seed in 0..u64::MAX,
        picks in prop::collection::vec(any::<prop::sample::Index>(), 0..8),
    ) {
        let columns: Vec<usize> = picks.iter().map(|pick| pick.index(random.n_columns())).collect();
        let block = samples(&random, seed, 200);
        for route in ROUTES {
            let whole = grams(&random, route, std::slice::from_ref(&block));

            let subset = random.design().subset(&columns).unwrap();
            let prepared = Prepared::new(&subset, random.n_responses(), route);
            let mut sum = prepared.start();
            sum.add(&block).unwrap();

            for (equation, (found, whole)) in sum.grams().iter().zip(&whole).enumerate() {
                let bounds = random.bounds(equation);
                let bounds: Vec<f64> = columns.iter().map(|&column| bounds[column]).collect();
                let part = whole.restricted(&columns);
                assert_same(found, &part, &bounds);
            }
        }
    }
}

#[test]
fn sums_have_the_same_bits_at_any_number_of_threads() {
    let random = RandomDesign::fixed();
    let blocks: Vec<Samples> = (0..70).map(|seed| samples(&random, seed, 50)).collect();
    for route in ROUTES {
        let prepared = random.prepared(route);
        let sum = |threads| {
            let pool = ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| random.grams_of(&prepared, &row_sums(&prepared, &blocks)))
        };

        let alone = sum(1);

        assert!(alone.iter().all(|gram| gram.rows.to_bits() == 3_500.0_f64.to_bits()));
        for threads in [2, 3] {
            for (many, one) in sum(threads).iter().zip(&alone) {
                assert_eq!(bits(&many.gram), bits(&one.gram), "{route:?}");
                assert_eq!(bits(&many.cross), bits(&one.cross), "{route:?}");
                assert_eq!(many.energy, one.energy);
            }
        }
    }
}

fn bits(matrix: &Mat<f64>) -> Vec<u64> {
    matrix.col_iter().flat_map(|column| column.iter().map(|x| x.to_bits())).collect()
}

#[test]
fn blocks_of_another_shape_are_refused_by_both_routes() {
    let random = RandomDesign::fixed();
    let good = samples(&random, 1, 5);
    let one_less = |x: &Mat<f64>| x.subcols(1, x.ncols() - 1).to_owned();
    let bad = [
        Samples { angles: one_less(&good.angles), ..good.clone() },
        Samples { variables: one_less(&good.variables), ..good.clone() },
        Samples { responses: Mat::zeros(4, random.n_responses()), ..good.clone() },
    ];
    for route in ROUTES {
        let prepared = random.prepared(route);
        let mut sum = prepared.start();
        for block in &bad {
            assert!(matches!(sum.add(block), Err(SparseError::Shape { .. })), "{route:?}");
        }
        assert!(sum.add(&good).is_ok());
    }
}

#[test]
fn the_direct_route_serves_few_rows_and_moments_serve_many() {
    let random = RandomDesign::fixed();
    let design = random.design();

    let route = |rows| Prepared::cheaper(&design, random.n_responses(), rows).route();

    assert_eq!(route(1), Route::Direct);
    assert_eq!(route(100_000), Route::Moments);
}

#[test]
fn the_cost_of_a_row_is_what_a_hand_counts() {
    let atom = |multiples: [i8; 2], phase, power| {
        let (weight, wave) = Wave::canonical(multiples.to_vec(), phase).expect("not sin 0");
        Atom { weight, wave, monomial: Monomial::new(vec![power]) }
    };
    let first = vec![atom([1, 0], Phase::Cos, 1), atom([1, 1], Phase::Cos, 2)];
    let second = vec![atom([1, 0], Phase::Sin, 1)];

    let evaluator = Evaluator::new(Design::new(2, 1, &[vec![first, second]]).unwrap());

    // Harmonics 0, q1 and q1+q2 at four products each, x and x², three atoms at two each.
    assert!((evaluator.cost() - (3.0 * 4.0 + 2.0 + 3.0 * 2.0)).abs() < 0.5);
}
