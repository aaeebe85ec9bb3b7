//! As many threads as are asked for and can be had.

use rayon::ThreadPoolBuilder;
use std::env;
use std::thread::available_parallelism;

/// Threads beyond the processors bring nothing; so many cost little.
const MOST: usize = 64;

/// Starts the threads of all work: those of `RAYON_NUM_THREADS`, or one for each processor; fewer
/// where the system does not give so many.
pub(crate) fn start() {
    let asked = env::var("RAYON_NUM_THREADS").ok().and_then(|number| number.trim().parse().ok());
    let own = || available_parallelism().map_or(1, std::num::NonZero::get);
    let mut threads = wanted(asked, own());
    // The one pool of all can be asked for once; these threads have ended when that is done.
    let can_be_had = |threads| {
        let pool = ThreadPoolBuilder::new().num_threads(threads);
        pool.build_scoped(rayon::ThreadBuilder::run, |_| ()).is_ok()
    };
    while threads > 1 && !can_be_had(threads) {
        threads /= 2;
    }
    // Where not even these can be had, the first work says so.
    let _ = ThreadPoolBuilder::new().num_threads(threads).build_global();
}

fn wanted(asked: Option<usize>, own: usize) -> usize {
    asked.filter(|number| *number > 0).unwrap_or(own).min(MOST.max(own))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn b16_numbers_of_threads_are_bounded() {
        assert_eq!(wanted(Some(usize::MAX), 4), MOST);
        assert_eq!(wanted(Some(3), 4), 3);
        assert_eq!((wanted(Some(0), 4), wanted(None, 4)), (4, 4));
    }
}
