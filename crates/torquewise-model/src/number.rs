//! Numbers as people read them.

/// A number to four significant digits; a dash for what is no number.
pub fn number(value: f64) -> String {
    let size = value.abs();
    if !value.is_finite() {
        "–".to_owned()
    } else if value == 0.0 {
        "0".to_owned()
    } else if !(1e-4..1e6).contains(&size) {
        format!("{value:.2e}")
    } else {
        let limits = [1e3, 1e2, 1e1, 1.0, 1e-1, 1e-2, 1e-3];
        let decimals = limits.iter().position(|limit| size >= *limit).unwrap_or(limits.len());
        format!("{value:.decimals$}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_four_digits() {
        let shown = [1234.56, 123.456, 1.23456, 0.000_123_456, 1.5e-7, -2.5e9, 0.0, f64::NAN];

        let shown = shown.map(number);

        let expected = ["1235", "123.5", "1.235", "0.0001235", "1.50e-7", "-2.50e9", "0", "–"];
        assert_eq!(shown, expected);
    }
}
