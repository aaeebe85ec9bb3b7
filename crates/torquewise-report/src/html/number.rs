//! Numbers as text: significant digits, aligned at the decimal point.

use serde_json::Value;
use torquewise_motion::ends;

const FIGURE_SPACE: char = '\u{2007}';
/// As wide as a decimal point.
const PUNCTUATION_SPACE: char = '\u{2008}';
/// Between thousands, never at the end of a line.
const NARROW_SPACE: char = '\u{202f}';
const RAISED: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];

/// A number with so many significant digits: `0.0152`, `−12.3`, `1.2·10⁻⁷`, `∞`; `–` for none.
pub fn significant(x: f64, digits: usize) -> String {
    if x.is_nan() {
        return "–".into();
    }
    let sign = if x < 0.0 { "−" } else { "" };
    if x.is_infinite() {
        return format!("{sign}∞");
    }
    if x == 0.0 {
        return "0".into();
    }
    // Rounded first: 9.996 has one digit before the point, its three digits 10.0 have two.
    let scientific = format!("{:.*e}", digits.saturating_sub(1), x.abs());
    let Some((mantissa, exponent)) = scientific.split_once('e') else { return scientific };
    let exponent: i32 = exponent.parse().unwrap_or_default();
    if !(-4..6).contains(&exponent) {
        let raised = |c: char| c.to_digit(10).map_or('⁻', |digit| RAISED[digit as usize]);
        let exponent: String = exponent.to_string().chars().map(raised).collect();
        return format!("{sign}{mantissa}·10{exponent}");
    }
    let digits = i32::try_from(digits).unwrap_or(i32::MAX);
    let decimals = usize::try_from(digits - 1 - exponent).unwrap_or(0);
    format!("{sign}{:.decimals$}", x.abs())
}

/// A count with its thousands set apart.
pub fn count(n: usize) -> String {
    let digits = n.to_string();
    let mut text = String::new();
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && (digits.len() - place).is_multiple_of(3) {
            text.push(NARROW_SPACE);
        }
        text.push(digit);
    }
    text
}

/// Numbers padded on the right so that their decimal points meet when they end at the same place.
/// A cell that is no plain number stays as it is.
pub fn aligned(cells: &[String]) -> Vec<String> {
    let is_number = |cell: &str| {
        !cell.is_empty() && cell.chars().all(|c| c.is_ascii_digit() || "+-−.".contains(c))
    };
    let decimals = |cell: &str| cell.split_once('.').map_or(0, |(_, after)| after.chars().count());
    let numbers = cells.iter().filter(|cell| is_number(cell));
    let most = numbers.map(|cell| decimals(cell)).max().unwrap_or(0);
    let pad = |cell: &String| {
        let mut text = cell.clone();
        if is_number(cell) && most > 0 {
            if !cell.contains('.') {
                text.push(PUNCTUATION_SPACE);
            }
            text.extend(std::iter::repeat_n(FIGURE_SPACE, most - decimals(cell)));
        }
        text
    };
    cells.iter().map(pad).collect()
}

/// Whole numbers up to here are exact.
const LARGEST_WHOLE: f64 = 9e15;

/// A number of a chart: whole ones without a point, none where it is not finite.
fn plotted(x: f64) -> Value {
    if x.fract() == 0.0 && x.abs() < LARGEST_WHOLE {
        #[expect(clippy::cast_possible_truncation, reason = "whole, and below 2^53")]
        return Value::from(x as i64);
    }
    Value::from(x)
}

/// Rounds to six significant digits, of the range of all values where that is the finer.
pub(crate) fn rounded(values: &[f64]) -> Vec<Value> {
    let [low, high] = ends(values.iter().copied().filter(|x| x.is_finite()));
    let of_range = decimals_of(high - low);
    values
        .iter()
        .map(|&x| {
            let decimals = of_range.max(decimals_of(x));
            let Some(decimals) = decimals.filter(|_| x.is_finite()) else { return plotted(x) };
            match usize::try_from(decimals) {
                Ok(decimals) => plotted(format!("{x:.decimals$}").parse().unwrap_or(x)),
                Err(_) => plotted(x.round()),
            }
        })
        .collect()
}

/// Decimals that show six significant digits; none of zero and of what is not finite.
fn decimals_of(x: f64) -> Option<i32> {
    let exponent = x.abs().log10();
    if !exponent.is_finite() {
        return None;
    }
    #[expect(clippy::cast_possible_truncation, reason = "between -324 and 309")]
    let exponent = exponent.floor() as i32;
    Some(5 - exponent)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_keeps_its_significant_digits() {
        let shown = [0.0, 0.015_234, -12.34, 9.996, 1234.0, 1.5e-7, 2e9, f64::INFINITY, f64::NAN]
            .map(|x| significant(x, 3));

        let expected = ["0", "0.0152", "−12.3", "10.0", "1234", "1.50·10⁻⁷", "2.00·10⁹", "∞", "–"];
        assert_eq!(shown, expected);
    }

    #[test]
    fn decimal_points_meet() {
        let cells = ["1.25", "−3", "12.5", "–"].map(String::from);

        let padded = aligned(&cells);

        assert_eq!(padded, ["1.25", "−3\u{2008}\u{2007}\u{2007}", "12.5\u{2007}", "–"]);
    }

    #[test]
    fn late_times_keep_the_digits_that_tell_them_apart() {
        let rounded = rounded(&[1_700_000_000.0, 1_700_000_000.012_5]);

        assert!((rounded[1].as_f64().unwrap() - 1_700_000_000.012_5).abs() < 1e-6, "{rounded:?}");
    }
}
