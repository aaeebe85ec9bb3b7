//! Pieces of logs at several bandwidths, with the raw torque (E12).

use crate::motion::Memory;
use crate::path::TRAVELS;
use crate::signals::clean::cleaned;
use crate::signals::cutoff::{HIGHEST, LOWEST};
use crate::signals::delay::shift_at;
use crate::signals::plan::OVERSAMPLING;
use crate::signals::smooth::{filter, smooth};
use crate::{Motion, MotionError, Path, Raw, Result, Signal, Signals, whole};
use faer::Mat;

/// Cut-offs at most: that half an octave above each other reach from 0.5 Hz to 500 kHz.
const MOST_CUTOFFS: i32 = 40;
/// Rows that a cut-off leaves at least, those at the ends among them.
const LEAST_LEFT: f64 = 150.0;
const ROWS: usize = 4_000;
/// Part of a piece that is left out at each end, and seconds at most: no filter has settled there.
const ENDS: (f64, f64) = (0.1, 2.0);

/// Time between pieces \[s\], so that none is a neighbour of another.
const APART: f64 = 3_600.0;

/// Delays of the torque that are tried, as multiples of [`DELAY_STEP`].
const DELAYS: std::ops::RangeInclusive<i32> = -8..=12;
/// Step between two delays \[s\].
const DELAY_STEP: f64 = 0.005;

/// Pieces of logs that can pass filters of several bandwidths: what each makes of the motion is
/// seen at the same instants, beside the torque as it was measured but for spikes.
#[derive(Clone, Debug)]
pub struct Bandwidths {
    /// One or more.
    pieces: Vec<Piece>,
}

/// Motion at one bandwidth, beside torque advanced by some delays.
#[derive(Clone, Debug)]
pub struct Band {
    /// Filtered motion, its torque as advanced by the first delay.
    pub motion: Motion,
    /// Torque for each delay, as it is fitted to and as it is to be predicted.
    pub torques: Vec<DelayedTorque>,
}

/// The torque that belongs to a motion if it lags by some delay.
#[derive(Clone, Debug)]
pub struct DelayedTorque {
    /// Seconds by which it lags.
    pub delay: f64,
    /// Filtered as the motion \[N·m\], m×n.
    pub filtered: Mat<f64>,
    /// As it was measured, but for spikes \[N·m\], m×n.
    pub raw: Mat<f64>,
}

#[derive(Clone, Debug)]
struct Piece {
    /// Samples per second \[Hz\].
    rate: f64,
    even: Raw,
    rows: Vec<usize>,
}

impl Bandwidths {
    /// Cleans the pieces. Those that are too short are left out.
    ///
    /// - `pieces`: of logs of one arm, with torque
    ///
    /// # Errors
    /// Those of [`condition`](crate::signals::condition()); [`MotionError::TooFewRows`] if no piece is long
    /// enough.
    pub fn new(pieces: &[Raw]) -> Result<Self> {
        let total: usize = pieces.iter().map(|piece| piece.t.len()).sum();
        let every = total.div_ceil(ROWS).max(1);
        let mut all: Vec<Piece> = Vec::new();
        for raw in pieces {
            let (rate, even) = match cleaned(raw) {
                Ok((base, even)) => (base.timing.rate, even.columns),
                Err(error) if error.is_too_short() => continue,
                Err(error) => return Err(error),
            };
            let m = even.t.len();
            let ends = whole((ENDS.0 * m as f64).min(ENDS.1 * rate));
            let rows = (ends..m.saturating_sub(ends)).step_by(every).collect();
            all.push(Piece { rate, even, rows });
        }
        if all.iter().all(|piece| piece.rows.is_empty()) {
            return Err(MotionError::TooFewRows { rows: total, needed: 4 });
        }
        Ok(Self { pieces: all })
    }

    /// Cut-offs worth trying: from 0.5 Hz, or where enough rows are left, to what the rate allows,
    /// half an octave apart.
    pub fn cutoffs(&self) -> Vec<f64> {
        let rate = self.pieces.iter().map(|piece| piece.rate).fold(f64::INFINITY, f64::min);
        let seconds = |piece: &Piece| piece.even.t.len() as f64 / piece.rate;
        let least = LEAST_LEFT / (OVERSAMPLING * self.pieces.iter().map(seconds).sum::<f64>());
        let all = (0..MOST_CUTOFFS).map(|half| LOWEST * std::f64::consts::SQRT_2.powi(half));
        let mut cutoffs: Vec<f64> = all.take_while(|cutoff| *cutoff <= HIGHEST * rate).collect();
        let few = cutoffs.iter().filter(|cutoff| **cutoff < least).count();
        // Whole octaves, of which one is tried at first.
        cutoffs.split_off((few.min(cutoffs.len().saturating_sub(1)) / 2) * 2)
    }

