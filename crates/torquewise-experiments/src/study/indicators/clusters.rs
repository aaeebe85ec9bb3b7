//! From noise, leverage to clusters: which rows carry information, which amplified noise \[E17\].

use crate::error::ExperimentError;
use torquewise_regression::elbow::{elbow, inertias};
use torquewise_regression::kmeans::{Clustering, KMeans, kmeans};

/// Clusters tried for the elbow.
const MOST_CLUSTERS: usize = 6;
/// Clusters where the elbow sees none, as many as there are patterns.
const USUAL: usize = 3;
/// Part of the information Σ h/v that the rows kept must hold.
const INFORMATION: f64 = 0.9;
/// Leverage below this part of its mean counts as this part: the logarithm of zero is no number.
const LEAST: f64 = 1e-4;

/// Rows of one equation sorted by what they say.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Informative {
    /// Clusters at the elbow.
    pub elbow: usize,
    /// Whether each row is in a cluster that carries information, m.
    pub kept: Vec<bool>,
}

/// The points \[ln v, ln h\] of some rows, each axis divided by its standard deviation.
pub(crate) fn indicators(variance: &[f64], leverage: &[f64]) -> Vec<[f64; 2]> {
    let logarithms = |x: &[f64]| -> Vec<f64> {
        let mean = x.iter().sum::<f64>() / x.len().max(1) as f64;
        let least = (LEAST * mean).max(f64::MIN_POSITIVE);
        let logs: Vec<f64> = x.iter().map(|x| x.max(least).ln()).collect();
        let middle = logs.iter().sum::<f64>() / logs.len().max(1) as f64;
        let squares: f64 = logs.iter().map(|x| (x - middle).powi(2)).sum();
        let spread = (squares / logs.len().max(1) as f64).sqrt();
        let scale = if spread > 1e-9 { spread.recip() } else { 0.0 };
        logs.iter().map(|x| (x - middle) * scale).collect()
    };
    let (noise, leverage) = (logarithms(variance), logarithms(leverage));
    noise.into_iter().zip(leverage).map(|(a, b)| [a, b]).collect()
}

/// Clusters rows by (noise, leverage) and keeps the clusters with the most information per row,
/// mean h over mean v, until they hold nine tenths of it. Where the elbow sees one cluster, three
/// are made; rows without any leverage are all kept.
///
/// - `variance`, `leverage`: v and h of each row, m
pub(crate) fn informative(
    variance: &[f64],
    leverage: &[f64],
) -> Result<Informative, ExperimentError> {
    let m = variance.len();
    if m <= MOST_CLUSTERS || leverage.iter().all(|h| *h <= 0.0) {
        return Ok(Informative { elbow: 1, kept: vec![true; m] });
    }
    let points = indicators(variance, leverage);
    let settings = KMeans { restarts: 4, ..KMeans::default() };
    let elbow = elbow(&inertias(&points, MOST_CLUSTERS, &settings)?);
    let count = if elbow > 1 { elbow } else { USUAL };
    let Clustering { assignment, .. } = kmeans(&points, count, &settings)?;
    let mut sums = vec![[0.0; 3]; count];
    for (row, &cluster) in assignment.iter().enumerate() {
        let [v, h, information] = &mut sums[cluster];
        *v += variance[row];
        *h += leverage[row];
        *information += leverage[row] / variance[row].max(f64::MIN_POSITIVE);
    }
    let density = |cluster: &usize| sums[*cluster][1] / sums[*cluster][0].max(f64::MIN_POSITIVE);
    let mut order: Vec<usize> = (0..count).collect();
    order.sort_by(|a, b| density(b).total_cmp(&density(a)));
    let total: f64 = sums.iter().map(|sum| sum[2]).sum();
    let (mut kept, mut held) = (vec![false; count], 0.0);
    for cluster in order {
        if held >= INFORMATION * total {
            break;
        }
        kept[cluster] = true;
        held += sums[cluster][2];
    }
    Ok(Informative { elbow, kept: assignment.into_iter().map(|cluster| kept[cluster]).collect() })
}

/// Sorts rows into as many clusters of (noise, leverage) as there are patterns, the quietest
/// first: cluster of each row, m.
pub(crate) fn by_noise(variance: &[f64], leverage: &[f64]) -> Result<Vec<usize>, ExperimentError> {
    let points = indicators(variance, leverage);
    let settings = KMeans { restarts: 4, ..KMeans::default() };
    let clustering = kmeans(&points, USUAL, &settings)?;
    let mut order: Vec<usize> = (0..USUAL).collect();
    order.sort_by(|&a, &b| clustering.centres[a][0].total_cmp(&clustering.centres[b][0]));
    let mut rank = [0; USUAL];
    for (place, &cluster) in order.iter().enumerate() {
        rank[cluster] = place;
    }
    Ok(clustering.assignment.into_iter().map(|cluster| rank[cluster]).collect())
}
