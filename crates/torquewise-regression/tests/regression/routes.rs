//! From moments and rows to the same normal equations, on any machine.

use crate::random_design::{RandomDesign, any_design, samples};
use faer::Mat;
use proptest::prelude::*;
use rayon::ThreadPoolBuilder;
use std::slice::from_ref;
use torquewise_regression::row_sums::Route;
use torquewise_regression::{
    NormalEquations, PreparedDesign, RowAdder, RowSums, Samples, SparseError,
};

const ROUTES: [Route; 2] = [Route::Moments, Route::Direct];

fn row_sums(prepared: &PreparedDesign, blocks: &[Samples]) -> Result<RowSums, SparseError> {
    let mut adder = RowAdder::new(prepared);
    blocks.iter().try_for_each(|block| adder.push(block.clone()))?;
    adder.finish()
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

/// The normal equations of all columns of a block, by plain products.
fn plain(random: &RandomDesign, block: &Samples) -> Vec<NormalEquations> {
    let columns = random.design().columns(block).expect("a block that fits");
    let equations = columns.iter().enumerate().map(|(equation, y)| {
        let responses = random.responses_of(equation, block);
        NormalEquations {
            gram: y.transpose() * y,
            cross: y.transpose() * &responses,
            energy: responses.col_iter().map(|y| y.squared_norm_l2()).collect(),
            rows: block.n_rows() as f64,
        }
    });
    equations.collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn columns_have_the_values_that_the_formula_gives(
        random in any_design(),
        seed in 0..u64::MAX,
        rows in 0..300_usize,
    ) {
        let block = samples(&random, seed, rows);

        let columns = random.design().columns(&block).unwrap();

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
        rows in [0..600_usize, 0..300],
        picks in prop::collection::vec(any::<prop::sample::Index>(), 0..8),
    ) {
        let blocks = [samples(&random, seed, rows[0]), samples(&random, !seed, rows[1])];
        let columns: Vec<usize> = picks.iter().map(|pick| pick.index(random.n_columns())).collect();
        let [mut expected, more] = [plain(&random, &blocks[0]), plain(&random, &blocks[1])];
        expected.iter_mut().zip(&more).for_each(|(sum, more)| sum.add(more, 1.0).unwrap());
        for route in ROUTES {
            let prepared = random.prepared(route);
            let mut merged = row_sums(&prepared, &blocks[..1]).unwrap();
            merged.merge(&row_sums(&prepared, &blocks[1..]).unwrap()).unwrap();
            let whole = merged.all_grams(&prepared);

            let subset = random.design().subset(&columns);
            let prepared = PreparedDesign::new(&subset, random.n_responses(), route);
            let part = row_sums(&prepared, &blocks).unwrap().all_grams(&prepared);

            assert_eq!((whole.len(), part.len()), (expected.len(), expected.len()));
            for (equation, expected) in expected.iter().enumerate() {
                let bounds = random.bounds(equation);
                assert_same(&whole[equation], expected, &bounds);
                let bounds: Vec<f64> = columns.iter().map(|&column| bounds[column]).collect();
                assert_same(&part[equation], &expected.restricted(&columns), &bounds);
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
            pool.install(|| row_sums(&prepared, &blocks).unwrap().all_grams(&prepared))
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
        Samples { responses: one_less(&good.responses), ..good.clone() },
        Samples { responses: Mat::zeros(4, random.n_responses()), ..good.clone() },
    ];
    for route in ROUTES {
        let prepared = random.prepared(route);
        for block in &bad {
            let refused = row_sums(&prepared, from_ref(block));
            assert!(matches!(refused, Err(SparseError::Shape { .. })), "{route:?}");
        }
        assert!(row_sums(&prepared, from_ref(&good)).is_ok());
    }
}
