//! Parts of a recording: what informs, each at rest in one pose at both ends.

use crate::excite::segment::{Segment, ramp_seconds};
use crate::excite::sines::Sines;
use crate::{Bounds, State, between, direction, log_between, normal};
use rand_chacha::ChaCha8Rng;

/// A part of a recording that begins and ends at rest in the same pose: a pose, held; a way at constant
/// speed, there and back; a period of sines.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Part {
    /// Which joints sweep, if any do.
    pub(crate) sweep: Option<Sweep>,
    pub(crate) there: Segment,
}

/// States at which a part is judged, with the time \[s\] each stands for.
#[derive(Clone, Debug)]
pub(crate) struct States {
    pub(crate) at: Vec<State>,
    pub(crate) seconds: Vec<f64>,
}

/// States at which each way of a sweep is judged.
const SWEEP_POINTS: u8 = 5;
/// Where the first is, in steps: back, the others lie between those of the way there.
const FIRST_POINT: f64 = 0.25;
/// States to a harmonic at which sines are judged.
const POINTS_PER_HARMONIC: usize = 6;
/// Speeds of a sweep as a share of what is planned.
const FAST: [f64; 2] = [0.6, 1.0];
const SLOW: [f64; 2] = [0.15, 0.4];
const ANY: [f64; 2] = [0.2, 1.0];
/// Joints that sweep along with others.
const JOINS: f64 = 0.6;
/// Time at constant speed at least, as a share of speeding up.
const CRUISE: f64 = 2.0;
/// The whole range but for roundings.
const WHOLE: f64 = 1.0 - 1e-9;
/// How far a pose is moved to vary it, as a share of the range.
const VARIATION: [f64; 2] = [0.02, 0.4];
/// Speed of a sweep that still counts as standstill, as a share of what is planned.
pub(crate) const CREEP: f64 = 0.02;

/// Which joints a sweep moves, and how fast.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Sweep {
    Fast(usize),
    Slow(usize),
    /// Several joints, or whatever was drawn.
    Together,
}

impl Part {
    pub(crate) fn pose(seconds: f64, limits: &[Bounds], rng: &mut ChaCha8Rng) -> Self {
        let at = limits.iter().map(|limits| between(rng, limits.position)).collect();
        Self { sweep: None, there: Segment::Hold { at, seconds } }
    }

    pub(crate) fn sines(seconds: f64, limits: &[Bounds], rng: &mut ChaCha8Rng) -> Self {
        Self { sweep: None, there: Segment::Sines(Sines::draw(seconds, limits, rng)) }
    }

    /// A pose passed at a creep in both directions by all joints; `None` if a range is too narrow.
    pub(crate) fn creep(seconds: f64, limits: &[Bounds], rng: &mut ChaCha8Rng) -> Option<Self> {
        let speeds: Vec<f64> =
            limits.iter().map(|limits| CREEP * direction(rng) * limits.velocity).collect();
        let ramp = ramp_seconds(&speeds, limits);
        Self::placed(Sweep::Together, &speeds, [ramp, seconds], limits, rng)
    }

    /// A sweep of at most so many seconds, or as many as it takes to reach and keep its speed.
    pub(crate) fn sweep(
        kind: Sweep,
        most_seconds: f64,
        limits: &[Bounds],
        rng: &mut ChaCha8Rng,
    ) -> Option<Self> {
        let lead = (limits.len() as f64 * between(rng, [0.0, 1.0])).floor();
        let mut speeds = Vec::with_capacity(limits.len());
        for (i, limits) in limits.iter().enumerate() {
            let share = match kind {
                Sweep::Fast(joint) if joint == i => between(rng, FAST),
                Sweep::Slow(joint) if joint == i => between(rng, SLOW),
                Sweep::Together => {
                    let joins = between(rng, [0.0, 1.0]) < JOINS;
                    let share = between(rng, ANY);
                    if joins || (i as f64 - lead).abs() < 0.5 { share } else { 0.0 }
                }
                _ => 0.0,
            };
            let speed: f64 = share * direction(rng) * limits.velocity;
            // What can be reached, kept for a while and left within the range.
            let way = limits.position[1] - limits.position[0];
            let most = (way * limits.acceleration / (1.5 * (1.0 + CRUISE))).sqrt();
            speeds.push(speed.clamp(-most, most));
        }
        let ramp = ramp_seconds(&speeds, limits);
        let shortest = CRUISE * ramp;
        let mut longest = (most_seconds / 2.0 - 2.0 * ramp).max(shortest);
        if ramp <= 0.0 {
            return None;
        }
        for (speed, limits) in speeds.iter_mut().zip(limits).filter(|(speed, _)| **speed != 0.0) {
            // A joint of little range goes along more slowly.
            let way = (limits.position[1] - limits.position[0]) * WHOLE;
            let most = way / (ramp + shortest);
            *speed = speed.clamp(-most, most);
            longest = longest.min((way / speed.abs() - ramp).max(shortest));
        }
        let cruise = log_between(rng, [shortest, longest]);
        Self::placed(kind, &speeds, [ramp, cruise], limits, rng)
    }

