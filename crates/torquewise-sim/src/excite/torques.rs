//! Torques of the drives that a plan keeps to, and how slow it is to be for them.

use crate::excite::limits::{JointValues, check_rate};
use crate::excite::recording::Planned;
use crate::excite::segment::{Segment, glide};
use crate::{Arm, Bounds, Part, Result, SimError, State, Sweep};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// What the drives can do, and the torque that a motion asks them for.
pub struct Torques {
    joints: Vec<String>,
    /// Largest torque \[N·m\], n; infinite where there is no limit.
    most: Vec<f64>,
    of: TorqueOf,
}

/// The torque \[N·m\] of a state, n.
type TorqueOf = Box<dyn Fn(&State) -> Vec<f64> + Send + Sync>;

/// Points are looked at so many to a segment or harmonic; what lies between them is kept off by
/// planning with so much of the torque.
const POINTS: usize = 16;
const PLANNED: f64 = 0.95;
/// Parts of each kind that are drawn to see whether a speed will do, and how many of those must be
/// within the torques that are so at rest.
const DRAWN: usize = 24;
const ENOUGH: f64 = 0.3;
/// Seconds of the parts that are drawn.
const SECONDS: f64 = 10.0;
/// Speeds that are tried, each a share of the one before.
const SLOWER: f64 = 0.85;
const SPEEDS: usize = 20;

impl Torques {
    /// The torques \[N·m\] of rigid links, without friction; `None` if no limit is given.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn of_arm(arm: &Arm, most: &JointValues<f64>) -> Result<Option<Self>> {
        let own = arm.clone();
        let of = move |state: &State| own.inverse_dynamics(&state.q, &state.dq, &state.ddq);
        Self::new(arm.joints(), most, of)
    }

    /// Limits \[N·m\] of the torque `of` a state; `None` if none is given.
    ///
    /// # Errors
    /// [`SimError`], naming the joint and the number at fault.
    pub fn new(
        joints: &[String],
        most: &JointValues<f64>,
        of: impl Fn(&State) -> Vec<f64> + Send + Sync + 'static,
    ) -> Result<Option<Self>> {
        let given = most.resolve("a torque limit", joints)?;
        for (joint, limit) in joints.iter().zip(&given) {
            limit.map_or(Ok(()), |limit| check_rate("torque limit", joint, limit))?;
        }
        let most = given.iter().map(|limit| limit.unwrap_or(f64::INFINITY)).collect();
        let is_given = given.iter().any(Option::is_some);
        Ok(is_given.then(|| Self { joints: joints.to_vec(), most, of: Box::new(of) }))
    }

    /// Largest torque of each joint, n; infinite where there is no limit.
    pub fn most(&self) -> &[f64] {
        &self.most
    }

    pub(crate) fn keep(&self, segments: &[Segment]) -> bool {
        self.worst(&self.peaks(segments, false)).1 <= PLANNED
    }

    /// Bounds with speeds lowered until parts drawn within them mostly keep the torques, and the
    /// share of the speeds that is left.
    pub(crate) fn slowed(&self, limits: &[Bounds], home: &[f64]) -> Result<(f64, Vec<Bounds>)> {
        let mut speed = 1.0;
        let mut fault = None;
        for _ in 0..SPEEDS {
            let slow: Vec<Bounds> = limits.iter().map(|own| own.slowed(speed)).collect();
            fault = self.fault(&slow, home);
            if fault.is_none() {
                return Ok((speed, slow));
            }
            speed *= SLOWER;
        }
        let (joint, needed) = fault.unwrap_or_default();
        let limit = self.most[joint];
        Err(SimError::Weak { joint: self.joints[joint].clone(), limit, needed })
    }

    /// The joint that keeps a kind of parts from being planned, and the least torque it asks for.
    fn fault(&self, limits: &[Bounds], home: &[f64]) -> Option<(usize, f64)> {
        let mut rng = ChaCha8Rng::seed_from_u64(0);
        let alone = (0..limits.len()).map(Sweep::Fast).map(Some);
        (alone.chain([Some(Sweep::Together), None])).find_map(|sweep| {
            let (mut still, mut moving, mut least) = (0, 0, (0, f64::INFINITY));
            for _ in 0..DRAWN {
                let part = match sweep {
                    Some(kind) => Part::sweep(kind, SECONDS, limits, &mut rng),
                    None => Some(Part::sines(SECONDS, limits, &mut rng)),
                };
                let Some(part) = part else { continue };
                let route = route(home, &part, home, limits);
                let peaks = self.peaks(&route, false);
                let (joint, share) = self.worst(&peaks);
                if share <= least.1 {
                    least = (joint, share);
                }
                still += usize::from(self.worst(&self.peaks(&route, true)).1 <= PLANNED);
                moving += usize::from(share <= PLANNED);
            }
            let enough = moving > 0 && moving as f64 >= ENOUGH * still as f64;
            (!enough).then(|| (least.0, least.1 * self.most[least.0]))
        })
    }

    /// The joint nearest to its limit, and the share of it.
    fn worst(&self, peaks: &[f64]) -> (usize, f64) {
        let shares = peaks.iter().zip(&self.most).map(|(peak, most)| peak / most).enumerate();
        shares.max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or_default()
    }

    /// Largest torque of each joint on a way, or of holding it in each pose of the way, n.
    fn peaks(&self, segments: &[Segment], still: bool) -> Vec<f64> {
        let mut peaks = vec![0.0; self.joints.len()];
        for segment in segments {
            let (seconds, points) = (segment.seconds(), segment.pieces() * POINTS);
            let even = (0..=points).map(|k| seconds * k as f64 / points as f64);
            for t in even.chain(segment.breaks()) {
                let state = segment.state_at(t);
                let state = if still { State::at_rest(&state.q) } else { state };
                self.raise(&mut peaks, &state);
            }
        }
        peaks
    }

    fn raise(&self, peaks: &mut [f64], state: &State) {
        for (peak, torque) in peaks.iter_mut().zip((self.of)(state)) {
            // What cannot be computed keeps to no limit.
            *peak = if torque.is_nan() { f64::INFINITY } else { peak.max(torque.abs()) };
        }
    }

    /// Largest torque of each joint in some recordings, n, once that is found within the limits.
    pub(crate) fn checked(&self, recordings: &[Planned]) -> Result<Vec<f64>> {
        let mut peaks = vec![0.0; self.joints.len()];
        for recording in recordings {
            for row in 0..recording.n_rows() {
                self.raise(&mut peaks, &recording.state_at(row as f64 / recording.rate));
            }
        }
        let (k, share) = self.worst(&peaks);
        if share <= 1.0 {
            return Ok(peaks);
        }
        let (joint, found, limit) = (self.joints[k].clone(), peaks[k], self.most[k]);
        Err(SimError::Exceeds { what: "torque", joint, found, limit })
    }
}

/// A part with the ways to it and on.
pub(crate) fn route(from: &[f64], part: &Part, to: &[f64], limits: &[Bounds]) -> Vec<Segment> {
    let anchor = part.anchor();
    let mut segments = vec![glide(from, &anchor, limits)];
    segments.extend(part.segments());
    segments.push(glide(&anchor, to, limits));
    segments
}
