//! Median, least and greatest of repeated values.

use serde::Serialize;

/// How repeated values lie.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Spread {
    /// The value in the middle; the mean of the two there if the count is even.
    pub median: f64,
    /// The smallest.
    pub least: f64,
    /// The largest.
    pub greatest: f64,
}

impl Spread {
    /// The spread of some values; not a number if there are none.
    pub fn of(values: impl IntoIterator<Item = f64>) -> Self {
        let mut sorted: Vec<f64> = values.into_iter().collect();
        sorted.sort_by(f64::total_cmp);
        let Some(last) = sorted.len().checked_sub(1) else {
            return Self { median: f64::NAN, least: f64::NAN, greatest: f64::NAN };
        };
        let median = 0.5 * (sorted[last / 2] + sorted[last.div_ceil(2)]);
        Self { median, least: sorted[0], greatest: sorted[last] }
    }

    /// The spread of each column of some rows of the same length.
    pub fn of_columns<'a>(rows: impl IntoIterator<Item = &'a [f64]>) -> Vec<Self> {
        let rows: Vec<&[f64]> = rows.into_iter().collect();
        let columns = rows.first().map_or(0, |row| row.len());
        (0..columns).map(|j| Self::of(rows.iter().filter_map(|row| row.get(j)).copied())).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_of_an_even_count_lies_between_the_middle_two() {
        let spread = Spread::of([4.0, 1.0, 3.0, 2.0]);

        assert_eq!(spread, Spread { median: 2.5, least: 1.0, greatest: 4.0 });
        assert!(Spread::of([]).median.is_nan());
        assert_eq!(Spread::of_columns([&[4.0][..], &[1.0], &[3.0], &[2.0]]), [spread]);
    }
}