    /// A sweep that starts where its way has room.
    fn placed(
        kind: Sweep,
        speeds: &[f64],
        [ramp, cruise]: [f64; 2],
        limits: &[Bounds],
        rng: &mut ChaCha8Rng,
    ) -> Option<Self> {
        let travel: Vec<f64> = speeds.iter().map(|speed| speed * (ramp + cruise)).collect();
        let mut from = Vec::with_capacity(speeds.len());
        for (travel, limits) in travel.iter().zip(limits) {
            from.push(between(rng, room_of(*travel, limits)?));
        }
        Some(Self { sweep: Some(kind), there: Segment::Stroke { from, travel, ramp, cruise } })
    }

    /// A part near this one: of the same joints and as long.
    pub(crate) fn vary(&self, limits: &[Bounds], rng: &mut ChaCha8Rng) -> Option<Self> {
        let share = log_between(rng, VARIATION);
        let mut moved = |at: &f64, [lower, upper]: [f64; 2], span: [f64; 2]| {
            (at + share * (span[1] - span[0]) * normal(rng)).clamp(lower, upper)
        };
        let there = match &self.there {
            Segment::Hold { at, seconds } => {
                let at = at.iter().zip(limits).map(|(q, l)| moved(q, l.position, l.position));
                Segment::Hold { at: at.collect(), seconds: *seconds }
            }
            Segment::Stroke { from, travel, ramp, cruise } => {
                let mut start = Vec::with_capacity(from.len());
                for ((q, travel), limits) in from.iter().zip(travel).zip(limits) {
                    start.push(moved(q, room_of(*travel, limits)?, limits.position));
                }
                let (travel, ramp, cruise) = (travel.clone(), *ramp, *cruise);
                Segment::Stroke { from: start, travel, ramp, cruise }
            }
            Segment::Sines(sines) => Segment::Sines(sines.vary(limits, rng)),
            Segment::Glide { .. } => return None,
        };
        Some(Self { sweep: self.sweep, there })
    }

    pub(crate) fn anchor(&self) -> Vec<f64> {
        match &self.there {
            Segment::Hold { at: from, .. }
            | Segment::Glide { from, .. }
            | Segment::Stroke { from, .. } => from.clone(),
            Segment::Sines(sines) => sines.state_at(0.0).q,
        }
    }

    pub(crate) fn seconds(&self) -> f64 {
        self.segments().iter().map(Segment::seconds).sum()
    }

    pub(crate) fn segments(&self) -> Vec<Segment> {
        let mut segments = vec![self.there.clone()];
        if let Segment::Stroke { from, travel, ramp, cruise } = &self.there {
            let to = from.iter().zip(travel).map(|(from, travel)| from + travel).collect();
            let travel = travel.iter().map(|travel| -travel).collect();
            segments.push(Segment::Stroke { from: to, travel, ramp: *ramp, cruise: *cruise });
        }
        segments
    }

