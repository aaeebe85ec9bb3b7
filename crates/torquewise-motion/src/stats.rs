//! Whole numbers, order statistics, groups and correlation of values.

/// A whole number at most 2⁵³; what is less than zero or no number is 0.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a cast saturates")]
pub fn whole(x: f64) -> usize {
    x as usize
}

/// Median, the upper of the middle two; sorts as far as needed. Zero of nothing.
pub fn median(values: &mut [f64]) -> f64 {
    quantile(values, 0.5)
}

/// The value below which a share of the values lies; zero of none.
pub fn quantile(values: &mut [f64], share: f64) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let last = values.len() - 1;
    let place = whole((share * last as f64).round()).min(last);
    *values.select_nth_unstable_by(place, f64::total_cmp).1
}

/// The least and the greatest of some values; infinite, the wrong way round, of none.
pub fn ends(values: impl IntoIterator<Item = f64>) -> [f64; 2] {
    let none = [f64::INFINITY, f64::NEG_INFINITY];
    values.into_iter().fold(none, |[low, high], x| [low.min(x), high.max(x)])
}

/// Items that are alike together, groups and items in the order in which they come.
pub fn grouped<T>(
    items: impl IntoIterator<Item = T>,
    alike: impl Fn(&T, &T) -> bool,
) -> Vec<Vec<T>> {
    let mut groups: Vec<Vec<T>> = Vec::new();
    for item in items {
        match groups.iter_mut().find(|group| alike(&group[0], &item)) {
            Some(group) => group.push(item),
            None => groups.push(vec![item]),
        }
    }
    groups
}

/// Correlation of two series of one length; not finite where one of them is constant.
pub fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let n = a.len() as f64;
    let (mean_a, mean_b) = (a.iter().sum::<f64>() / n, b.iter().sum::<f64>() / n);
    let (mut aa, mut bb, mut ab) = (0.0, 0.0, 0.0);
    for (a, b) in a.iter().zip(b) {
        let (a, b) = (a - mean_a, b - mean_b);
        aa += a * a;
        bb += b * b;
        ab += a * b;
    }
    ab / (aa * bb).sqrt()
}

#[cfg(test)]
mod tests {
    use super::{correlation, median, quantile};
    use approx::assert_abs_diff_eq;

    #[test]
    fn values_are_ranked_whatever_their_order() {
        let values = [4.0, 1.0, 3.0, 2.0];
        assert_eq!((median(&mut values.clone()), median(&mut [])), (3.0, 0.0));
        for (share, expected) in [(0.0, 1.0), (0.4, 2.0), (0.5, 3.0), (1.0, 4.0)] {
            assert_abs_diff_eq!(quantile(&mut values.clone(), share), expected);
        }
        assert_abs_diff_eq!(quantile(&mut [], 0.5), 0.0);
    }

    #[test]
    fn series_that_rise_together_correlate() {
        let (x, y) = ([1.0, 2.0, 4.0], [-3.0, -5.0, -9.0]);
        assert_abs_diff_eq!(correlation(&x, &y), -1.0, epsilon = 1e-12);
        assert!(!correlation(&x, &[1.0; 3]).is_finite());
    }
}
