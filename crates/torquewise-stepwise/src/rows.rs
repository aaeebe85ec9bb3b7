//! Rows of a motion as samples of a regression: q as angles, q̇, q̈ and friction as variables.

use faer::Mat;
use std::borrow::Cow;
use torquewise_model::FrictionTerm;
use torquewise_motion::{BLOCK_ROWS, Motion, MotionError, Pattern};
use torquewise_regression::samples::Samples;

/// The rows of a motion in the words of a regression.
///
/// # Errors
/// [`MotionError::Missing`] if the motion holds no torque.
pub(crate) fn samples_of(
    motion: &Motion,
    friction: &[FrictionTerm],
) -> Result<Samples, MotionError> {
    let n = motion.n_joints();
    let (dq, ddq) = (motion.dq(), motion.ddq());
    let mut samples = Samples {
        angles: motion.q().to_owned(),
        variables: Mat::from_fn(motion.n_rows(), 2 * n + friction.len(), |row, j| match j {
            _ if j < n => dq[(row, j)],
            _ if j < 2 * n => ddq[(row, j - n)],
            _ => 0.0,
        }),
        responses: motion.require_tau()?.to_owned(),
    };
    fill_friction(&mut samples, friction);
    Ok(samples)
}

/// A joint whose speed is this close to its reversal \[s\] is not used where friction is fitted:
/// filters blur the jump of dry friction over about as long.
const REVERSAL: f64 = 0.05;

/// The rows in which no joint is about to turn back, or has just done so; all of them without
/// friction.
pub(crate) fn clear_of_reversals<'a>(
    motion: &'a Motion,
    friction: &[FrictionTerm],
) -> Cow<'a, Motion> {
    let (dq, ddq) = (motion.dq(), motion.ddq());
    let clear = |row: &usize| {
        (0..motion.n_joints()).all(|joint| {
            let (speed, rate) = (dq[(*row, joint)].abs(), ddq[(*row, joint)].abs());
            speed == 0.0 || speed >= REVERSAL * rate
        })
    };
    if friction.is_empty() {
        return Cow::Borrowed(motion);
    }
    Cow::Owned(motion.select(&(0..motion.n_rows()).filter(clear).collect::<Vec<_>>()))
}

/// Values of friction at the speeds of each row, in the last variables.
pub(crate) fn fill_friction(samples: &mut Samples, friction: &[FrictionTerm]) {
    let n = samples.angles.ncols();
    if friction.is_empty() {
        return;
    }
    let mut speeds = vec![0.0; n];
    for row in 0..samples.n_rows() {
        for (joint, speed) in speeds.iter_mut().enumerate() {
            *speed = samples.variables[(row, joint)];
        }
        for (place, law) in friction.iter().enumerate() {
            samples.variables[(row, 2 * n + place)] = law.value(&speeds);
        }
    }
}

/// A block cut into pieces of at most `rows` rows, but not too small to be worth their cost.
pub(crate) fn cut(samples: Samples, rows: usize) -> Vec<Samples> {
    let size = rows.clamp(LEAST_PIECE, BLOCK_ROWS);
    if samples.n_rows() <= size {
        return vec![samples];
    }
    (0..samples.n_rows())
        .step_by(size)
        .map(|start| {
            let count = size.min(samples.n_rows() - start);
            let piece = |x: &Mat<f64>| x.subrows(start, count).to_owned();
            Samples {
                angles: piece(&samples.angles),
                variables: piece(&samples.variables),
                responses: piece(&samples.responses),
            }
        })
        .collect()
}

/// Rows of a piece at least.
const LEAST_PIECE: usize = 16;

/// Rows of one pattern on their way to full blocks.
#[derive(Debug)]
pub(crate) struct Gathering {
    /// Whose rows; `None` for all.
    pattern: Option<Pattern>,
    columns: [Vec<Vec<f64>>; 3],
}

impl Gathering {
    /// - `pattern`: whose rows; `None` for all
    /// - `friction`: number of laws
    pub(crate) fn new(pattern: Option<Pattern>, n_joints: usize, friction: usize) -> Self {
        let empty = |count| vec![Vec::with_capacity(BLOCK_ROWS); count];
        let columns = [empty(n_joints), empty(2 * n_joints + friction), empty(n_joints)];
        Self { pattern, columns }
    }

    /// Adds the rows of its pattern; blocks come out when there are enough.
    pub(crate) fn add(&mut self, samples: &Samples, labels: &[Pattern]) -> Vec<Samples> {
        let wanted = |row: &usize| self.pattern.is_none_or(|pattern| pattern == labels[*row]);
        let rows: Vec<usize> = (0..labels.len()).filter(wanted).collect();
        rows.into_iter().filter_map(|row| self.push(samples, row)).collect()
    }

    fn push(&mut self, samples: &Samples, row: usize) -> Option<Samples> {
        let sources = [&samples.angles, &samples.variables, &samples.responses];
        for (columns, source) in self.columns.iter_mut().zip(sources) {
            for (j, column) in columns.iter_mut().enumerate() {
                column.push(source[(row, j)]);
            }
        }
        (self.len() >= BLOCK_ROWS).then(|| self.take()).flatten()
    }

    /// The rows still held, if any.
    pub(crate) fn take(&mut self) -> Option<Samples> {
        let rows = self.len();
        if rows == 0 {
            return None;
        }
        let [angles, variables, responses] = &mut self.columns;
        let matrix = |columns: &mut Vec<Vec<f64>>| {
            let out = Mat::from_fn(rows, columns.len(), |row, j| columns[j][row]);
            columns.iter_mut().for_each(Vec::clear);
            out
        };
        Some(Samples {
            angles: matrix(angles),
            variables: matrix(variables),
            responses: matrix(responses),
        })
    }

    fn len(&self) -> usize {
        self.columns[0].first().map_or(0, Vec::len)
    }
}
