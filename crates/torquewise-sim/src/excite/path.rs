//! From parts to path: glides between them, from home and back; the state at any time.

use crate::excite::limits::Bounds;
use crate::excite::part::Part;
use crate::excite::segment::{Segment, glide, glide_seconds};
use crate::state::State;

/// A whole recording from home to home.
#[derive(Clone, Debug)]
pub(crate) struct Path {
    home: Vec<f64>,
    /// When each begins \[s\], and what it is.
    segments: Vec<(f64, Segment)>,
    seconds: f64,
}

/// Time at rest at the beginning and at the end \[s\].
pub(crate) const REST: f64 = 0.5;

/// Time \[s\] that parts take with the glides between them.
pub(crate) fn seconds_of<'a>(
    home: &[f64],
    parts: impl IntoIterator<Item = &'a Part>,
    limits: &[Bounds],
) -> f64 {
    let (mut seconds, mut at) = (2.0 * REST, home.to_vec());
    for part in parts {
        let next = part.anchor();
        seconds += glide_seconds(&at, &next, limits) + part.seconds();
        at = next;
    }
    seconds + glide_seconds(&at, home, limits)
}

impl Path {
    /// Puts parts in a row.
    pub(crate) fn new(home: &[f64], parts: &[Part], limits: &[Bounds]) -> Self {
        let rest = || Segment::Hold { at: home.to_vec(), seconds: REST };
        let mut path = Self { home: home.to_vec(), segments: Vec::new(), seconds: 0.0 };
        path.append(rest());
        let mut at = home.to_vec();
        for part in parts {
            let next = part.anchor();
            path.append(glide(&at, &next, limits));
            for segment in part.segments() {
                path.append(segment);
            }
            at = next;
        }
        path.append(glide(&at, home, limits));
        path.append(rest());
        path
    }

    fn append(&mut self, segment: Segment) {
        let seconds = segment.seconds();
        if seconds > 0.0 {
            self.segments.push((self.seconds, segment));
            self.seconds += seconds;
        }
    }

    /// How long it takes \[s\].
    pub(crate) fn seconds(&self) -> f64 {
        self.seconds
    }

    /// The pose at both ends, n.
    pub(crate) fn home(&self) -> &[f64] {
        &self.home
    }

    /// Writes the state at a time \[s\]; at rest at home before and after.
    pub(crate) fn state_at(&self, t: f64, state: &mut State) {
        let next = self.segments.partition_point(|(start, _)| *start <= t);
        match next.checked_sub(1).and_then(|place| self.segments.get(place)) {
            Some((start, segment)) if t < self.seconds => segment.state_at(t - start, state),
            _ => *state = State::at_rest(&self.home),
        }
    }

    /// Times \[s\] at which something else begins, the first and the last instant among them.
    pub(crate) fn breaks(&self) -> Vec<f64> {
        let inner = |(start, segment): &(f64, Segment)| {
            let start = *start;
            let within = segment.breaks().into_iter().map(move |t| start + t);
            std::iter::once(start).chain(within).collect::<Vec<_>>()
        };
        self.segments.iter().flat_map(inner).chain([self.seconds]).collect()
    }
}
