//! Signal → strokes: few enough points to draw, none beyond the panel.

use faer::ColRef;

/// Points in the plane of a panel, to be joined by a line.
pub(crate) type Stroke = Vec<(f64, f64)>;

/// Slots a curve is cut into at most: about two for each point of the width of a page.
const SLOTS: usize = 1_200;

/// The points of a curve that can be seen: of each of [`SLOTS`] stretches of rows the first, the
/// lowest and the highest, and the last row of all.
pub(crate) fn thinned(t: &[f64], values: ColRef<'_, f64>) -> Stroke {
    let m = t.len();
    if m <= 3 * SLOTS {
        return (0..m).map(|row| (t[row], values[row])).collect();
    }
    let mut rows = Vec::with_capacity(3 * SLOTS + 1);
    for slot in 0..SLOTS {
        let (first, end) = (slot * m / SLOTS, (slot + 1) * m / SLOTS);
        let by_value = |a: &usize, b: &usize| values[*a].total_cmp(&values[*b]);
        let lowest = (first..end).min_by(by_value).unwrap_or(first);
        let highest = (first..end).max_by(by_value).unwrap_or(first);
        rows.extend([first, lowest.min(highest), lowest.max(highest)]);
    }
    rows.push(m - 1);
    rows.dedup();
    rows.into_iter().map(|row| (t[row], values[row])).collect()
}

/// The parts of a line that lie within `low` … `high`, cut where it leaves.
pub(crate) fn clipped(line: &[(f64, f64)], [low, high]: [f64; 2]) -> Vec<Stroke> {
    let mut strokes: Vec<Stroke> = Vec::new();
    let mut inside = false;
    for pair in line.windows(2) {
        let Some((from, to)) = cut(pair[0], pair[1], low, high) else {
            inside = false;
            continue;
        };
        match strokes.last_mut().filter(|_| inside) {
            Some(stroke) => stroke.push(to),
            None => strokes.push(vec![from, to]),
        }
        inside = (low..=high).contains(&pair[1].1);
    }
    strokes
}

/// The part of a straight line from `a` to `b` between two heights.
fn cut(a: (f64, f64), b: (f64, f64), low: f64, high: f64) -> Option<((f64, f64), (f64, f64))> {
    if a.1.max(b.1) < low || a.1.min(b.1) > high {
        return None;
    }
    let at = |height: f64| (a.0 + (b.0 - a.0) * ((height - a.1) / (b.1 - a.1)), height);
    let within = |point: (f64, f64)| match point.1 {
        y if y < low => at(low),
        y if y > high => at(high),
        _ => point,
    };
    Some((within(a), within(b)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use faer::Col;

    #[test]
    fn a_long_curve_keeps_its_peaks_and_ends() {
        let t: Vec<f64> = (0..100_000).map(f64::from).collect();
        let mut values = Col::<f64>::zeros(t.len());
        (values[777], values[50_001]) = (9.0, -7.0);

        let thin = thinned(&t, values.as_ref());

        assert!(thin.len() <= 3 * SLOTS + 1);
        assert!(thin.contains(&(777.0, 9.0)) && thin.contains(&(50_001.0, -7.0)));
        assert_eq!((thin[0].0, thin[thin.len() - 1].0), (0.0, 99_999.0));
        assert!(thin.windows(2).all(|pair| pair[0].0 < pair[1].0), "in order of time");
    }

    #[test]
    fn a_line_is_cut_where_it_leaves_and_taken_up_where_it_returns() {
        let line = [(0.0, 0.0), (1.0, 4.0), (2.0, 0.0), (3.0, -4.0), (4.0, -4.0)];

        let strokes = clipped(&line, [-1.0, 1.0]);

        let up = vec![(0.0, 0.0), (0.25, 1.0)];
        let down = vec![(1.75, 1.0), (2.0, 0.0), (2.25, -1.0)];
        assert_eq!(strokes, [up, down]);
    }

    #[test]
    fn a_line_through_the_panel_is_cut_at_both_edges() {
        let strokes = clipped(&[(0.0, -2.0), (1.0, 2.0)], [-1.0, 1.0]);

        assert_eq!(strokes, [vec![(0.25, -1.0), (0.75, 1.0)]]);
    }
}
