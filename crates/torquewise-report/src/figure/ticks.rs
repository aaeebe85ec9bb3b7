//! From ends of an axis to ticks: round numbers, and how they are written.

/// Fewer decades than this are divided evenly: no three round ratios lie between their ends.
const FEW_DECADES: f64 = 0.7;
/// Fewer decades than this get numbers between them.
const SOME_DECADES: f64 = 1.9;
/// Part of the range a tick may lie beyond the end for the sake of rounding.
const SLACK: f64 = 1e-9;

/// A number at an axis and how it is written.
pub(crate) type Tick = (f64, String);

/// At most about `most` numbers from `low` to `high`, only whole ones if so wished.
pub(crate) fn steps([low, high]: [f64; 2], most: i32, is_whole: bool) -> Vec<Tick> {
    let rough = (high - low) / f64::from(most.max(1));
    let rough = if is_whole { rough.max(1.0) } else { rough };
    let decade = rough.log10().floor();
    let unit = 10_f64.powf(decade);
    let factor = [1.0, 2.0, 5.0, 10.0].into_iter().find(|factor| factor * unit >= rough);
    let step = factor.unwrap_or(10.0) * unit;
    let slack = SLACK * (high - low);
    let first = whole(((low - slack) / step).ceil());
    let last = whole(((high + slack) / step).floor()).min(first + 100);
    let values: Vec<f64> = (first..=last).map(|k| k as f64 * step).collect();
    let largest = values.iter().fold(0.0_f64, |largest, value| largest.max(value.abs()));
    let decade = if factor == Some(10.0) { decade + 1.0 } else { decade };
    let text = |value: f64| {
        if (1e-3..1e6).contains(&largest) {
            let decimals = usize::try_from(whole(-decade).max(0)).unwrap_or(0);
            return format!("{value:.decimals$}");
        }
        if value == 0.0 {
            return "0".into();
        }
        // As many digits as tell one step from the next.
        let digits = whole(value.abs().log10().floor() - decade).clamp(0, 15);
        format!("{value:.*e}", usize::try_from(digits).unwrap_or(0))
    };
    values.into_iter().map(|value| (value, text(value))).collect()
}

/// At most about `most` numbers on a logarithmic axis, from 10 to the power of `low`; only whole
/// ones if so wished.
pub(crate) fn decades([low, high]: [f64; 2], most: i32, is_whole: bool) -> Vec<Tick> {
    let span = high - low;
    if span < FEW_DECADES {
        return steps([10_f64.powf(low), 10_f64.powf(high)], most, is_whole);
    }
    let factors: &[f64] = if span < SOME_DECADES { &[1.0, 2.0, 5.0] } else { &[1.0] };
    let (first, last) = (whole(low.floor()), whole(high.ceil()));
    let every = (whole(span.floor()) / i64::from(most.max(1)) + 1).max(1);
    let slack = SLACK * span;
    (first..=last)
        .filter(|exponent| exponent % every == 0 && (!is_whole || *exponent >= 0))
        .flat_map(|exponent| factors.iter().map(move |factor| (exponent, *factor)))
        .map(|(exponent, factor)| (factor * 10_f64.powf(exponent as f64), exponent, factor))
        .filter(|(value, _, _)| (low - slack..=high + slack).contains(&value.log10()))
        .map(|(value, exponent, factor)| (value, written(exponent, factor)))
        .collect()
}

/// A factor times a power of ten: plain if there are few zeros.
fn written(exponent: i64, factor: f64) -> String {
    if !(-3..6).contains(&exponent) {
        return format!("{factor}e{exponent}");
    }
    let decimals = usize::try_from(-exponent).unwrap_or(0);
    format!("{:.decimals$}", factor * 10_f64.powf(exponent as f64))
}

/// A whole number of ordinary size.
fn whole(x: f64) -> i64 {
    #[expect(clippy::cast_possible_truncation, reason = "clamped far within the range of i64")]
    let whole = x.clamp(-1e15, 1e15) as i64;
    whole
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts(ticks: Vec<Tick>) -> Vec<String> {
        ticks.into_iter().map(|(_, text)| text).collect()
    }

    #[test]
    fn numbers_at_an_axis_are_round() {
        assert_eq!(texts(steps([-0.5, 10.5], 6, false)), ["0", "2", "4", "6", "8", "10"]);
        assert_eq!(
            texts(steps([0.0, 0.3], 6, false)),
            ["0.00", "0.05", "0.10", "0.15", "0.20", "0.25", "0.30"]
        );
        assert_eq!(texts(steps([-1.0, 1.0], 3, false)), ["-1", "0", "1"]);
    }

    #[test]
    fn very_large_and_small_numbers_are_short() {
        assert_eq!(texts(steps([0.0, 2e9], 4, false)), ["0", "5e8", "1.0e9", "1.5e9", "2.0e9"]);
        assert_eq!(texts(steps([-2e-7, 0.0], 2, false)), ["-2e-7", "-1e-7", "0"]);
    }

    #[test]
    fn a_logarithmic_axis_shows_decades_plainly() {
        assert_eq!(texts(decades([-2.1, 1.1], 6, false)), ["0.01", "0.1", "1", "10"]);
        assert_eq!(texts(decades([-14.0, -11.5], 6, false)), ["1e-14", "1e-13", "1e-12"]);
        assert_eq!(texts(decades([4.0, 6.0], 6, false)), ["10000", "100000", "1e6"]);
        assert_eq!(
            texts(decades([-12.0, 12.0], 5, false)),
            ["1e-10", "1e-5", "1", "100000", "1e10"]
        );
    }

    #[test]
    fn a_short_logarithmic_axis_has_numbers_too() {
        assert_eq!(texts(decades([0.0, 1.0], 6, false)), ["1", "2", "5", "10"]);
        assert_eq!(texts(decades([0.0, 0.17], 6, false)), ["1.0", "1.1", "1.2", "1.3", "1.4"]);
    }

    #[test]
    fn what_is_counted_has_whole_numbers() {
        assert_eq!(texts(steps([0.5, 3.5], 6, true)), ["1", "2", "3"]);
        assert_eq!(texts(steps([0.0, 40.0], 4, true)), ["0", "10", "20", "30", "40"]);
        assert_eq!(texts(decades([-0.3, 1.1], 6, true)), ["1", "2", "5", "10"]);
        assert_eq!(texts(decades([0.0, 0.5], 6, true)), ["1", "2", "3"]);
    }
}
