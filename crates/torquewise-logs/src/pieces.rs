//! Pieces of all trajectories, from which their conditioning is chosen.

use crate::clock::{ClockLane, ClockRepair};
use crate::{LogError, Logs, Result};
use torquewise_motion::{Raw, Signal, quantile};

/// Rows that a trajectory is planned by, and of a piece.
pub(crate) const FIRST_ROWS: usize = 1 << 15;
const MOST_ROWS: usize = 1 << 18;

/// Pieces with corrected time stamps, evenly spread: all rows of short logs, some of long ones.
pub(crate) struct Pieces {
    /// What the clock of all logs asks for.
    pub(crate) clock: ClockRepair,
    pub(crate) all: Vec<Raw>,
    /// The trajectory of each piece.
    trajectories: Vec<usize>,
}

impl Pieces {
    pub(crate) fn read(logs: &Logs) -> Result<Self> {
        let (trajectories, recorded): (Vec<_>, Vec<_>) = recorded(logs)?.into_iter().unzip();
        let clock = ClockRepair::of(&recorded);
        let mend = |piece: Raw| {
            let mut lane = ClockLane::new(clock);
            let mut mended = lane.push(piece).unwrap_or_default();
            mended.append(lane.finish().unwrap_or_default());
            mended
        };
        Ok(Self { clock, all: recorded.into_iter().map(mend).collect(), trajectories })
    }

    /// The longest piece, and its trajectory.
    pub(crate) fn longest(&self) -> Result<(usize, &Raw)> {
        let all = self.trajectories.iter().copied().zip(&self.all);
        all.rev().max_by_key(|(_, piece)| piece.t.len()).ok_or(LogError::NoFiles)
    }

    /// Pieces in which some joints move twice as far as in another, or more, and farthest; with these.
    pub(crate) fn of_most_motion(&self, other: &Raw) -> Vec<(&Raw, Vec<usize>)> {
        let mut found: Vec<_> = self.all.iter().map(|piece| (piece, Vec::new())).collect();
        for joint in 0..other.joints.len() {
            let range = |piece: &Raw| {
                let mut q = piece.of(Signal::Q)[joint].clone();
                // A few wrong positions are no motion.
                let [low, high] = [0.05, 0.95].map(|share| quantile(&mut q, share));
                high - low
            };
            let ranges = self.all.iter().map(range).enumerate();
            let most = ranges.max_by(|a, b| a.1.total_cmp(&b.1));
            if let Some((piece, _)) = most.filter(|(_, most)| *most > 2.0 * range(other)) {
                found[piece].1.push(joint);
            }
        }
        found.retain(|(_, joints)| !joints.is_empty());
        found
    }
}

fn recorded(logs: &Logs) -> Result<Vec<(usize, Raw)>> {
    let (mut kept, mut every, mut count) = (Vec::<(usize, Raw)>::new(), 1, 0);
    let mut open = (0, Raw::default());
    let mut take = |(trajectory, piece): &mut (usize, Raw)| {
        if piece.t.is_empty() {
            return;
        }
        let piece = std::mem::take(piece);
        if count % every == 0 {
            kept.push((*trajectory, piece));
        }
        count += 1;
        let rows: usize = kept.iter().map(|(_, piece)| piece.t.len()).sum();
        if rows > MOST_ROWS && kept.len() > 1 {
            every *= 2;
            kept = std::mem::take(&mut kept).into_iter().step_by(2).collect();
        }
    };
    logs.read_raw(None, &mut |trajectory, block| -> Result<()> {
        if trajectory != open.0 || open.1.t.len() >= FIRST_ROWS {
            take(&mut open);
        }
        open.0 = trajectory;
        open.1.append(block);
        Ok(())
    })?;
    take(&mut open);
    Ok(kept)
}
