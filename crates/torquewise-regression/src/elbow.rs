//! Number of clusters: where the inertia curve bends.

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
    let Some(&first) = inertias.first() else {
        return 0;
    };
    let part = |inertia: f64| (inertia / first).clamp(0.0, 1.0);
    let counted = || (1_u32..).zip(inertias);
    let falls = |(k, &inertia): (u32, &f64)| k > 1 && part(inertia) < f64::from(k).powf(-SHAPELESS);
    if first <= 0.0 || !counted().any(falls) {
        return 1;
    }
    let cost = |(k, &inertia): (u32, &f64)| part(inertia).sqrt() + PRICE * f64::from(k);
    let costs: Vec<f64> = counted().map(cost).collect();
    let cheapest = costs.iter().copied().fold(f64::INFINITY, f64::min);
    costs.iter().position(|&cost| cost <= cheapest).map_or(1, |at| at + 1)
}
