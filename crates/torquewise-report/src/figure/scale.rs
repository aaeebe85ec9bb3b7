//! From values of an axis to places in the drawing: its ends, its numbers, even or logarithmic.

use crate::figure::ticks::{Tick, decades, steps};
use crate::figure::words::{SMALL, width};
use crate::html::Axis;
use plotters::coord::combinators::{IntoLogRange, LogCoord};
use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};
use plotters::coord::types::RangedCoordf64;
use std::ops::Range;

/// What is beyond this, or on a logarithmic axis below its inverse, has no place.
const LARGEST: f64 = 1e290;
/// Places are kept to so many lengths of the axis, so that none is infinite.
const FARTHEST: f64 = 1e9;

/// What an axis has to have room for.
pub(crate) struct Needs {
    /// Least and greatest value; the first is greater if there is none.
    pub(crate) extent: [f64; 2],
    /// Space beyond them, as a part of their distance.
    pub(crate) margin: f64,
    /// Whether bars stand on zero.
    pub(crate) from_zero: bool,
    /// Numbers at the axis, at most about.
    pub(crate) ticks: i32,
}

/// An axis that the library can draw.
pub(crate) struct Scale {
    /// Ends; their logarithms on a logarithmic axis.
    ends: [f64; 2],
    log: bool,
    inner: Inner,
    ticks: Vec<Tick>,
}

enum Inner {
    Even(RangedCoordf64),
    Log(LogCoord<f64>),
}

/// Least and greatest of the values an axis can show.
pub(crate) fn extent(axis: &Axis, values: impl Iterator<Item = f64>) -> [f64; 2] {
    let values = values.filter(|value| is_shown(axis.log, *value));
    values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| {
        [low.min(value), high.max(value)]
    })
}

/// Whether an axis can show a value.
pub(crate) fn is_shown(log: bool, value: f64) -> bool {
    if log { (1.0 / LARGEST..LARGEST).contains(&value) } else { value.abs() < LARGEST }
}

impl Scale {
    /// The axis for what it needs, or for the range that is wished.
    pub(crate) fn new(axis: &Axis, needs: &Needs) -> Self {
        let log = axis.log;
        let coordinate = |x: f64| if log { x.log10() } else { x };
        let usable = |[low, high]: &[f64; 2]| {
            is_shown(log, *low)
                && is_shown(log, *high)
                && is_wide(coordinate(*low), coordinate(*high))
        };
        let ends = match axis.range.filter(usable) {
            Some(range) => range.map(coordinate),
            None if !axis.places.is_empty() => [-0.5, axis.places.len() as f64 - 0.5],
            None => padded(needs, log),
        };
        let ticks = match (log, axis.places.is_empty()) {
            (_, false) => Vec::new(),
            (true, true) => decades(ends, needs.ticks, axis.whole),
            (false, true) => steps(ends, needs.ticks, axis.whole),
        };
        let [low, high] = ends;
        let inner = if log {
            Inner::Log((10_f64.powf(low)..10_f64.powf(high)).log_scale().into())
        } else {
            Inner::Even((low..high).into())
        };
        Self { ends, log, inner, ticks }
    }

    /// Where a value stands, from 0 at the low end to 1 at the high one; `None` for what cannot be
    /// shown.
    pub(crate) fn share(&self, value: f64) -> Option<f64> {
        let [low, high] = self.ends;
        let coordinate = if self.log { value.log10() } else { value };
        let share = (coordinate - low) / (high - low);
        is_shown(self.log, value).then_some(share.clamp(-FARTHEST, FARTHEST))
    }

    /// The same the other way.
    pub(crate) fn value(&self, share: f64) -> f64 {
        let [low, high] = self.ends;
        let coordinate = low + share * (high - low);
        if self.log { 10_f64.powf(coordinate) } else { coordinate }
    }

    /// Whether a value lies between the ends.
    pub(crate) fn contains(&self, value: f64) -> bool {
        self.share(value).is_some_and(|share| (0.0..=1.0).contains(&share))
    }

    /// The value, or the end of the axis it is beyond.
    pub(crate) fn clamped(&self, value: f64) -> f64 {
        // What cannot be shown is huge, or too small for a logarithmic axis.
        let beyond = if value > 1.0 { 1.0 } else { 0.0 };
        self.value(self.share(value).unwrap_or(beyond).clamp(0.0, 1.0))
    }

