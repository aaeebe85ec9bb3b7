//! A choice by errors on held-out blocks of time: the simplest near the best.

use torquewise_model::Choice;
use torquewise_model::model::Candidate;

/// Blocks a log is cut into, in time: samples are never shuffled, since neighbours are alike.
pub const BLOCKS: usize = 5;

/// How choices are made, as the model file has it.
pub const RULE: &str = "one standard error, 5 blocks in time";

/// Rows of `count`, those of a block and the others.
pub fn split(count: usize, block: usize) -> (Vec<usize>, Vec<usize>) {
    let edge = |block: usize| block * count / BLOCKS;
    let held: Vec<usize> = (edge(block)..edge(block + 1)).collect();
    let rest = (0..edge(block)).chain(edge(block + 1)..count).collect();
    (held, rest)
}

/// A candidate fit, and its error on each block it was not fitted on.
#[derive(Clone, Debug)]
pub struct CvScore {
    /// As a choice has it on record.
    pub label: String,
    /// Number of coefficients.
    pub complexity: usize,
    /// Error on each block: geometric mean over the joints of RMSE / standard deviation of the
    /// torque.
    pub errors: Vec<f64>,
}

impl CvScore {
    /// Mean error over the blocks.
    pub fn error(&self) -> f64 {
        mean(&self.errors)
    }
}

/// Mean of some values; zero of none.
pub fn mean(x: &[f64]) -> f64 {
    x.iter().sum::<f64>() / x.len().max(1) as f64
}

/// Standard error of a mean.
pub fn standard_error(x: &[f64]) -> f64 {
    let count = x.len() as f64;
    if count < 2.0 {
        return 0.0;
    }
    let mean = mean(x);
    let variance = x.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (count - 1.0);
    (variance / count).sqrt()
}

/// Chooses among trials on the same blocks, simplest first.
///
/// The first that is within one standard error of the best is taken; since all trials see the same
/// blocks, the standard error is that of the difference to the best. Complexity may have a price of
/// its own: a trial also passes for the best if it is worse by no more than `part` of it.
///
/// Returns its place and puts the choice on record; without trials that is 0 and there is none.
pub fn record_worth(what: &str, trials: &[CvScore], part: f64, choices: &mut Vec<Choice>) -> usize {
    let order = |a: &CvScore, b: &CvScore| a.error().total_cmp(&b.error());
    let Some(best) = trials.iter().min_by(|a, b| order(a, b)) else { return 0 };
    let near = |trial: &&CvScore| {
        let pairs = trial.errors.iter().zip(&best.errors);
        let apart = standard_error(&pairs.map(|(a, b)| a - b).collect::<Vec<_>>());
        trial.error() <= best.error() + apart.max(part * best.error())
    };
    let Some(last) = trials.iter().position(|trial| near(&trial)) else { return 0 };
    // Of two, one that is simpler and better may have the smaller error of its difference.
    let place = (0..=last).min_by(|&a, &b| order(&trials[a], &trials[b])).unwrap_or(0);
    let (chosen, from) = (trials[place].label.clone(), listed(trials));
    choices.push(Choice { what: what.into(), chosen, rule: RULE.into(), from });
    place
}

/// Trials as a choice has them on record.
pub fn listed(trials: &[CvScore]) -> Vec<Candidate> {
    let candidate = |trial: &CvScore| Candidate {
        label: trial.label.clone(),
        error: trial.error(),
        std_error: standard_error(&trial.errors),
        complexity: trial.complexity,
    };
    trials.iter().map(candidate).collect()
}

#[cfg(test)]
mod tests {
    use super::{BLOCKS, CvScore, record_worth, split};

    fn trial(label: &str, errors: [f64; BLOCKS]) -> CvScore {
        CvScore { label: label.into(), complexity: 1, errors: errors.to_vec() }
    }

    #[test]
    fn blocks_hold_every_row_once() {
        let mut seen = vec![0; 23];
        for block in 0..BLOCKS {
            let (held, rest) = split(23, block);
            assert_eq!(held.len() + rest.len(), 23);
            for &row in &held {
                seen[row] += 1;
            }
            assert!(held.windows(2).all(|pair| pair[1] == pair[0] + 1));
        }
        assert_eq!(seen, [1; 23]);
    }

    #[test]
    fn the_simplest_near_the_best_is_taken_and_a_gain_too_small_to_be_worth_it_is_left() {
        let both = |[simple, complex]: [[f64; BLOCKS]; 2]| {
            [trial("simple", simple), trial("complex", complex)]
        };
        let near = both([[0.11, 0.09, 0.12, 0.10, 0.08], [0.10, 0.10, 0.10, 0.10, 0.09]]);
        let gain = both([[0.100, 0.200, 0.300, 0.400, 0.500], [0.099, 0.199, 0.299, 0.399, 0.499]]);
        let mut choices = Vec::new();
        assert_eq!(record_worth("x", &near, 0.0, &mut choices), 0);
        let place = record_worth("x", &gain, 0.0, &mut choices);
        assert_eq!((place, choices[1].chosen.as_str()), (1, "complex"), "a gain on every block");
        assert_eq!(record_worth("x", &gain, 0.02, &mut choices), 0);
    }
}
