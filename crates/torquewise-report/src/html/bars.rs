//! From named sizes to bars beside their names, longest first or as given.

use crate::html::colour::Colour;
use crate::html::markup::Label;
use crate::html::number::significant;

/// Bars with names too long for an axis: terms, methods, joints.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Bars {
    /// What stands above them.
    pub title: String,
    /// How to read them; may be empty.
    pub caption: String,
    /// What the numbers are, with the unit in brackets.
    pub label: String,
    /// Names and colours of the bars of one row; a legend tells them apart if they are several.
    pub series: Vec<(String, Colour)>,
    /// The rows, from above.
    pub rows: Vec<BarRow>,
    /// Whether equal steps of length are equal ratios; the shortest bar is then a stub.
    pub log: bool,
}

/// One name, and one size for each series.
#[derive(Clone, Debug, PartialEq)]
pub struct BarRow {
    /// Its name.
    pub name: Label,
    /// Sizes, not negative; what is not finite has no bar.
    pub sizes: Vec<f64>,
}

/// A bar as the page draws it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Bar {
    /// Length in percent of the longest.
    pub(crate) percent: f64,
    pub(crate) colour: String,
    pub(crate) number: String,
}

/// Length of the shortest bar of a logarithmic scale, in percent.
const STUB: f64 = 8.0;
const DIGITS: usize = 3;

impl Bars {
    /// Name of each row as HTML, and its bars.
    pub(crate) fn drawn(&self) -> Vec<(String, Vec<Bar>)> {
        let sizes = self.rows.iter().flat_map(|row| &row.sizes).copied();
        let [least, most] = sizes
            .filter(|size| size.is_finite() && *size > 0.0)
            .fold([f64::INFINITY, 0.0_f64], |[low, high], size| [low.min(size), high.max(size)]);
        let percent = |size: f64| {
            let share = if !size.is_finite() || size <= 0.0 {
                0.0
            } else if self.log && most > least {
                STUB + (100.0 - STUB) * (size / least).ln() / (most / least).ln()
            } else {
                100.0 * size / most
            };
            (100.0 * share).round() / 100.0
        };
        let bar = |(place, &size): (usize, &f64)| Bar {
            percent: percent(size),
            colour: self.series.get(place).map_or(Colour::Faded, |series| series.1).variable(),
            number: significant(size, DIGITS),
        };
        self.rows
            .iter()
            .map(|row| (row.name.to_html(), row.sizes.iter().enumerate().map(bar).collect()))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn percents(sizes: &[f64], log: bool) -> Vec<f64> {
        let row = |&size: &f64| BarRow { name: "a".into(), sizes: vec![size] };
        let bars = Bars { rows: sizes.iter().map(row).collect(), log, ..Bars::default() };
        bars.drawn().into_iter().map(|(_, bars)| bars[0].percent).collect()
    }

    #[test]
    fn the_longest_bar_is_whole_and_the_others_in_proportion() {
        assert_eq!(percents(&[4.0, 1.0, 0.0, f64::NAN], false), [100.0, 25.0, 0.0, 0.0]);
    }

    #[test]
    fn a_logarithmic_bar_grows_with_the_ratio() {
        assert_eq!(percents(&[1.0, 10.0, 100.0], true), [8.0, 54.0, 100.0]);
        assert_eq!(percents(&[3.0], true), [100.0]);
    }
}
