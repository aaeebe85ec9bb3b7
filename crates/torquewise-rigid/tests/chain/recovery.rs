//! From simulated motion to a chain that predicts other motion.

use crate::twins::{errors, largest, rows, sines};
use faer::Mat;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use torquewise_motion::Motion;
use torquewise_rigid::search::UNWATCHED;
use torquewise_rigid::{Chain, Rows, Search, search};
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

/// The same motion with white noise of `part` of the spread of each torque.
fn noisy(motion: &Motion, part: f64, seed: u64) -> Rows {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let clean = rows(motion);
    let m = motion.n_rows();
    let spread = |joint: usize| {
        let tau = clean.torque_of(joint);
        let mean = tau.iter().sum::<f64>() / m as f64;
        (tau.iter().map(|tau| (tau - mean).powi(2)).sum::<f64>() / m as f64).sqrt()
    };
    let tau = Mat::from_fn(m, motion.n_joints(), |row, joint| {
        let unit: f64 = StandardNormal.sample(&mut random);
        clean.torque_of(joint)[row] + part * spread(joint) * unit
    });
    let none = vec![Mat::zeros(m, 0); motion.n_joints()];
    Rows::new([motion.q(), motion.dq(), motion.ddq(), tau.as_ref()], &none).unwrap()
}

#[test]
fn noise_in_the_torque_averages_out() {
    let arm = Arm::builtin("puma560-3").unwrap();
    let plan = Search { starts: 8, finalists: 2, ..Search::default() };

    let found = search(&noisy(&sines(&arm, 20.0, 1), 0.01, 7), &plan, UNWATCHED).unwrap().chains;

    let errors = errors(&found[0], &rows(&sines(&arm, 10.0, 2)));
    assert!(largest(&errors) < 0.02, "{errors:?}");
}

#[test]
fn six_joints_are_learned() {
    let arm = Arm::builtin("generic-6").unwrap();
    let plan = Search { starts: 6, finalists: 2, ..Search::default() };

    let found = search(&rows(&sines(&arm, 40.0, 1)), &plan, UNWATCHED).unwrap().chains;

    let errors = errors(&found[0], &rows(&sines(&arm, 10.0, 2)));
    assert!(largest(&errors) < 0.01, "{errors:?}");
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
