//! Bars with names.

use crate::html::colour::Colour;
use crate::html::markup::Label;
use crate::html::number::significant;

/// Bars with names too long for an axis: terms.
#[derive(Clone, Debug, PartialEq)]
pub struct Bars {
    /// What stands above them.
    pub title: String,
    /// How to read them; may be empty.
    pub caption: String,
    /// What the numbers are, with the unit in brackets.
    pub label: String,
    /// Their colour.
    pub colour: Colour,
    /// Name and size of each, from above. Sizes are not negative; what is not finite has no bar.
    pub rows: Vec<(Label, f64)>,
}

const DIGITS: usize = 3;

impl Bars {
    /// Name of each bar as HTML, its length in percent of the longest, and its number.
    pub(crate) fn drawn(&self) -> Vec<(String, f64, String)> {
        let drawable = |size: &f64| size.is_finite() && *size > 0.0;
        let sizes = self.rows.iter().map(|(_, size)| *size).filter(drawable);
        let most = sizes.fold(0.0, f64::max);
        let bar = |(name, size): &(Label, f64)| {
            let share = if drawable(size) { 100.0 * size / most } else { 0.0 };
            (name.to_string(), (100.0 * share).round() / 100.0, significant(*size, DIGITS))
        };
        self.rows.iter().map(bar).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_longest_bar_is_whole_and_the_others_in_proportion() {
        let rows = [4.0, 1.0, 0.0, f64::NAN].map(|size| ("a".into(), size)).to_vec();
        let (words, colour) = (String::new, Colour::Faded);
        let bars = Bars { title: words(), caption: words(), label: words(), colour, rows };

        let percents: Vec<f64> = bars.drawn().iter().map(|(_, percent, _)| *percent).collect();

        assert_eq!(percents, [100.0, 25.0, 0.0, 0.0]);
    }
}
