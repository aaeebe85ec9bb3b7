//! An arm of which one axis after the other is turned, where a search may have missed an angle.

use super::{
    Chain, LEAST_RESIDUAL, SAME, START_ROWS, Search, SearchStage, SearchWatch, refine, score, tell,
};
use crate::{ChainRows, Geometry, Result};
use rayon::prelude::*;

/// The same arm refined with all axes free, and with one of them turned, as long as that leaves clearly
/// less: a start may have missed an arm of other angles by one of them.
///
/// # Errors
/// As [`refine`].
pub fn turned(
    rows: &ChainRows,
    from: &Chain,
    by: &Search,
    watch: SearchWatch<'_>,
) -> Result<Chain> {
    let rows = rows.thinned(START_ROWS);
    let weighed = Search { weighings: 1, ..by.clone() };
    let free = from.geometry.movable();
    let refined = |geometry: Geometry| {
        refine(&rows, &Chain { geometry, ..from.clone() }, &free, &weighed, watch)
    };
    let rank = |chain: &Chain| score(chain, &rows, LEAST_RESIDUAL);
    let mut best = refined(from.geometry.clone())?;
    loop {
        let joints = 1..rows.n_joints();
        let others: Vec<_> = joints.flat_map(|k| best.geometry.turned_each_way(k)).collect();
        let found = others.into_par_iter().filter_map(|geometry| refined(geometry).ok());
        let found = found.min_by(|a, b| rank(a).total_cmp(&rank(b)));
        tell(watch, SearchStage::Round)?;
        match found.filter(|own| rank(own) < rank(&best) - SAME * rows.n_joints() as f64) {
            Some(better) => best = better,
            None => return Ok(best),
        }
    }
}
