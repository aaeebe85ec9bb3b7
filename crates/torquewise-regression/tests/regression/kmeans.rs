//! k-means and the elbow on planted clusters.

use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use torquewise_regression::SparseError;
use torquewise_regression::kmeans::{Clustering, elbow, kmeans};

/// Normal enough: the sum of twelve uniform numbers, variance 1.
fn normal(rng: &mut ChaCha8Rng) -> f64 {
    (0..12).map(|_| rng.random_range(-0.5..0.5_f64)).sum()
}

fn blobs(seed: u64, centres: &[[f64; 2]], spread: f64, each: usize) -> Vec<[f64; 2]> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut point = |c: &[f64; 2]| c.map(|x| x + spread * normal(&mut rng));
    (0..each * centres.len()).map(|i| point(&centres[i % centres.len()])).collect()
}

fn clusters_found(points: &[[f64; 2]]) -> usize {
    let inertia = |k| kmeans(points, k, 0).expect("finite points").inertia;
    elbow(&(1..=8).map(inertia).collect::<Vec<f64>>())
}

fn inertia_of(points: &[[f64; 2]], assignment: &[usize], k: usize) -> f64 {
    let mut inertia = 0.0;
    for cluster in 0..k {
        let own: Vec<_> =
            points.iter().zip(assignment).filter(|(_, a)| **a == cluster).map(|(p, _)| p).collect();
        for axis in 0..2 {
            let mean = own.iter().map(|p| p[axis]).sum::<f64>() / own.len().max(1) as f64;
            inertia += own.iter().map(|p| (p[axis] - mean).powi(2)).sum::<f64>();
        }
    }
    inertia
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    #[test]
    fn few_points_get_the_best_of_all_partitions(
        points in prop::collection::vec([-1.0..1.0_f64, -1.0..1.0_f64], 3..9),
    ) {
        let starts = (0..25).map(|seed| kmeans(&points, 3, seed).unwrap().inertia);
        let found = starts.fold(f64::INFINITY, f64::min);

        let mut best = f64::INFINITY;
        let mut assignment = vec![0; points.len()];
        // Counts through all assignments as numbers to base three.
        while let Some(digit) = assignment.iter().position(|&cluster| cluster < 2) {
            assignment[..digit].fill(0);
            assignment[digit] += 1;
            best = best.min(inertia_of(&points, &assignment, 3));
        }
        prop_assert!((found - best).abs() <= 1e-12, "{} beside {}", found, best);
    }

    #[test]
    fn centres_are_the_means_of_the_points_nearest_to_them(
        points in prop::collection::vec([-1.0..1.0_f64, -1.0..1.0_f64], 5..60),
        k in 1..6_usize,
    ) {
        let Clustering { centres, inertia } = kmeans(&points, k, 0).unwrap();

        let distance = |p: &[f64; 2], c: &[f64; 2]| (p[0] - c[0]).powi(2) + (p[1] - c[1]).powi(2);
        let nearest = |point: &[f64; 2]| {
            let apart = |k: &usize| distance(point, &centres[*k]);
            (0..k).min_by(|a, b| apart(a).total_cmp(&apart(b))).unwrap()
        };
        let assignment: Vec<usize> = points.iter().map(nearest).collect();
        let sums = centres.iter().map(|centre| centre[0] + centre[1]);
        prop_assert!(sums.is_sorted(), "no seed shows in the order: {:?}", centres);
        // Off its mean by δ, a centre adds its number of points times δ² to the inertia.
        let about_means = inertia_of(&points, &assignment, k);
        prop_assert!(inertia >= about_means - 1e-12);
        prop_assert!(inertia <= about_means * (1.0 + 1.1e-8) + 1e-12);
    }
}

#[test]
fn equal_points_in_many_clusters_are_no_trouble() {
    let points = [[0.5, 0.5]; 7];

    let found = kmeans(&points, 4, 0).unwrap();

    assert!(found.inertia < f64::MIN_POSITIVE);
    assert_eq!(found.centres, [[0.5, 0.5]; 4]);
}

#[test]
fn questions_without_answer_are_refused() {
    let points = [[0.0, 0.0], [1.0, f64::NAN]];

    let none = kmeans(&points, 0, 0);
    let more = kmeans(&points, 3, 0);
    let broken = kmeans(&points, 2, 0);

    assert_eq!(none, Err(SparseError::Clusters { clusters: 0, points: 2 }));
    assert_eq!(more, Err(SparseError::Clusters { clusters: 3, points: 2 }));
    assert_eq!(broken, Err(SparseError::NotFinite { what: "a point", entry: 1 }));
}

#[test]
fn the_elbow_counts_planted_clusters() {
    let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.5, 0.5]];
    let corner = |t: f64| [(t * 1.2566).cos(), (t * 1.2566).sin()];
    let pentagon = [corner(0.0), corner(1.0), corner(2.0), corner(3.0), corner(4.0)];
    for seed in 0..5 {
        for spread in [0.0, 0.02, 0.1, 0.15] {
            for planted in 2..=4 {
                let found = clusters_found(&blobs(seed, &square[..planted], spread, 150));

                assert_eq!(found, planted, "spread {spread}, seed {seed}");
            }
            let found = clusters_found(&blobs(seed, &pentagon, spread, 150));

            assert_eq!(found, 5, "pentagon of spread {spread}, seed {seed}");
        }
    }
}

#[test]
fn a_shapeless_cloud_is_one_cluster_and_so_is_one_without_spread() {
    for seed in 0..5 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let uniform: Vec<[f64; 2]> =
            (0..600).map(|_| [rng.random::<f64>(), 1.5 * rng.random::<f64>()]).collect();
        let round = blobs(seed, &[[0.0, 0.0]], 1.0, 600);

        assert_eq!(clusters_found(&uniform), 1, "uniform, seed {seed}");
        assert_eq!(clusters_found(&round), 1, "normal, seed {seed}");
    }
    assert_eq!(elbow(&[]), 0);
    assert_eq!(elbow(&[3.0]), 1);
    assert_eq!(elbow(&[0.0, 0.0, 0.0]), 1);
}
