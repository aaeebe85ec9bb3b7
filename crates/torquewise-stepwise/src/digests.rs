//! Trajectories that are known again.

use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use torquewise_motion::Motion;

/// Digests that are kept.
const MOST: usize = 64;
/// Of the hash of Fowler, Noll and Vo.
const BASIS: u32 = 0x811c_9dc5;
const PRIME: u32 = 0x0100_0193;

/// A number for the positions of each trajectory, by which a log that a model was fitted to is known
/// again. Of many the least are kept, so that logs add up in any order.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Digests {
    whole: BTreeSet<u32>,
    /// The trajectory of the last block, and its digest so far.
    #[serde(skip)]
    open: Option<(usize, u32)>,
}

impl Digests {
    /// Adds the next block of a log.
    pub fn add(&mut self, trajectory: usize, block: &Motion) {
        let (_, before) = self.open.filter(|(own, _)| *own == trajectory).unwrap_or_else(|| {
            self.close();
            (trajectory, BASIS)
        });
        let q = block.q();
        let numbers = (0..q.nrows()).flat_map(|row| q.row(row).iter());
        let digest = numbers
            .flat_map(|number| number.to_bits().to_le_bytes())
            .fold(before, |digest, byte| (digest ^ u32::from(byte)).wrapping_mul(PRIME));
        self.open = Some((trajectory, digest));
    }

    /// Ends the trajectory: what comes is of another log.
    pub fn close(&mut self) {
        self.whole.extend(self.open.take().map(|(_, digest)| digest));
        while self.whole.len() > MOST {
            self.whole.pop_last();
        }
    }

    /// Adds those of other logs.
    pub fn merge(&mut self, other: &Self) {
        self.close();
        self.whole.extend(other.least());
        self.close();
    }

    /// The digests, ascending.
    pub fn least(&self) -> Vec<u32> {
        let mut own = self.clone();
        own.close();
        own.whole.into_iter().collect()
    }
}
