//! From simulated motion to a chain that predicts other motion.

use crate::twins::{errors, largest, rows, sines};
use torquewise_rigid::search::UNWATCHED;
use torquewise_rigid::{Chain, Search, search};
use torquewise_sim::Arm;

#[test]
fn without_noise_other_motion_is_predicted() {
    let arm = Arm::builtin("puma560-3").unwrap();
    // What is left is what the ridge takes off.
    let plan = Search { starts: 8, finalists: 2, ridge: 1e-8, ..Search::default() };

    let found = search(&rows(&sines(&arm, 20.0, 1)), &plan, UNWATCHED).unwrap().chains;

    let errors = errors(&found[0], &rows(&sines(&arm, 10.0, 2)));
    assert!(largest(&errors) < 1e-5, "{errors:?}");
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

#[test]
fn the_same_seed_gives_the_same_chain_at_any_number_of_threads() {
    // Many rows, so that products of matrices are worth more than one thread.
    let rows = rows(&sines(&Arm::builtin("generic-6").unwrap(), 30.0, 3));
    let plan = Search { starts: 3, finalists: 2, rounds: 4, ..Search::default() };
    let chains_with = |threads: usize| -> Vec<Chain> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| search(&rows, &plan, UNWATCHED).unwrap().chains)
    };

    let bits = |chains: Vec<Chain>| -> Vec<u64> {
        let numbers = chains.into_iter().flat_map(|chain| {
            let geometry = chain.geometry.parameters().to_vec();
            [geometry, chain.inertial, chain.drive, chain.residual_rms, vec![chain.cost]].concat()
        });
        numbers.map(f64::to_bits).collect()
    };
    assert_eq!(bits(chains_with(1)), bits(chains_with(2)));
}
