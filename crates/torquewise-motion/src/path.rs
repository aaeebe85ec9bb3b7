//! States of Dahl elements along a path of positions (E13).

use crate::Motion;
use crate::motion::{Memory, place};
use faer::Mat;
use std::borrow::Cow;

/// Travels \[rad\] over which the friction of a joint may turn over: a sum of elements with these
/// comes near a loop of any shape between them.
pub const TRAVELS: [f64; 5] = [0.0005, 0.002, 0.01, 0.05, 0.2];

/// Dahl elements along a trajectory.
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

    /// Forgets the path so far.
    pub fn reset(&mut self) {
        self.q.clear();
        self.states.fill(0.0);
    }

    /// Goes on from where another path of as many elements was: its [`q`](Self::q) and
    /// [`states`](Self::states).
    pub fn resume(&mut self, q: Vec<f64>, states: Vec<f64>) {
        (self.q, self.states) = (q, states);
    }

    /// Takes the next sample of the positions q \[rad\], n; one that is not finite is passed over.
    pub fn step(&mut self, q: &[f64]) {
        if q.iter().any(|q| !q.is_finite()) {
            return;
        }
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
        self.states.get(place(&self.travels, joint, travel)?).copied()
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::Signals;
    use crate::recording::Recording;

    /// One joint that swings, a row each 10 ms.
    fn swing(rows: usize) -> Motion {
        let signal = |f: fn(f64) -> f64| Mat::from_fn(rows, 1, |row, _| f(0.01 * row as f64));
        let t = (0..rows).map(|row| 0.01 * row as f64).collect();
        let (q, dq) = (signal(|t| 0.1 * (3.0 * t).sin()), signal(|t| 0.3 * (3.0 * t).cos()));
        let (joints, ddq) = (vec!["joint1".into()], signal(|t| -0.9 * (3.0 * t).sin()));
        Motion::new(Signals { joints, t, q, dq, ddq, tau: None }).unwrap()
    }

    fn states(motion: &Motion) -> Vec<f64> {
        let memory = motion.memory().unwrap();
        (0..motion.n_rows()).flat_map(|row| memory.row(row).collect::<Vec<f64>>()).collect()
    }

    #[test]
    fn states_are_the_same_in_any_blocks() {
        let motion = swing(3_000);
        let whole = states(&Path::new(1, &TRAVELS).follow(0, &motion));
        let (mut path, mut parts) = (Path::new(1, &TRAVELS), Vec::new());
        let read = motion.read(&mut |trajectory, block| {
            parts.extend(states(&path.follow(trajectory, block)));
            Ok(())
        });

        read.unwrap();
        assert_eq!(whole, parts);
    }

    #[test]
    fn another_trajectory_begins_anew() {
        let motion = swing(500);
        let mut path = Path::new(1, &TRAVELS);

        let first = states(&path.follow(0, &motion));
        let second = states(&path.follow(1, &motion));
        let goes_on = states(&path.follow(1, &motion));

        assert_eq!(first, second);
        assert_ne!(first, goes_on);
    }

    #[test]
    fn a_state_solves_its_differential_equation() {
        // dx = dq/δ − |dq|/δ·x by small Euler steps.
        let (travel, mut x, mut path) = (0.05, 0.0, Path::new(1, &[0.05]));
        let q = |k: i32| 0.1 * (1e-4 * f64::from(k)).sin();
        path.step(&[q(0)]);
        for k in 1..100_000 {
            let step = q(k) - q(k - 1);
            x += (step - step.abs() * x) / travel;
            path.step(&[q(k)]);
        }

        assert!((path.state(0, travel).unwrap() - x).abs() < 1e-4, "{x}");
    }

    #[test]
    fn rows_that_were_picked_keep_what_was_remembered() {
        let motion = Path::new(1, &TRAVELS).follow(0, &swing(500)).into_owned();
        let picked = motion.select(&[400, 10]);
        let memory = |motion: &Motion, row| motion.memory().unwrap().state(row, 0, 0.05);

        assert_eq!(memory(&picked, 0), memory(&motion, 400));
        // What is known is not followed again.
        assert_eq!(states(&Path::new(1, &TRAVELS).follow(0, &picked)), states(&picked));
    }
}
