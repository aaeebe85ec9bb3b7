//! Exact sums: fixed point of 192 bits, the same bits in whatever order numbers are added.

use crate::{Result, SparseError, expect};
use serde::{Deserialize, Serialize};

/// Sums of floating-point numbers without rounding.
///
/// Each entry is an integer multiple of 2⁻¹⁰⁴ (5e-32) below 2⁸⁷ (1e26) in size, so that adding is
/// associative: parts of a sum add up to the same bits in any order. What a number has below the
/// last place is rounded off before it is added, from that number alone.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct ExactSums {
    entries: Vec<Words>,
}

/// Two's complement: the upper 128 bits with the sign, and the lowest 64. Next to no bytes are written
/// where sums are small.
type Words = (i128, u64);

/// The last place is worth 2 to the power of −`LAST`.
const LAST: i32 = 104;
/// A number of 53 bits may be shifted by this much and leaves room for 2¹⁷ of its size.
const LARGEST_SHIFT: i32 = 192 - 1 - 53 - 17;

impl ExactSums {
    /// Sums of nothing.
    pub fn zeros(count: usize) -> Self {
        Self { entries: vec![(0, 0); count] }
    }

    /// Number of sums.
    pub fn count(&self) -> usize {
        self.entries.len()
    }

    /// Adds a number to each sum from `first` on.
    ///
    /// # Errors
    /// [`SparseError::OutOfRange`] for a number that is not finite or too large,
    /// [`SparseError::Shape`] if there are more numbers than sums.
    pub fn add(&mut self, first: usize, values: &[f64]) -> Result<()> {
        let own = self.entries.iter_mut().skip(first).zip(values);
        expect("numbers to be summed", values.len(), own.len())?;
        // Adding nothing changes nothing, and a parameter of one joint is nothing at many others.
        for (sum, &found) in own.filter(|(_, found)| **found != 0.0) {
            let total = words(found).and_then(|words| added(*sum, words));
            *sum = total.ok_or(SparseError::OutOfRange { found })?;
        }
        Ok(())
    }

    /// Adds the sums of another.
    ///
    /// # Errors
    /// [`SparseError::Shape`] if the other has another number of sums,
    /// [`SparseError::OutOfRange`] if one becomes too large.
    pub fn merge(&mut self, other: &Self) -> Result<()> {
        expect("a table of sums", other.count(), self.count())?;
        for (sum, more) in self.entries.iter_mut().zip(&other.entries) {
            let too_large = || SparseError::OutOfRange { found: rounded(*more) };
            *sum = added(*sum, *more).ok_or_else(too_large)?;
        }
        Ok(())
    }

    /// One sum, rounded.
    pub fn value(&self, place: usize) -> f64 {
        self.entries.get(place).map_or(0.0, |words| rounded(*words))
    }

    /// One sum as that of two numbers, the second what rounding takes from the first.
    pub fn pair(&self, place: usize) -> [f64; 2] {
        let high = self.value(place);
        let rest = words(-high).and_then(|high| added(self.entries[place], high));
        [high, rest.map_or(0.0, rounded)]
    }
}

/// A number in fixed point; `None` if it is too large or none.
fn words(value: f64) -> Option<Words> {
    let bits = value.to_bits();
    let exponent = i32::from(u16::try_from((bits >> 52) & 0x7ff).ok()?);
    let fraction = bits & ((1 << 52) - 1);
    let mut digits = if exponent == 0 { fraction } else { fraction | (1 << 52) };
    let mut shift = exponent.max(1) - 1075 + LAST;
    if shift < 0 {
        digits = if shift < -63 { 0 } else { (digits + (1 << (-shift - 1))) >> -shift };
        shift = 0;
    }
    if shift > LARGEST_SHIFT {
        return None;
    }
    let wide = u128::from(digits) << (shift % 64);
    let size = match shift / 64 {
        0 => ((wide >> 64).cast_signed(), low_word(wide)),
        _ => (wide.cast_signed(), 0),
    };
    Some(if bits >> 63 == 0 { size } else { negated(size) })
}

fn negated((upper, low): Words) -> Words {
    ((!upper).wrapping_add(i128::from(low == 0)), low.wrapping_neg())
}

/// The sum of two; `None` if it does not fit.
fn added(one: Words, other: Words) -> Option<Words> {
    let (low, carry) = one.1.overflowing_add(other.1);
    let upper = one.0.checked_add(other.0)?.checked_add(i128::from(carry))?;
    Some((upper, low))
}

fn rounded(words: Words) -> f64 {
    let negative = words.0 < 0;
    let (upper, low) = if negative { negated(words) } else { words };
    let (upper, word) = (upper.cast_unsigned(), 2.0_f64.powi(64));
    let [middle, high] = [upper, upper >> 64].map(|wide| low_word(wide) as f64);
    let size = ((high * word + middle) * word + low as f64) * 2.0_f64.powi(-LAST);
    if negative { -size } else { size }
}

#[expect(clippy::cast_possible_truncation, reason = "the low half is what is wanted")]
fn low_word(wide: u128) -> u64 {
    wide as u64
}

#[cfg(test)]
mod tests {
    use super::ExactSums;
    use proptest::prelude::*;

    fn sum(values: &[f64]) -> ExactSums {
        let mut sums = ExactSums::zeros(1);
        for value in values {
            sums.add(0, &[*value]).unwrap();
        }
        sums
    }

    #[test]
    fn what_cancels_leaves_the_rest_whole() {
        let tiny = 2.0_f64.powi(-60);
        let [high, low] = sum(&[1e20, 1.0, -1e20, tiny]).pair(0).map(f64::to_bits);
        assert_eq!([high, low], [1.0_f64.to_bits(), tiny.to_bits()]);
        assert_eq!(sum(&[0.1, -0.1]).value(0).to_bits(), 0);
    }

    #[test]
    fn a_number_out_of_range_and_a_sum_that_grows_too_large_are_refused() {
        for bad in [f64::NAN, f64::INFINITY, 1e30, -1e300] {
            assert!(ExactSums::zeros(1).add(0, &[bad]).is_err(), "{bad}");
        }
        assert!(ExactSums::zeros(1).add(1, &[1.0]).is_err(), "no such sum");
        let mut sums = sum(&[4e20]);
        let doubled = (0..30).try_for_each(|_| {
            let twice = sums.clone();
            sums.merge(&twice)
        });
        assert!(doubled.is_err());
    }

    proptest! {
        #[test]
        fn order_and_split_do_not_matter(
            mut values in prop::collection::vec(-1e12..1e12_f64, 1..40), cut in 0_usize..40
        ) {
            let whole = sum(&values);
            let cut = cut.min(values.len());
            values.reverse();
            let (left, right) = values.split_at(cut);
            let mut parts = sum(right);
            parts.merge(&sum(left)).unwrap();
            prop_assert_eq!(&parts, &whole);
            // Small enough for 128 bits at the same last place: the sum by another arithmetic.
            let scale = 2.0_f64.powi(60);
            #[expect(clippy::cast_possible_truncation, reason = "below 2¹⁰⁰")]
            let exact: i128 = values.iter().map(|x| (x * scale) as i128).sum();
            let error = (whole.value(0) - exact as f64 / scale).abs();
            prop_assert!(error <= 1e-15 * whole.value(0).abs() + 40.0 / scale);
            let bytes = postcard::to_stdvec(&whole).unwrap();
            prop_assert_eq!(postcard::from_bytes::<ExactSums>(&bytes).unwrap(), whole);
        }
    }
}
