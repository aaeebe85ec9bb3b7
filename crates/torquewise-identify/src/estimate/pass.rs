//! One pass over every row, in parallel, with the same bits in any order.

use super::linearisation::{Linearisation, shifted};
use faer::Mat;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use torquewise_motion::{Motion, Path, Recording};
use torquewise_regression::normal_sums::FOLDS;
use torquewise_regression::{Alike, BlockSums, NormalSums};
use torquewise_stepwise::IdentifyError;

/// Blocks of time that are read before they are summed, side by side.
const AT_ONCE: usize = 64;

/// A block of time of a log.
struct Block {
    motion: Motion,
    /// What noise of the raw samples became in these rows, if that is known.
    noise: Option<Motion>,
}

/// Adds up the normal equations of a recording at a linearisation (E11), with the bias that noise
/// in its rows leaves in them (E7).
pub(crate) fn add_up(
    recording: &(impl Recording + ?Sized),
    at: &Linearisation,
) -> Result<NormalSums, IdentifyError> {
    let empty = || NormalSums::new(at.n_parameters(), at.n_joints(), FOLDS);
    let lanes = rayon::current_num_threads().max(1);
    let mut sums: Vec<NormalSums> = (0..lanes).map(|_| empty()).collect();
    for log in 0..recording.n_logs() {
        let mut waiting: Vec<Block> = Vec::new();
        let mut path = Path::new(at.n_joints(), &at.travels());
        let mut take = |trajectory, motion: &Motion, noise: Option<&Motion>| {
            let motion = path.follow(trajectory, motion);
            let rows: Vec<usize> = (0..motion.n_rows()).collect();
            waiting.extend(rows.chunks(at.block_rows.max(1)).map(|rows| Block {
                motion: motion.select(rows),
                noise: noise.map(|noise| noise.select(rows)),
            }));
            if waiting.len() >= AT_ONCE {
                flush(&mut waiting, &mut sums, at)?;
            }
            Ok(())
        };
        let mut with_noise =
            |trajectory, motion: &Motion, noise: &Motion| take(trajectory, motion, Some(noise));
        let is_read =
            at.raw_noise && recording.read_log_with_noise(log, at.seed, &mut with_noise)?;
        if !is_read {
            recording.read_log(log, &mut |trajectory, motion| take(trajectory, motion, None))?;
        }
        flush(&mut waiting, &mut sums, at)?;
    }
    let mut all = empty();
    sums.iter().try_for_each(|lane| all.merge(lane))?;
    Ok(all)
}

impl Block {
    /// Stream of random numbers: the same for the same rows, wherever their log stands.
    fn stream(&self) -> u64 {
        let signals = [self.motion.q(), self.motion.dq(), self.motion.ddq()];
        let signals = signals.into_iter().chain(self.motion.tau());
        let values = signals.flat_map(|x| (0..x.ncols()).flat_map(move |j| x.col(j).iter()));
        values.fold(0xcbf2_9ce4_8422_2325, |key: u64, x| {
            (key ^ x.to_bits()).wrapping_mul(0x0000_0100_0000_01b3).rotate_left(29)
        })
    }
}

fn flush(
    waiting: &mut Vec<Block>,
    sums: &mut [NormalSums],
    at: &Linearisation,
) -> Result<(), IdentifyError> {
    let share = waiting.len().div_ceil(sums.len()).max(1);
    waiting.par_chunks(share).zip(sums.par_iter_mut()).try_for_each(|(blocks, sums)| {
        blocks.iter().try_for_each(|block| -> Result<(), IdentifyError> {
            Ok(sums.add(&summed(block, at)?)?)
        })
    })?;
    waiting.clear();
    Ok(())
}

fn summed(block: &Block, at: &Linearisation) -> Result<BlockSums, IdentifyError> {
    let motion = &block.motion;
    let (rows, weights) = at.rows(motion, motion)?;
    let fold = at.regions.of_row(motion, motion.n_rows() / 2);
    let mut sums = BlockSums::new(fold, rows.as_ref(), &weights, (at.n_joints(), Alike::Block));
    let noise = match &block.noise {
        Some(noise) => {
            let (n, signals) = (noise.n_joints(), [noise.q(), noise.dq(), noise.ddq()]);
            Some(Mat::from_fn(noise.n_rows(), 3 * n, |row, j| signals[j / n][(row, j % n)]))
        }
        None => (!at.noise.is_none()).then(|| {
            let mut random = ChaCha8Rng::seed_from_u64(at.seed);
            random.set_stream(block.stream());
            at.noise.draw(&mut random, motion.n_rows())
        }),
    };
    if let Some(noise) = noise {
        for sign in [1.0, -1.0] {
            let (noisy, _) = at.rows(&shifted(motion, &noise, sign)?, motion)?;
            sums.add_noisy(noisy.as_ref(), 0.5);
        }
    }
    Ok(sums)
}
