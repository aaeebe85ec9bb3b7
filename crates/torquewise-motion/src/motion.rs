//! Motion: q, q̇, q̈ and τ of n joints at m instants, shapes checked once.

use crate::{MotionError, Result};
use faer::{Mat, MatRef};

/// More than any joint reaches, of q, q̇, q̈ and τ \[rad, rad/s, –, N·m; m and m/s of a slide\]: eight
/// turns are less than half a turn written in degrees; accelerations have no bound.
pub const LARGEST: [f64; 4] = [50.0, 100.0, f64::INFINITY, 1e5];

/// The parts a [`Motion`] is made of, before they are checked.
#[derive(Clone, Debug)]
pub struct Signals {
    /// Names of the n joints, base to tip.
    pub joints: Vec<String>,
    /// Time stamps \[s\], m.
    pub t: Vec<f64>,
    /// Joint positions \[rad\], m×n.
    pub q: Mat<f64>,
    /// Joint velocities \[rad/s\], m×n.
    pub dq: Mat<f64>,
    /// Joint accelerations \[rad/s²\], m×n.
    pub ddq: Mat<f64>,
    /// Joint torques \[N·m\], m×n; `None` for a log to be predicted only.
    pub tau: Option<Mat<f64>>,
}

/// States of Dahl elements at the rows of a motion (E13): each between −1 and 1.
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
        travels.iter().all(|travel| place(&self.travels, 0, *travel).is_some())
    }

    /// State of the element of a joint with a travel \[rad\], if there is one.
    pub fn state(&self, row: usize, joint: usize, travel: f64) -> Option<f64> {
        let place = place(&self.travels, joint, travel)?;
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
}

/// Where the element of a joint with a travel stands among those of all joints, if there is one.
pub(crate) fn place(travels: &[f64], joint: usize, travel: f64) -> Option<usize> {
    let element = travels.iter().position(|own| own.to_bits() == travel.to_bits())?;
    Some(joint * travels.len() + element)
}

