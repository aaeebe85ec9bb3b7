//! Noise of a signal: how much of it is white, and its quantisation step.

use crate::median;
/// Rows of standstill needed to judge the noise on them alone.
const MIN_STANDSTILL: usize = 64;

/// Share of the distances between neighbouring values that a quantisation step must explain.
const EXPLAINED: f64 = 0.99;

/// The grid on which the values of a signal lie.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quantisation {
    /// Distance between neighbouring levels, in the unit of the signal.
    pub step: f64,
    /// Levels between the smallest and the largest value, both included.
    pub levels: f64,
    /// Step over the standard deviation of the signal.
    pub share_of_deviation: f64,
}

/// Standard deviation of the white noise in `x` by fourth differences, which take away any smooth
/// motion.
///
/// - `x`: evenly sampled, m values
/// - `still`: whether the joint stood still, m values, see [`standstill`]; with too few such rows
///   all are taken
///
/// Source: J. von Neumann et al., Ann. Math. Stat. 12 (1941); white noise gives Δ⁴x a variance of
/// 70 σ². The median of |Δ⁴x| is taken, or the root mean square where that is rounding, as with an
/// encoder that mostly stands on one step.
pub(crate) fn white_noise(x: &[f64], still: &[bool]) -> f64 {
    let fourth = |w: &[f64]| w[0] - 4.0 * w[1] + 6.0 * w[2] - 4.0 * w[3] + w[4];
    let windows = || x.windows(5).zip(still.windows(5));
    let is_still = |still: &[bool]| still.iter().all(|still| *still);
    let at_rest: Vec<f64> =
        windows().filter(|(_, still)| is_still(still)).map(|(x, _)| fourth(x)).collect();
    let is_enough = at_rest.len() >= MIN_STANDSTILL;
    let differences = if is_enough { at_rest } else { x.windows(5).map(fourth).collect() };
    if differences.is_empty() {
        return 0.0;
    }
    let mean_square = differences.iter().map(|x| x * x).sum::<f64>() / differences.len() as f64;
    let mut sizes: Vec<f64> = differences.into_iter().map(f64::abs).collect();
    let robust = median(&mut sizes) / 0.674_489_75;
    let rounding = 64.0 * f64::EPSILON * x.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    (if robust > rounding { robust } else { mean_square.sqrt() }) / 70.0_f64.sqrt()
}

/// Rows where a joint is in the lower of two clusters of its own speed.
///
/// The border between the clusters is the one of least variance within them.
///
/// - `dq`: velocity \[rad/s\], m
///
/// Source: N. Otsu, IEEE Trans. Syst. Man Cybern. 9 (1979), without its histogram.
pub(crate) fn standstill(dq: &[f64]) -> Vec<bool> {
    let mut speeds: Vec<f64> = dq.iter().map(|dq| dq.abs()).collect();
    speeds.sort_by(f64::total_cmp);
    let total: f64 = speeds.iter().sum();
    let n = speeds.len() as f64;
    let (mut below, mut best, mut border) = (0.0, 0.0, f64::INFINITY);
    for (k, pair) in speeds.windows(2).enumerate() {
        below += pair[0];
        let lower = (k + 1) as f64;
        let apart = (total - below) / (n - lower) - below / lower;
        let between = lower * (n - lower) * apart * apart;
        if between > best && pair[1] > pair[0] {
            (best, border) = (between, 0.5 * (pair[0] + pair[1]));
        }
    }
    dq.iter().map(|dq| dq.abs() < border).collect()
}

/// The step that the values of `x` are quantised to, if there is one.
///
/// It is the smallest distance between two different values, or a whole fraction of it, of which
/// 99 % of the distances between neighbouring values are multiples to 5 %. Values that differ by
/// no more than rounding count as equal.
pub(crate) fn quantisation(x: &[f64]) -> Option<Quantisation> {
    let mut sorted = x.to_vec();
    sorted.sort_by(f64::total_cmp);
    let (low, high) = (*sorted.first()?, *sorted.last()?);
    let rounding = 8.0 * f64::EPSILON * low.abs().max(high.abs());
    let gaps: Vec<f64> = sorted.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let gaps: Vec<f64> = gaps.into_iter().filter(|gap| *gap > rounding).collect();
    let smallest = gaps.iter().copied().fold(f64::INFINITY, f64::min);
    // Steps near rounding say nothing, and one gap would always fit.
    if gaps.len() < 2 || smallest < 64.0 * rounding {
        return None;
    }
    let fits = |step: f64| {
        let on_grid = |gap: &&f64| (**gap / step - (**gap / step).round()).abs() < 0.05;
        gaps.iter().filter(on_grid).count() as f64 >= EXPLAINED * gaps.len() as f64
    };
    let step = (1..=4).map(|part| smallest / f64::from(part)).find(|step| fits(*step))?;
    let mean = x.iter().sum::<f64>() / x.len() as f64;
    let variance = x.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / x.len() as f64;
    let levels = ((high - low) / step).round() + 1.0;
    Some(Quantisation { step, levels, share_of_deviation: step / variance.sqrt() })
}

#[cfg(test)]
pub(crate) mod tests;
