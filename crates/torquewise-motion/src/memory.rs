//! States of Dahl elements along the rows of a recording (E13).

use faer::Mat;

/// States of Dahl elements at the rows of a motion: each between −1 and 1.
#[derive(Clone, Debug, PartialEq)]
pub struct Memory {
    travels: Vec<f64>,
    /// m×(n·k), the elements of a joint side by side.
    states: Mat<f64>,
}

impl Memory {
    /// - `travels`: of the elements of each joint \[rad\], k
    /// - `states`: m×(n·k), the elements of a joint side by side
    pub fn new(travels: Vec<f64>, states: Mat<f64>) -> Self {
        Self { travels, states }
    }

    /// Whether it holds an element of each of these travels.
    pub fn holds(&self, travels: &[f64]) -> bool {
        travels.iter().all(|travel| self.element(*travel).is_some())
    }

    /// State of the element of a joint with a travel \[rad\], if there is one.
    pub fn state(&self, row: usize, joint: usize, travel: f64) -> Option<f64> {
        let element = self.element(travel)?;
        let place = joint * self.travels.len() + element;
        (place < self.states.ncols()).then(|| self.states[(row, place)])
    }

    /// States of all elements at a row.
    pub fn row(&self, row: usize) -> impl Iterator<Item = f64> {
        (0..self.states.ncols()).map(move |k| self.states[(row, k)])
    }

    /// The rows named by `rows`, in that order.
    pub fn select(&self, rows: &[usize]) -> Self {
        let states =
            Mat::from_fn(rows.len(), self.states.ncols(), |r, k| self.states[(rows[r], k)]);
        Self { travels: self.travels.clone(), states }
    }

    fn element(&self, travel: f64) -> Option<usize> {
        self.travels.iter().position(|own| own.to_bits() == travel.to_bits())
    }
}
