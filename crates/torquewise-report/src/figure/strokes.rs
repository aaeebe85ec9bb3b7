//! From points to strokes: the parts of a line that can be seen.

/// A place in the unit square of the axes.
pub(crate) type Place = [f64; 2];

/// The parts of a line that lie within the unit square, cut where it leaves. A point without place
/// is a gap; one alone between two gaps is a stroke of one point.
pub(crate) fn strokes(places: impl Iterator<Item = Option<Place>>) -> Vec<Vec<Place>> {
    let mut strokes: Vec<Vec<Place>> = Vec::new();
    let mut last: Option<Place> = None;
    // Whether the last stroke ends at the last point.
    let mut is_open = false;
    for place in places {
        let part = match (last, place) {
            (Some(last), Some(place)) => cut(last, place).map(|(from, to)| vec![from, to]),
            (None, Some(place)) => is_inside(place).then(|| vec![place]),
            _ => None,
        };
        match (part, strokes.last_mut()) {
            (Some(part), Some(stroke)) if is_open => stroke.extend_from_slice(&part[1..]),
            (Some(part), _) => strokes.push(part),
            _ => {}
        }
        is_open = place.is_some_and(is_inside);
        last = place;
    }
    strokes
}

fn is_inside(place: Place) -> bool {
    place.iter().all(|share| (0.0..=1.0).contains(share))
}

/// The part of a straight line from `a` to `b` within the unit square (Liang and Barsky).
fn cut(a: Place, b: Place) -> Option<(Place, Place)> {
    let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
    for (from, to) in a.into_iter().zip(b) {
        let run = to - from;
        if run == 0.0 {
            if !(0.0..=1.0).contains(&from) {
                return None;
            }
            continue;
        }
        let (one, other) = (-from / run, (1.0 - from) / run);
        enter = enter.max(one.min(other));
        leave = leave.min(one.max(other));
    }
    let at = |part: f64| [0, 1].map(|axis: usize| a[axis] + part * (b[axis] - a[axis]));
    (enter <= leave).then(|| (at(enter), if leave < 1.0 { at(leave) } else { b }))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(places: &[Place]) -> Vec<Vec<Place>> {
        let places = places.iter().map(|place| place[1].is_finite().then_some(*place));
        strokes(places)
    }

    #[test]
    fn a_line_is_cut_where_it_leaves_and_taken_up_where_it_returns() {
        let line = [[0.0, 0.5], [0.25, 2.5], [0.5, 0.5], [0.75, -1.5], [1.0, -1.5]];

        let up = vec![[0.0, 0.5], [0.0625, 1.0]];
        let down = vec![[0.4375, 1.0], [0.5, 0.5], [0.5625, 0.0]];
        assert_eq!(of(&line), [up, down]);
    }

    #[test]
    fn a_line_through_all_is_cut_at_each_edge() {
        assert_eq!(of(&[[0.0, -1.0], [1.0, 3.0]]), [vec![[0.25, 0.0], [0.5, 1.0]]]);
        assert_eq!(of(&[[-1.0, 0.5], [3.0, 0.5]]), [vec![[0.0, 0.5], [1.0, 0.5]]]);
        assert!(of(&[[-1.0, 2.0], [3.0, 2.0]]).is_empty());
    }

    #[test]
    fn a_gap_parts_a_line() {
        let gap = [0.3, f64::NAN];
        let line = [[0.0, 0.5], [0.2, 0.5], gap, [0.4, 0.5], gap, [0.6, 0.5], [0.8, 2.0]];

        let strokes = of(&line);

        assert_eq!(strokes.iter().map(Vec::len).collect::<Vec<_>>(), [2, 1, 2]);
    }
}
