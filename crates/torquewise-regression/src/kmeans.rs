//! k-means: points shared out among centres, the best of several starts; how many centres there
//! should be.

use crate::{Result, SparseError};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::cmp::Ordering;

const STARTS: usize = 8;
/// A centre stands still if it moves by no more than this part of the root mean square distance of
/// the points to their centres.
const TOLERANCE: f64 = 1e-4;
const MOST_MOVES: usize = 300;

/// Points shared out among centres.
#[derive(Clone, Debug, PartialEq)]
pub struct Clustering<const D: usize> {
    /// Mean of each cluster's points to 1e-4 of the spread, k, in ascending order of the sum of its
    /// coordinates, so that no seed shows in the order.
    pub centres: Vec<[f64; D]>,
    /// Sum of the squared distances of all points to their centres.
    pub inertia: f64,
}

/// Lloyd's k-means with k-means++ starts.
///
/// - `points`: m points in D dimensions
/// - `k`: number of clusters, 1 to m
/// - `seed`: of the starts
///
/// Stops when all centres stand still, or after 300 moves. A cluster that runs empty gets the
/// point farthest from its centre.
///
/// Source: paper, algorithm 1, with its stopping rule put right. Checked against: planted
/// clusters, and the best of all partitions of a few points.
///
/// # Errors
/// [`SparseError::Clusters`] if `k` is no number of clusters for so many points,
/// [`SparseError::NotFinite`].
pub fn kmeans<const D: usize>(points: &[[f64; D]], k: usize, seed: u64) -> Result<Clustering<D>> {
    if k == 0 || k > points.len() {
        return Err(SparseError::Clusters { clusters: k, points: points.len() });
    }
    if let Some(entry) = points.iter().position(|point| point.iter().any(|x| !x.is_finite())) {
        return Err(SparseError::NotFinite { what: "a point", entry });
    }

    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut best = lloyd(points, start(points, k, &mut rng));
    for _ in 1..STARTS {
        let other = lloyd(points, start(points, k, &mut rng));
        if other.inertia < best.inertia {
            best = other;
        }
    }
    let sum = |centre: &[f64; D]| centre.iter().sum::<f64>();
    best.centres.sort_by(|a, b| {
        let differing = a.iter().zip(b).map(|(x, y)| x.total_cmp(y));
        differing.fold(sum(a).total_cmp(&sum(b)), Ordering::then)
    });
    Ok(best)
}

/// k-means++: each next centre is a point drawn with weight distance² to the centres so far.
fn start<const D: usize>(points: &[[f64; D]], k: usize, rng: &mut ChaCha8Rng) -> Vec<[f64; D]> {
    let mut centres = vec![points[rng.random_range(0..points.len())]];
    let mut nearest = vec![f64::INFINITY; points.len()];
    while centres.len() < k {
        let newest = centres[centres.len() - 1];
        for (least, point) in nearest.iter_mut().zip(points) {
            *least = least.min(distance2(point, &newest));
        }
        let mut left = rng.random::<f64>() * nearest.iter().sum::<f64>();
        let drawn = nearest.iter().position(|weight| {
            left -= weight;
            left < 0.0
        });
        // All points may lie on centres already: then any will do.
        let next = drawn.unwrap_or_else(|| rng.random_range(0..points.len()));
        centres.push(points[next]);
    }
    centres
}

/// Moves each centre to the mean of its points until all stand still.
fn lloyd<const D: usize>(points: &[[f64; D]], mut centres: Vec<[f64; D]>) -> Clustering<D> {
    let mut moves = 0;
    loop {
        let (mut sums, mut counts) = (vec![[0.0; D]; centres.len()], vec![0_usize; centres.len()]);
        let (mut inertia, mut farthest) = (0.0, (0.0, points[0]));
        for point in points {
            let (mut nearest, mut distance) = (0, f64::INFINITY);
            for (cluster, centre) in centres.iter().enumerate() {
                let other = distance2(point, centre);
                // Two selects without a branch: which centre is nearer cannot be predicted.
                nearest = if other < distance { cluster } else { nearest };
                distance = distance.min(other);
            }
            sums[nearest].iter_mut().zip(point).for_each(|(sum, x)| *sum += x);
            counts[nearest] += 1;
            inertia += distance;
            if distance > farthest.0 {
                farthest = (distance, *point);
            }
        }
        // The first empty cluster gets the farthest point, any other waits.
        let first_empty = counts.iter().position(|&count| count == 0);
        let mean = |cluster: usize| match counts[cluster] {
            0 if Some(cluster) == first_empty && farthest.0 > 0.0 => farthest.1,
            0 => centres[cluster],
            count => sums[cluster].map(|sum| sum / count as f64),
        };
        let moved: Vec<[f64; D]> = (0..centres.len()).map(mean).collect();
        let still2 = TOLERANCE.powi(2) * inertia / points.len() as f64;
        let stands = |(old, new): (&[f64; D], &[f64; D])| distance2(old, new) <= still2;
        if moves == MOST_MOVES || centres.iter().zip(&moved).all(stands) {
            return Clustering { centres, inertia };
        }
        centres = moved;
        moves += 1;
    }
}

fn distance2<const D: usize>(a: &[f64; D], b: &[f64; D]) -> f64 {
    a.iter().zip(b).map(|(x, y)| (x - y) * (x - y)).sum()
}

/// A further cluster must lower the root mean square distance to the centre by this part of what
/// it is for one cluster.
const PRICE: f64 = 0.15;

/// Inertia falls as 1/k for a shapeless cloud in the plane; clusters make it fall faster than this
/// power of k.
const SHAPELESS: f64 = 1.25;

/// Number of clusters at the elbow of an inertia curve.
///
/// - `inertias`: inertia for 1, 2, 3, … clusters; six or more show an elbow well
///
/// The rule: k minimises √(Iₖ/I₁) + 0.15 k, so each further cluster must take 15 % off the root
/// mean square distance; but one cluster, unless Iₖ < I₁ k^−1.25 for some k. A uniform or normal
/// cloud in the plane keeps Iₖ ≥ I₁/k but for a few percent. The price is the middle of the range,
/// 0.13 to 0.16, that finds planted clusters of various spread and the three patterns of simulated
/// moves; Iₖ beyond the elbow, and how many there are, play no part. Hence at most six clusters
/// are found, and points strewn along a line pass for clusters.
///
/// An empty curve gives 0, one without spread 1.
pub fn elbow(inertias: &[f64]) -> usize {
    let Some(&first) = inertias.first() else { return 0 };
    let part = |inertia: f64| (inertia / first).clamp(0.0, 1.0);
    let counted = || (1_usize..).zip(inertias);
    let falls = |(k, &own): (usize, &f64)| k > 1 && part(own) < (k as f64).powf(-SHAPELESS);
    if first <= 0.0 || !counted().any(falls) {
        return 1;
    }
    let cost = |(k, own): &(usize, &f64)| part(**own).sqrt() + PRICE * *k as f64;
    counted().min_by(|a, b| cost(a).total_cmp(&cost(b))).map_or(1, |(k, _)| k)
}