    /// Whether equal steps are equal ratios.
    pub(crate) fn is_log(&self) -> bool {
        self.log
    }

    /// Width of the widest number.
    pub(crate) fn widest(&self) -> i32 {
        self.ticks.iter().map(|(_, text)| width(text, SMALL)).max().unwrap_or(0)
    }
}

impl Ranged for Scale {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        match &self.inner {
            Inner::Even(even) => even.map(value, limit),
            Inner::Log(log) => log.map(value, limit),
        }
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        // A grid without finer lines between those that have numbers.
        let ticks = if hint.weight().allow_light_points() { &[] } else { &*self.ticks };
        ticks.iter().map(|(value, _)| *value).collect()
    }

    fn range(&self) -> Range<f64> {
        self.value(0.0)..self.value(1.0)
    }
}

impl ValueFormatter<f64> for Scale {
    fn format_ext(&self, value: &f64) -> String {
        let tick = self.ticks.iter().find(|(at, _)| at.total_cmp(value).is_eq());
        tick.map_or_else(String::new, |(_, text)| text.clone())
    }
}

/// Whether two ends can be told apart.
fn is_wide(low: f64, high: f64) -> bool {
    high - low > 1e-12 * low.abs().max(high.abs())
}

/// Ends that leave some space.
fn padded(needs: &Needs, log: bool) -> [f64; 2] {
    let [low, high] = needs.extent;
    if low > high {
        return [0.0, 1.0];
    }
    let [low, high] = if log { [low.log10(), high.log10()] } else { [low, high] };
    if !is_wide(low, high) {
        let half = if log { 0.5 } else { 0.1 * low.abs().max(high.abs()) };
        let half = if half > 0.0 { half } else { 1.0 };
        return [low - half, high + half];
    }
    let margin = needs.margin * (high - low);
    // Bars stand on the axis itself.
    let space = |end: f64| if needs.from_zero && end == 0.0 { 0.0 } else { margin };
    [low - space(low), high + space(high)]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scale(axis: &Axis, values: &[f64]) -> Scale {
        let extent = extent(axis, values.iter().copied());
        Scale::new(axis, &Needs { extent, margin: 0.05, from_zero: false, ticks: 6 })
    }

    #[test]
    fn what_cannot_be_shown_has_no_place() {
        let scale = scale(&Axis::log("x"), &[0.0, f64::NAN, 1.0, 10.0]);

        assert_eq!(scale.share(0.0), None);
        assert_eq!(scale.share(f64::NAN), None);
        assert!(scale.share(1.0) < scale.share(10.0));
        assert!(scale.contains(10.0) && !scale.contains(20.0));
    }

    #[test]
    fn an_axis_of_one_value_or_none_still_has_a_range_and_numbers() {
        for values in [&[][..], &[0.0], &[5.0], &[f64::NAN], &[1e300], &[-1e289, 1e289]] {
            for axis in [Axis::named("x"), Axis::log("x")] {
                let scale = scale(&axis, values);

                assert!(scale.ends[0] < scale.ends[1], "{values:?}");
                assert!(scale.ticks.len() > 1, "{values:?}");
            }
        }
    }

    #[test]
    fn a_place_and_its_value_belong_together() {
        for axis in [Axis::named("x"), Axis::log("x")] {
            let scale = scale(&axis, &[0.001, 5.0, 1000.0]);

            let back = scale.value(scale.share(5.0).unwrap());

            assert!((back - 5.0).abs() < 1e-9, "{back}");
        }
    }

    #[test]
    fn a_wished_range_holds_unless_it_is_none() {
        let wished = |range| scale(&Axis { range: Some(range), ..Axis::log("x") }, &[1.0, 100.0]);

        let kept = wished([0.1, 10.0]);
        assert!(kept.contains(0.11) && kept.contains(9.9) && !kept.contains(11.0));
        assert!(wished([0.0, 10.0]).contains(100.0));
        assert!(wished([10.0, 1.0]).contains(100.0));
    }

    #[test]
    fn a_value_beyond_an_end_is_moved_there() {
        let axis = Axis { range: Some([1.0, 100.0]), ..Axis::log("x") };
        let scale = scale(&axis, &[]);

        for (value, expected) in [(-1.0, 1.0), (0.0, 1.0), (10.0, 10.0), (1e300, 100.0)] {
            assert!((scale.clamped(value) - expected).abs() < 1e-9, "{value}");
        }
    }
}
