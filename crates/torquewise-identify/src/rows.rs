//! Motion → samples: q as angles, q̇ and q̈ as variables, τ as responses, rows sorted by pattern.

use faer::Mat;
use torquewise_motion::{BLOCK_ROWS, Motion, MotionError};
use torquewise_sparse::samples::Samples;

/// The rows of a motion in the words of a regression.
///
/// # Errors
/// [`MotionError::Missing`] if the motion holds no torque.
pub(crate) fn samples_of(motion: &Motion) -> Result<Samples, MotionError> {
    let n = motion.n_joints();
    let (dq, ddq) = (motion.dq(), motion.ddq());
    Ok(Samples {
        angles: motion.q().to_owned(),
        variables: Mat::from_fn(motion.n_rows(), 2 * n, |row, j| {
            if j < n { dq[(row, j)] } else { ddq[(row, j - n)] }
        }),
        responses: motion.require_tau()?.to_owned(),
    })
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
    columns: [Vec<Vec<f64>>; 3],
}

impl Gathering {
    pub(crate) fn new(n_joints: usize) -> Self {
        let empty = |count| vec![Vec::with_capacity(BLOCK_ROWS); count];
        Self { columns: [empty(n_joints), empty(2 * n_joints), empty(n_joints)] }
    }

    /// Adds a row; a block comes out when there are enough.
    pub(crate) fn push(&mut self, samples: &Samples, row: usize) -> Option<Samples> {
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
