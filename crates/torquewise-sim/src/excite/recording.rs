//! A planned recording: parts with glides between them, its rows at a rate, and their peaks.

use crate::excite::segment::{Segment, glide};
use crate::state::motion;
use crate::{Bounds, Part, Result, SimError, State, States};
use torquewise_motion::{BLOCK_ROWS, Motion, ReadResult, Recording, Visit, whole};

/// A planned recording: q, q̇ and q̈ from home to home, without torque.
#[derive(Clone, Debug)]
pub struct Planned {
    /// `standstill`, `uniform` or `variable`.
    pub name: &'static str,
    /// How long it takes \[s\].
    pub seconds: f64,
    /// Rows per second.
    pub rate: f64,
    /// The pose at both ends \[rad\], n.
    pub home: Vec<f64>,
    joints: Vec<String>,
    pub(crate) parts: Vec<Part>,
    /// When each begins \[s\], and what it is.
    segments: Vec<(f64, Segment)>,
}

/// Time at rest at the beginning and at the end \[s\].
pub(crate) const REST: f64 = 0.5;
/// Instants between two rows at which limits are checked.
const BETWEEN_ROWS: usize = 5;
/// Roundings of states beside limits.
const ROUNDINGS: f64 = 1e-9;

impl Planned {
    pub(crate) fn new(
        name: &'static str,
        joints: &[String],
        rate: f64,
        home: &[f64],
        parts: Vec<Part>,
        limits: &[Bounds],
    ) -> Self {
        let hold = || Segment::Hold { at: home.to_vec(), seconds: REST };
        let (mut all, mut at) = (vec![hold()], home.to_vec());
        for part in &parts {
            let next = part.anchor();
            all.push(glide(&at, &next, limits));
            all.extend(part.segments());
            at = next;
        }
        all.extend([glide(&at, home, limits), hold()]);
        let (mut segments, mut seconds) = (Vec::with_capacity(all.len()), 0.0);
        for segment in all.into_iter().filter(|segment| segment.seconds() > 0.0) {
            let start = seconds;
            seconds += segment.seconds();
            segments.push((start, segment));
        }
        Self { name, joints: joints.to_vec(), rate, parts, home: home.to_vec(), segments, seconds }
    }

    /// Poses, sweeps or periods of sines in it.
    pub fn n_parts(&self) -> usize {
        self.parts.len()
    }

    /// Number of rows m, the last at or just beyond the end.
    pub fn n_rows(&self) -> usize {
        whole((self.seconds * self.rate).ceil()) + 1
    }

    /// The state at a time \[s\]; at rest at home before and after the recording.
    pub fn state_at(&self, t: f64) -> State {
        let next = self.segments.partition_point(|(start, _)| *start <= t);
        match next.checked_sub(1).and_then(|place| self.segments.get(place)) {
            Some((start, segment)) if t < self.seconds => segment.state_at(t - start),
            _ => State::at_rest(&self.home),
        }
    }

    /// Times \[s\] between which the motion is smooth, the first and last instant among them.
    pub(crate) fn breaks(&self) -> Vec<f64> {
        let inner = |(start, segment): &(f64, Segment)| {
            let start = *start;
            let within = segment.breaks().into_iter().map(move |t| start + t);
            std::iter::once(start).chain(within).collect::<Vec<_>>()
        };
        self.segments.iter().flat_map(inner).chain([self.seconds]).collect()
    }

    pub(crate) fn grid(&self, points: usize) -> States {
        let step = self.seconds / points as f64;
        let at = (0..points).map(|k| self.state_at((k as f64 + 0.5) * step)).collect();
        States { at, seconds: vec![step; points] }
    }

    /// How far each joint goes, at the rows and at four instants between two of them, n, once that is
    /// found within the limits.
    pub(crate) fn peaks(&self, limits: &[Bounds]) -> Result<Vec<Bounds>> {
        let none = [f64::INFINITY, f64::NEG_INFINITY];
        let none = Bounds { position: none, velocity: 0.0, acceleration: 0.0 };
        let mut peaks = vec![none; self.joints.len()];
        let step = 1.0 / (self.rate * BETWEEN_ROWS as f64);
        for instant in 0..self.n_rows() * BETWEEN_ROWS {
            let state = self.state_at(instant as f64 * step);
            for (i, peak) in peaks.iter_mut().enumerate() {
                let [least, greatest] = peak.position;
                peak.position = [least.min(state.q[i]), greatest.max(state.q[i])];
                peak.velocity = peak.velocity.max(state.dq[i].abs());
                peak.acceleration = peak.acceleration.max(state.ddq[i].abs());
            }
        }
        for ((joint, peak), limits) in self.joints.iter().zip(&peaks).zip(limits) {
            let pairs = [
                ("position", -peak.position[0], -limits.position[0]),
                ("position", peak.position[1], limits.position[1]),
                ("velocity", peak.velocity, limits.velocity),
                ("acceleration", peak.acceleration, limits.acceleration),
            ];
            for (what, found, limit) in pairs {
                if found > limit + ROUNDINGS * (1.0 + limit.abs()) {
                    let joint = joint.clone();
                    return Err(SimError::Exceeds { what, joint, found, limit });
                }
            }
        }
        Ok(peaks)
    }

    /// All rows at once.
    ///
    /// # Errors
    /// [`SimError::Motion`] if a number overflows.
    pub fn motion(&self) -> Result<Motion> {
        self.rows(0..self.n_rows())
    }

    fn rows(&self, rows: std::ops::Range<usize>) -> Result<Motion> {
        let t: Vec<f64> = rows.map(|row| row as f64 / self.rate).collect();
        let states: Vec<State> = t.iter().map(|t| self.state_at(*t)).collect();
        motion(&self.joints, t, &states, None)
    }
}

impl Recording for Planned {
    fn joints(&self) -> &[String] {
        &self.joints
    }

    fn read(&self, visit: Visit<'_>) -> ReadResult {
        let m = self.n_rows();
        (0..m)
            .step_by(BLOCK_ROWS)
            .try_for_each(|first| visit(0, &self.rows(first..m.min(first + BLOCK_ROWS))?))
    }
}
