//! Positions → what friction remembers of the path: the states of Dahl elements (E13).

use crate::memory::Memory;
use crate::motion::Motion;
use faer::Mat;
use std::borrow::Cow;

/// Travels \[rad\] over which the friction of a joint may turn over: a sum of elements with these
/// comes near a loop of any shape between them.
pub const TRAVELS: [f64; 5] = [0.0005, 0.002, 0.01, 0.05, 0.2];

/// Dahl elements on their way along a trajectory.
///
/// An element starts in the middle, x = 0, as nothing is known of what was before. Over a sample
/// its state moves towards the direction of the step: x ← s + (x − s)·e^(−|Δq|/δ), s = sign Δq,
/// which is exact for steps of one direction (E13).
///
/// ```
/// use torquewise_motion::path::Path;
///
/// let mut path = Path::new(1, &[0.01]);
/// path.step(&[0.0]);
/// path.step(&[0.01]);
/// assert!((path.state(0, 0.01).unwrap() - (1.0 - (-1.0_f64).exp())).abs() < 1e-15);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Path {
    travels: Vec<f64>,
    /// Where the joints were, n; nothing before the first sample.
    q: Vec<f64>,
    states: Vec<f64>,
    trajectory: Option<usize>,
}

impl Path {
    /// Elements that have not moved.
    ///
    /// - `travels`: of the elements of each joint \[rad\], above 0
    pub fn new(n_joints: usize, travels: &[f64]) -> Self {
        let states = vec![0.0; n_joints * travels.len()];
        Self { travels: travels.to_vec(), q: Vec::new(), states, trajectory: None }
    }

    /// Forgets the way so far.
    pub fn reset(&mut self) {
        self.q.clear();
        self.states.fill(0.0);
    }

    /// Takes the next sample of the positions q \[rad\], n.
    pub fn step(&mut self, q: &[f64]) {
        let elements = self.travels.len();
        for (joint, (now, before)) in q.iter().zip(&self.q).enumerate() {
            let way = now - before;
            if way == 0.0 {
                continue;
            }
            let own = &mut self.states[joint * elements..(joint + 1) * elements];
            for (state, travel) in own.iter_mut().zip(&self.travels) {
                let end = way.signum();
                *state = end + (*state - end) * (-way.abs() / travel).exp();
            }
        }
        self.q.clear();
        self.q.extend_from_slice(q);
    }

    /// The last sample \[rad\], n; nothing before the first.
    pub fn q(&self) -> &[f64] {
        &self.q
    }

    /// States of all elements, those of a joint side by side.
    pub fn states(&self) -> &[f64] {
        &self.states
    }

    /// State of the element of a joint with a travel \[rad\], if there is one.
    pub fn state(&self, joint: usize, travel: f64) -> Option<f64> {
        let element = self.travels.iter().position(|own| own.to_bits() == travel.to_bits())?;
        self.states.get(joint * self.travels.len() + element).copied()
    }

    /// The next block of a recording with its memory, if it has none yet; another trajectory begins
    /// anew.
    pub fn follow<'m>(&mut self, trajectory: usize, block: &'m Motion) -> Cow<'m, Motion> {
        if block.memory().map_or(self.travels.is_empty(), |memory| memory.holds(&self.travels)) {
            return Cow::Borrowed(block);
        }
        if self.trajectory != Some(trajectory) {
            self.reset();
            self.trajectory = Some(trajectory);
        }
        let mut states = Mat::zeros(block.n_rows(), self.states.len());
        let mut q = vec![0.0; block.n_joints()];
        for row in 0..block.n_rows() {
            q.iter_mut().enumerate().for_each(|(joint, q)| *q = block.q()[(row, joint)]);
            self.step(&q);
            self.states.iter().enumerate().for_each(|(k, state)| states[(row, k)] = *state);
        }
        let memory = Memory::new(self.travels.clone(), states);
        Cow::Owned(block.clone().with_memory(Some(memory)))
    }
}
