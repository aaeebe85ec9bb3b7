//! Positioning moves: dwell, accelerate, cruise and brake, all joints at the same
//! instants.

use super::{ACCELERATION, PEAK_SPEED};
use crate::{State, between, direction};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// Speed of the fastest joint as a share of its peak.
const SPEED_SHARE: [f64; 2] = [0.4, 1.0];
/// Speed of the other joints as a share of the fastest one's: each moves clearly.
const TRAVEL_SHARE: [f64; 2] = [0.3, 1.0];
/// Time of the cruise as a share of accelerating and braking.
const CRUISE_SHARE: [f64; 2] = [0.7, 1.3];
/// Time of the dwell as a share of the move: on average 18 % of the log.
const DWELL_SHARE: [f64; 2] = [0.10, 0.34];
/// How often a joint turns back before its limit; else it would wander about one place.
const TURN_BACK: f64 = 0.25;

/// Positioning and sorting: one move after the other.
#[derive(Clone, Debug)]
pub(crate) struct Moves(Vec<Move>);

/// Times \[s\] of a move's phases.
#[derive(Clone, Copy, Debug)]
struct Phases {
    dwell: f64,
    accelerate: f64,
    cruise: f64,
    brake: f64,
}

#[derive(Clone, Debug)]
struct Move {
    start: f64,
    phases: Phases,
    from: Vec<f64>,
    travel: Vec<f64>,
}

impl Moves {
    pub(crate) fn draw(ranges: &[[f64; 2]], seconds: f64, rng: &mut ChaCha8Rng) -> Self {
        let mut from: Vec<f64> = ranges.iter().map(|&range| between(rng, range)).collect();
        let mut directions: Vec<f64> = ranges.iter().map(|_| direction(rng)).collect();
        let mut moves = Vec::new();
        let mut start = 0.0;
        while start <= seconds {
            let speed = PEAK_SPEED * between(rng, SPEED_SHARE);
            let accelerate = speed / between(rng, ACCELERATION);
            let brake = speed / between(rng, ACCELERATION);
            let cruise = (accelerate + brake) * between(rng, CRUISE_SHARE);
            let dwell = (accelerate + cruise + brake) * between(rng, DWELL_SHARE);
            let phases = Phases { dwell, accelerate, cruise, brake };
            let reach = speed * phases.at_peak_speed();
            // The fastest joint goes as far as it can, the others less, none out of its range.
            let fastest = rng.random_range(0..from.len().max(1));
            let mut travel = Vec::with_capacity(from.len());
            for (i, (&from, &[lower, upper])) in from.iter().zip(ranges).enumerate() {
                let share = if i == fastest { 1.0 } else { between(rng, TRAVEL_SHARE) };
                let room = |way: f64| if way > 0.0 { upper - from } else { from - lower };
                if rng.random_bool(TURN_BACK) {
                    directions[i] = -directions[i];
                }
                if room(directions[i]) < share * reach && room(-directions[i]) > room(directions[i])
                {
                    directions[i] = -directions[i];
                }
                travel.push(directions[i] * (share * reach).min(room(directions[i])));
            }
            let to = from.iter().zip(&travel).map(|(from, travel)| from + travel).collect();
            moves.push(Move { start, phases, from, travel });
            start += phases.total();
            from = to;
        }
        Self(moves)
    }

    pub(crate) fn state_at(&self, t: f64) -> State {
        // The first begins at 0.
        let current = &self.0[self.0.partition_point(|m| m.start <= t) - 1];
        let progress = current.phases.progress(t - current.start);
        State::on_line(&current.from, &current.travel, progress)
    }
}

impl Phases {
    fn total(&self) -> f64 {
        self.dwell + self.accelerate + self.cruise + self.brake
    }

    /// Time \[s\] the whole move would take at its peak speed.
    fn at_peak_speed(&self) -> f64 {
        f64::midpoint(self.accelerate, self.brake) + self.cruise
    }

    /// Share of the move done at time `t` \[s\] after its start, and its two derivatives.
    ///
    /// An instant at which a phase ends belongs to the phase that starts there.
    fn progress(&self, t: f64) -> [f64; 3] {
        let peak = 1.0 / self.at_peak_speed();
        let moved = t - self.dwell;
        let left = self.total() - t;
        if moved < 0.0 {
            [0.0, 0.0, 0.0]
        } else if moved < self.accelerate {
            let rise = peak / self.accelerate;
            [rise * moved * moved / 2.0, rise * moved, rise]
        } else if moved < self.accelerate + self.cruise {
            [peak * (moved - self.accelerate / 2.0), peak, 0.0]
        } else if left > 0.0 {
            let fall = peak / self.brake;
            [1.0 - fall * left * left / 2.0, fall * left, -fall]
        } else {
            [1.0, 0.0, 0.0]
        }
    }
}

#[cfg(test)]
mod tests {
    #![expect(clippy::float_cmp, reason = "halves and quarters are exact")]

    use super::*;

    const PHASES: Phases = Phases { dwell: 1.0, accelerate: 0.5, cruise: 2.0, brake: 0.25 };

    #[test]
    fn a_switching_instant_belongs_to_the_phase_that_starts() {
        let accelerations = [0.999, 1.0, 1.5, 3.5, 3.75].map(|t| PHASES.progress(t)[2]);

        let peak = 1.0 / 2.375;
        assert_eq!(accelerations, [0.0, peak / 0.5, 0.0, -peak / 0.25, 0.0]);
    }
}