    /// The states it is there for: the pose, the ways at constant speed, the sines; so many times
    /// as many as it takes to compare parts.
    pub(crate) fn states(&self, density: u8) -> States {
        let mut times: Vec<(usize, f64, f64)> = Vec::new();
        match &self.there {
            Segment::Hold { seconds, .. } | Segment::Glide { seconds, .. } => {
                times.push((0, 0.0, *seconds));
            }
            Segment::Stroke { ramp, cruise, .. } => {
                let count = density.saturating_mul(SWEEP_POINTS);
                let step = cruise / f64::from(count);
                for way in 0..2 {
                    let points = (0..count).map(|k| f64::from(k) + FIRST_POINT);
                    times.extend(points.map(|k| (way, ramp + k * step, step)));
                }
            }
            Segment::Sines(sines) => {
                let count = usize::from(density) * POINTS_PER_HARMONIC * sines.harmonics();
                let step = sines.seconds / count as f64;
                times.extend((0..count).map(|k| (0, (k as f64 + 0.5) * step, step)));
            }
        }
        let segments = self.segments();
        let at = times.iter().map(|(segment, t, _)| segments[*segment].state_at(*t));
        States { at: at.collect(), seconds: times.iter().map(|(_, _, step)| *step).collect() }
    }
}

/// Where a way can start so that it stays within its range; `None` if it is too long for it.
fn room_of(travel: f64, limits: &Bounds) -> Option<[f64; 2]> {
    let [lower, upper] = limits.position;
    let room = [lower - travel.min(0.0), upper - travel.max(0.0)];
    // A way as long as the range leaves a room of roundings.
    (room[1] >= room[0]).then_some(room)
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use rand::SeedableRng;

    pub(in crate::excite) const LIMITS: [Bounds; 3] = [
        Bounds { position: [-3.0, 1.0], velocity: 1.0, acceleration: 2.0 },
        Bounds { position: [0.2, 0.5], velocity: 2.0, acceleration: 9.0 },
        Bounds { position: [-1.0, 1.0], velocity: 0.7, acceleration: 1.4 },
    ];

    fn moving(part: &Part) -> Vec<usize> {
        let Segment::Stroke { travel, .. } = &part.there else { panic!("no sweep") };
        (0..3).filter(|&joint| travel[joint] != 0.0).collect()
    }

    #[test]
    fn a_sweep_passes_its_states_in_both_directions_without_acceleration() {
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let sweep = Part::sweep(Sweep::Together, 20.0, &LIMITS, &mut rng).unwrap();

        let states = sweep.states(1);

        let m = states.seconds.len();
        for k in 0..m / 2 {
            for joint in 0..3 {
                let [there, back] = [k, m - 1 - k].map(|row| &states.at[row]);
                let speed = there.dq[joint];
                let places = [there, back].map(|state| state.q[joint].to_bits());
                let moves = speed.abs() > 0.0;
                assert_eq!(places[0] != places[1], moves, "no place is judged twice");
                assert!((speed + back.dq[joint]).abs() < 1e-12);
                assert!(there.ddq[joint].abs() <= 0.0);
            }
        }
    }

    #[test]
    fn a_sweep_takes_no_longer_than_it_may_or_must() {
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        for _ in 0..50 {
            let sweep = Part::sweep(Sweep::Together, 9.0, &LIMITS, &mut rng).unwrap();
            let hasty = Part::sweep(Sweep::Fast(0), 0.1, &LIMITS, &mut rng).unwrap();

            // Speeding up takes at most 0.75 s: there and back, eight times that.
            assert!(sweep.seconds() < 9.0 + 1e-9 && hasty.seconds() < 6.0 + 1e-6);
        }
    }

    #[test]
    fn variations_keep_the_length_and_the_joints() {
        let mut rng = ChaCha8Rng::seed_from_u64(8);
        let parts = [
            Part::pose(0.5, &LIMITS, &mut rng),
            Part::creep(0.5, &LIMITS, &mut rng).unwrap(),
            Part::sweep(Sweep::Slow(1), 12.0, &LIMITS, &mut rng).unwrap(),
            Part::sines(8.0, &LIMITS, &mut rng),
        ];

        for part in parts {
            let varied = part.vary(&LIMITS, &mut rng).unwrap();
            assert_ne!(varied, part);
            assert!((varied.seconds() - part.seconds()).abs() < 1e-12);
            if part.sweep.is_some() {
                assert_eq!(moving(&varied), moving(&part));
            }
        }
    }
}