    /// Delays of the torque worth trying \[s\], ascending.
    pub fn delays(&self) -> Vec<f64> {
        DELAYS.map(|step| f64::from(step) * DELAY_STEP).collect()
    }

    /// Motion and torque filtered at a cut-off \[Hz\], at the rows that are compared, and that
    /// torque advanced by each delay \[s\]; `None` where a piece is too short for it. Pieces are an
    /// hour apart.
    ///
    /// # Errors
    /// Those of [`condition`](crate::signals::condition()).
    pub fn band(&self, cutoff: f64, delays: &[f64]) -> Result<Option<Band>> {
        let (mut seen, mut filtered) = (Vec::new(), Vec::new());
        for piece in &self.pieces {
            let columns = match filter(&piece.even, cutoff, piece.rate) {
                Ok(columns) => columns,
                Err(error) if error.is_too_short() => return Ok(None),
                Err(error) => return Err(error),
            };
            // Few rows are compared of those that friction is followed along.
            let whole = smooth(&columns, &piece.even, piece.rate, 0.0)?;
            let mut path = Path::new(whole.n_joints(), &TRAVELS);
            seen.push(path.follow(0, &whole).select(&piece.rows));
            filtered.push(columns);
        }
        let raw: Vec<&Raw> = self.pieces.iter().map(|piece| &piece.even).collect();
        let filtered: Vec<&Raw> = filtered.iter().collect();
        let delayed = |&delay: &f64| {
            let [filtered, raw] = [&filtered, &raw].map(|columns| self.advanced(columns, delay));
            DelayedTorque { delay, filtered, raw }
        };
        let torques: Vec<DelayedTorque> = delays.iter().map(delayed).collect();
        let joints = &self.pieces[0].even.joints;
        let signals = Motion::joined(joints, &seen)?.into_signals();
        let remembered = seen.iter().filter_map(|part| Some((part, part.memory()?)));
        let mut states = Mat::zeros(self.n_rows(), joints.len() * TRAVELS.len());
        let rows =
            remembered.flat_map(|(part, memory)| (0..part.n_rows()).map(|row| memory.row(row)));
        for (out, own) in rows.enumerate() {
            own.enumerate().for_each(|(k, state)| states[(out, k)] = state);
        }
        let tau = torques.first().map(|torque| torque.filtered.clone());
        let motion = Motion::new(Signals { t: self.stamps(), tau, ..signals })?;
        let motion = motion.with_memory(Some(Memory::new(TRAVELS.to_vec(), states)));
        Ok(Some(Band { motion, torques }))
    }

    fn n_rows(&self) -> usize {
        self.pieces.iter().map(|piece| piece.rows.len()).sum()
    }

    /// Torque at the rows that are compared, advanced by a delay, m×n.
    fn advanced(&self, columns: &[&Raw], delay: f64) -> Mat<f64> {
        let mut out = Mat::zeros(self.n_rows(), self.pieces[0].even.joints.len());
        for joint in 0..out.ncols() {
            let of = |(columns, piece): (&&Raw, &Piece)| {
                let tau = &columns.of(Signal::Tau)[joint];
                shift_at(tau, piece.rate, delay, piece.rows.iter().copied())
            };
            let values = columns.iter().zip(&self.pieces).flat_map(of);
            out.col_as_slice_mut(joint).iter_mut().zip(values).for_each(|(x, value)| *x = value);
        }
        out
    }

    fn stamps(&self) -> Vec<f64> {
        let mut begin = 0.0;
        let mut stamps = Vec::with_capacity(self.n_rows());
        for Piece { even, rows, .. } in &self.pieces {
            let t = &even.t;
            stamps.extend(rows.iter().map(|&row| begin + t[row] - t[0]));
            begin += t[t.len() - 1] - t[0] + APART;
        }
        stamps
    }
}
