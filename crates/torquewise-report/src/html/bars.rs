//! Bars with names.

use crate::html::colour::Colour;
use crate::html::markup::Label;
use crate::significant;
use minijinja::{Value, context};

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
    /// What the template of bars is filled with: the length of each in percent of the longest.
    pub(crate) fn view(&self) -> Value {
        let drawable = |size: &f64| size.is_finite() && *size > 0.0;
        let sizes = self.rows.iter().map(|(_, size)| *size).filter(drawable);
        let most = sizes.fold(0.0, f64::max);
        let row = |(name, size): &(Label, f64)| {
            let share = if drawable(size) { 100.0 * size / most } else { 0.0 };
            let percent = (100.0 * share).round() / 100.0;
            context! { name, percent, number => significant(*size, DIGITS) }
        };
        context! {
            title => self.title.as_str(),
            caption => self.caption.as_str(),
            label => self.label.as_str(),
            colour => self.colour.variable(),
            rows => self.rows.iter().map(row).collect::<Vec<_>>(),
        }
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

        let rows = bars.view().get_attr("rows").unwrap();

        let percents: Vec<Value> =
            rows.try_iter().unwrap().map(|row| row.get_attr("percent").unwrap()).collect();
        assert_eq!(percents, [100.0, 25.0, 0.0, 0.0].map(Value::from));
    }
}