/// Matrices of so many columns, one below the other.
pub fn stacked(columns: usize, parts: &[MatRef<'_, f64>]) -> Mat<f64> {
    let mut all = Mat::zeros(parts.iter().map(MatRef::nrows).sum(), columns);
    let mut first = 0;
    for part in parts {
        all.subrows_mut(first, part.nrows()).copy_from(part);
        first += part.nrows();
    }
    all
}

/// What an arm did: q, q̇, q̈ and, if measured, τ of n joints at m instants.
///
/// All signals have the same shape and are finite.
#[derive(Clone, Debug)]
pub struct Motion {
    signals: Signals,
    /// What friction remembers of the path, where that was followed.
    memory: Option<Memory>,
    /// What a filter took from the torque \[N·m\], m×n, where there was one.
    removed_tau: Option<Mat<f64>>,
}

impl Motion {
    /// Checks shapes and finiteness.
    ///
    /// # Errors
    /// [`MotionError::NoJoints`], [`MotionError::Shape`] or [`MotionError::NotFinite`].
    pub fn new(signals: Signals) -> Result<Self> {
        let (rows, columns) = (signals.t.len(), signals.joints.len());
        if columns == 0 {
            return Err(MotionError::NoJoints);
        }
        let named = [
            ("q", Some(&signals.q)),
            ("dq", Some(&signals.dq)),
            ("ddq", Some(&signals.ddq)),
            ("tau", signals.tau.as_ref()),
        ];
        for (signal, values) in named {
            let Some(values) = values else { continue };
            MotionError::check_shape(signal, values.as_ref(), [rows, columns])?;
            MotionError::check_all_finite(signal, values.as_ref())?;
        }
        MotionError::check_finite("t", 0, &signals.t)?;
        Ok(Self { signals, memory: None, removed_tau: None })
    }

    /// The blocks of one trajectory, one after the other; without what friction remembers.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn joined(joints: &[String], blocks: &[Self]) -> Result<Self> {
        let t: Vec<f64> = blocks.iter().flat_map(Self::t).copied().collect();
        let joined = |parts: Vec<_>| stacked(joints.len(), &parts);
        let [q, dq, ddq] =
            [Self::q, Self::dq, Self::ddq].map(|of| joined(blocks.iter().map(of).collect()));
        let tau = blocks.iter().map(Self::tau).collect::<Option<_>>().map(joined);
        Self::new(Signals { joints: joints.to_vec(), t, q, dq, ddq, tau })
    }

    /// Number of instants m.
    pub fn n_rows(&self) -> usize {
        self.signals.t.len()
    }

    /// Number of joints n.
    pub fn n_joints(&self) -> usize {
        self.signals.joints.len()
    }

    /// Joint names, base to tip.
    pub fn joints(&self) -> &[String] {
        &self.signals.joints
    }

    /// Time stamps \[s\], m.
    pub fn t(&self) -> &[f64] {
        &self.signals.t
    }

    /// Joint positions \[rad\], m×n.
    pub fn q(&self) -> MatRef<'_, f64> {
        self.signals.q.as_ref()
    }

    /// Joint velocities \[rad/s\], m×n.
    pub fn dq(&self) -> MatRef<'_, f64> {
        self.signals.dq.as_ref()
    }

    /// Joint accelerations \[rad/s²\], m×n.
    pub fn ddq(&self) -> MatRef<'_, f64> {
        self.signals.ddq.as_ref()
    }

    /// Joint torques \[N·m\], m×n, if they were measured.
    pub fn tau(&self) -> Option<MatRef<'_, f64>> {
        self.signals.tau.as_ref().map(Mat::as_ref)
    }

    /// Joint torques \[N·m\], m×n.
    ///
    /// # Errors
    /// [`MotionError::Missing`] if the log holds no torque.
    pub fn require_tau(&self) -> Result<MatRef<'_, f64>> {
        self.tau().ok_or(MotionError::Missing("tau"))
    }

    /// q \[rad\], q̇ \[rad/s\] and q̈ \[rad/s²\] of a row, n each.
    pub fn state(&self, row: usize) -> [Vec<f64>; 3] {
        [self.q(), self.dq(), self.ddq()].map(|x| x.row(row).iter().copied().collect())
    }

    /// What friction remembers of the path at each row, where that was followed.
    pub fn memory(&self) -> Option<&Memory> {
        self.memory.as_ref()
    }

    /// The same rows with what friction remembers of the path to each.
    pub fn with_memory(self, memory: Option<Memory>) -> Self {
        Self { memory, ..self }
    }

    /// What the filter took from the torque \[N·m\], m×n, where one was measured and filtered.
    pub fn removed_tau(&self) -> Option<MatRef<'_, f64>> {
        self.removed_tau.as_ref().map(Mat::as_ref)
    }

    /// The same rows with what the filter took from their torque \[N·m\], m×n.
    pub fn with_removed_tau(self, removed_tau: Option<Mat<f64>>) -> Self {
        Self { removed_tau, ..self }
    }

    /// The parts, given back.
    pub fn into_signals(self) -> Signals {
        self.signals
    }

    /// The rows named by `rows`, in that order.
    pub fn select(&self, rows: &[usize]) -> Self {
        let pick = |x: &Mat<f64>| Mat::from_fn(rows.len(), x.ncols(), |r, c| x[(rows[r], c)]);
        let s = &self.signals;
        Self {
            signals: Signals {
                joints: s.joints.clone(),
                t: rows.iter().map(|&r| s.t[r]).collect(),
                q: pick(&s.q),
                dq: pick(&s.dq),
                ddq: pick(&s.ddq),
                tau: s.tau.as_ref().map(pick),
            },
            memory: self.memory.as_ref().map(|memory| memory.select(rows)),
            removed_tau: self.removed_tau.as_ref().map(pick),
        }
    }
}
