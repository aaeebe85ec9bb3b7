//! Chain, rows → joints whose friction remembers the path: Dahl elements beside dry friction (E13).

use super::{LAST_ROWS, School, TRIAL_ROWS};
use crate::beside::{Beside, columns};
use crate::trial::{Recipe, record_worth};
use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use rayon::prelude::*;
use torquewise_model::model::Choice;
use torquewise_rigid::{Chain, fit};
use torquewise_survey::error::IdentifyError;
use torquewise_survey::held_out::{BLOCKS, Trial, mean, split};
use torquewise_survey::survey::thinned;

/// Elements must lower the error of their joint on held-out rows by this part.
const WORTH: f64 = 0.02;
/// Ridges of the friction of a joint, relative to the square of a column: the best one counts.
const RIDGES: [f64; 4] = [1e-4, 1e-3, 1e-2, 1e-1];

impl School<'_> {
    /// Looks, joint by joint, whether friction remembers the path, at what the rest of a chain
    /// leaves of its torque.
    pub(super) fn memory(
        &self,
        recipe: &mut Recipe,
        chain: &Chain,
        choices: &mut Vec<Choice>,
    ) -> Result<(), IdentifyError> {
        let chain = fit(&self.rows(recipe, TRIAL_ROWS)?, chain, &recipe.search)?;
        let rows = self.rows(recipe, LAST_ROWS)?;
        let (m, predicted) = (rows.len(), chain.torque(&rows));
        let motion = thinned(self.motion, LAST_ROWS);
        let own = columns(&recipe.beside, &motion);
        let shares: Vec<Vec<f64>> = (0..rows.n_joints())
            .map(|joint| (0..m).map(|row| self.share(&motion, row, joint)).collect())
            .collect();
        let judged = |joint: usize| -> Vec<(Vec<Beside>, Trial)> {
            let laws: Vec<usize> = (0..recipe.beside.len())
                .filter(|&k| recipe.beside[k].is_friction_of(joint))
                .collect();
            let left: Vec<f64> = (0..m)
                .map(|row| {
                    let rubs: f64 =
                        laws.iter().map(|&k| chain.beside[k] * own[joint][(row, k)]).sum();
                    rows.torque_of(joint)[row] - predicted[joint * m + row] + rubs
                })
                .collect();
            let now: Vec<Beside> = laws.iter().map(|&k| recipe.beside[k].clone()).collect();
            let elements = Beside::friction(self.laws.dahl(joint));
            let with = now.iter().cloned().chain(elements).collect();
            let ways = [("of the velocity alone", now), ("with Dahl elements", with)];
            let judge = |(label, laws): (&str, Vec<Beside>)| {
                let columns = &columns(&laws, &motion)[joint];
                let errors_at = |ridge: &f64| errors(columns, &left, &shares[joint], *ridge);
                let errors = RIDGES.iter().filter_map(errors_at);
                let errors = errors.min_by(|a, b| mean(a).total_cmp(&mean(b)))?;
                let complexity = laws.len();
                Some((laws, Trial { label: label.to_owned(), complexity, errors }))
            };
            ways.into_iter().filter_map(judge).collect()
        };
        let joints: Vec<_> = (0..rows.n_joints()).into_par_iter().map(judged).collect();
        let mut now = self.trials(&[("now".to_owned(), recipe.clone())], &chain, 0)?[0].error();
        for (joint, mut ways) in joints.into_iter().enumerate() {
            let trials: Vec<Trial> = ways.iter().map(|(_, trial)| trial.clone()).collect();
            let what = format!("memory of the friction of {}", self.motion.joints()[joint]);
            let place = record_worth(&what, &trials, WORTH, choices);
            if place == 0 {
                continue;
            }
            let mut with = recipe.clone();
            with.beside.retain(|beside| !beside.is_friction_of(joint));
            with.beside.extend(ways.swap_remove(place).0);
            let ways = [("with".to_owned(), with)];
            let error = self.trials(&ways, &chain, 0)?[0].error();
            if error <= (1.0 - WORTH / rows.n_joints() as f64) * now {
                let [(_, with)] = ways;
                (*recipe, now) = (with, error);
            }
        }
        Ok(())
    }
}

/// What columns leave of a response on each block of time that they were not fitted on, RMS;
/// `None` if nothing can be solved.
///
/// - `shares`: what the square of a row counts
fn errors(columns: &Mat<f64>, response: &[f64], shares: &[f64], ridge: f64) -> Option<Vec<f64>> {
    let p = columns.ncols();
    let root = |row: usize| shares[row].sqrt();
    let of_block = |block: usize| {
        let (held, rest) = split(response.len(), block);
        let own = Mat::from_fn(rest.len(), p, |row, k| root(rest[row]) * columns[(rest[row], k)]);
        let right = Mat::from_fn(rest.len(), 1, |row, _| root(rest[row]) * response[rest[row]]);
        let mut gram = own.transpose() * &own;
        (0..p).for_each(|k| gram[(k, k)] += (ridge * gram[(k, k)]).max(f64::MIN_POSITIVE));
        let solved = gram.llt(Side::Lower).ok()?.solve(own.transpose() * right);
        let left = |&row: &usize| -> f64 {
            response[row] - (0..p).map(|k| columns[(row, k)] * solved[(k, 0)]).sum::<f64>()
        };
        let count: f64 = held.iter().map(|row| shares[*row]).sum();
        let squares: f64 = held.iter().map(|row| shares[*row] * left(row).powi(2)).sum();
        Some((squares / count.max(f64::MIN_POSITIVE)).sqrt())
    };
    (0..BLOCKS).map(of_block).collect()
}
