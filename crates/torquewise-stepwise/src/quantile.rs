//! The value below which a share of some values lies.

/// The value below which a share of the values lies; zero of none.
pub fn quantile(values: &mut [f64], share: f64) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let last = values.len() - 1;
    // share ≤ 1, so the place is within the slice.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 ≤ share ≤ 1")]
    let place = ((share * last as f64).round() as usize).min(last);
    let (_, value, _) = values.select_nth_unstable_by(place, f64::total_cmp);
    *value
}
