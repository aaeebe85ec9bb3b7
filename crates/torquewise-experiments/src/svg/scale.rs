//! Range of an axis → places in pixels, and the numbers that stand there.

use torquewise_report::html::Axis;

/// About so many numbers stand at an axis.
const TICKS: f64 = 6.0;
/// Space beyond the outermost points, as a part of the range.
const MARGIN: f64 = 0.05;

/// An axis of some pixels.
#[derive(Clone, Debug)]
pub(crate) struct Scale {
    low: f64,
    high: f64,
    log: bool,
    pixels: f64,
}

impl Scale {
    /// The axis for some values; those it cannot show play no part.
    pub(crate) fn new(axis: &Axis, values: impl Iterator<Item = f64>, pixels: f64) -> Self {
        let log = axis.log;
        let shown = values.filter(|x| x.is_finite() && (!log || *x > 0.0));
        let coordinate = |x: f64| if log { x.log10() } else { x };
        let wanted = axis.range.filter(|[low, high]| low < high && (!log || *low > 0.0));
        let (low, high) = match wanted {
            Some([low, high]) => (coordinate(low), coordinate(high)),
            None if !axis.places.is_empty() => (-0.5, axis.places.len() as f64 - 0.5),
            None => padded(shown.map(coordinate), log),
        };
        Self { low, high, log, pixels }
    }

    /// Pixels from the low end; `None` for what cannot be shown.
    pub(crate) fn place(&self, x: f64) -> Option<f64> {
        let x = if self.log { x.log10() } else { x };
        let share = (x - self.low) / (self.high - self.low);
        share.is_finite().then_some(share * self.pixels)
    }

    /// Numbers and where they stand.
    pub(crate) fn ticks(&self) -> Vec<(f64, String)> {
        let values = if self.log { self.decades() } else { self.steps() };
        values
            .into_iter()
            .filter_map(|(value, text)| Some((self.place(value)?, text)))
            .filter(|(place, _)| (-0.5..=self.pixels + 0.5).contains(place))
            .collect()
    }

    fn steps(&self) -> Vec<(f64, String)> {
        let rough = (self.high - self.low) / TICKS;
        let decade = 10_f64.powf(rough.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0]
            .into_iter()
            .map(|factor| factor * decade)
            .find(|step| *step >= rough)
            .unwrap_or(rough);
        let decimals = whole(-step.log10().floor()).clamp(0, 12);
        let decimals = usize::try_from(decimals).unwrap_or(0);
        let (first, last) = (whole((self.low / step).ceil()), whole((self.high / step).floor()));
        (first..=last.min(first + 50))
            .map(|k| (k as f64 * step, format!("{:.decimals$}", k as f64 * step)))
            .collect()
    }

    fn decades(&self) -> Vec<(f64, String)> {
        let (first, last) = (whole(self.low.floor()), whole(self.high.ceil()));
        let every = ((last - first) / 7 + 1).max(1);
        let finer: &[f64] = if self.high - self.low < 1.5 { &[1.0, 2.0, 5.0] } else { &[1.0] };
        (first..=last)
            .filter(|exponent| exponent % every == 0)
            .flat_map(|exponent| {
                finer.iter().map(move |factor| {
                    let value = factor * 10_f64.powf(exponent as f64);
                    let is_plain = (-3..6).contains(&exponent);
                    (value, if is_plain { plain(value) } else { format!("{value:e}") })
                })
            })
            .collect()
    }
}

/// Ends that leave some space; whole decades where a logarithmic axis would have few.
fn padded(values: impl Iterator<Item = f64>, log: bool) -> (f64, f64) {
    let (low, high) =
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
    if low > high {
        return (0.0, 1.0);
    }
    if low == high {
        let half = if log { 0.5 } else { (0.1 * low.abs()).max(f64::MIN_POSITIVE.sqrt()) };
        return (low - half, high + half);
    }
    let margin = MARGIN * (high - low);
    (low - margin, high + margin)
}

fn plain(value: f64) -> String {
    let rounded = (value * 1e9).round() / 1e9;
    format!("{rounded}")
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

    fn texts(axis: &Axis, values: &[f64]) -> Vec<String> {
        let scale = Scale::new(axis, values.iter().copied(), 100.0);
        scale.ticks().into_iter().map(|(_, text)| text).collect()
    }

    #[test]
    fn numbers_at_an_axis_are_round() {
        assert_eq!(texts(&Axis::named("x"), &[0.0, 10.0]), ["0", "2", "4", "6", "8", "10"]);
        assert_eq!(texts(&Axis::named("x"), &[0.0, 0.3]), ["0.00", "0.10", "0.20", "0.30"].map(|s| s[..3].to_owned()));
        assert_eq!(texts(&Axis::log("x"), &[0.01, 10.0]), ["0.01", "0.1", "1", "10"]);
    }

    #[test]
    fn what_cannot_be_shown_has_no_place() {
        let scale = Scale::new(&Axis::log("x"), [0.0, f64::NAN, 1.0, 10.0].into_iter(), 100.0);

        assert_eq!(scale.place(0.0), None);
        assert_eq!(scale.place(f64::NAN), None);
        assert!(scale.place(1.0) < scale.place(10.0));
    }

    #[test]
    fn an_axis_of_one_value_or_none_still_has_a_range() {
        for values in [&[][..], &[0.0], &[5.0], &[f64::NAN]] {
            for axis in [Axis::named("x"), Axis::log("x")] {
                let scale = Scale::new(&axis, values.iter().copied(), 100.0);

                assert!(scale.low < scale.high, "{values:?}");
            }
        }
    }
}
