//! From a measured state and measured torque to where the arm goes, beside where it went: the second
//! truth of a model (E23).

use crate::error::ModelError;
use crate::friction::{FrictionLaw, FrictionTerm};
use crate::model::{Model, Weighted};
use crate::torque::Torque;
use faer::Side;
use faer::linalg::solvers::Solve;
use rayon::prelude::*;
use serde::Serialize;
use torquewise_motion::path::Path;
use torquewise_motion::{Motion, ReadError, Recording};

/// Longest step \[s\].
const STEP: f64 = 1e-3;
/// Windows of a trajectory at most.
const WINDOWS: usize = 200;
/// Rows farther apart than so many usual steps are not of one window.
const GAP: f64 = 1.5;
/// Rounds in which friction and speed at the end of a step are made to agree, at most, and the change
/// \[rad/s\] below which they do.
const ROUNDS: usize = 50;
const AGREED: f64 = 1e-9;
/// Speed \[rad/s\] below which a shaft is held by its friction as by a viscous one.
const HELD: f64 = 1e-7;

/// How far the simulated arm is from the measured one after some time, over windows all over the
/// logs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Drift {
    /// Time since the measured state \[s\].
    pub horizon_s: f64,
    /// RMS of the distance of each joint \[rad\], n; infinite where a simulation ran away.
    pub rms_drift_rad: Vec<f64>,
    /// The same of an arm that keeps the velocity that it had.
    pub hold_rms_rad: Vec<f64>,
    /// Windows.
    pub windows: usize,
}

/// An arm that moves as its model says.
#[derive(Clone, Debug)]
pub struct Simulator<'m> {
    torque: Torque,
    friction: &'m [Weighted<FrictionTerm>],
}

/// Where a simulated arm is.
#[derive(Clone, Debug)]
pub struct Moving {
    /// Positions, and what friction remembers of the way to them.
    pub path: Path,
    /// \[rad/s\], n.
    pub dq: Vec<f64>,
    /// Of the last step \[rad/s²\], n.
    ddq: Vec<f64>,
}

impl<'m> Simulator<'m> {
    /// Makes a model ready to move.
    pub fn new(model: &'m Model) -> Self {
        Self { torque: Torque::new(model), friction: &model.friction }
    }

    /// An arm at the end of a path, at some speed \[rad/s\], n.
    pub fn start(&self, path: Path, dq: Vec<f64>) -> Moving {
        let ddq = vec![0.0; dq.len()];
        Moving { path, dq, ddq }
    }

    /// Lets a torque \[N·m\], n, act for a short time \[s\].
    ///
    /// Links move by the midpoint rule. Friction is that of the speed at the end of the step, so that
    /// it never turns a joint round: what it cannot carry past rest stays at rest.
    ///
    /// # Errors
    /// [`ModelError::NoInertia`] if a direction of the arm has none, so that nothing can be moved.
    pub fn step(&self, arm: &mut Moving, tau: &[f64], seconds: f64) -> Result<(), ModelError> {
        let n = tau.len();
        let half = 0.5 * seconds;
        let ahead = |x: &[f64], rate: &[f64]| -> Vec<f64> {
            x.iter().zip(rate).map(|(x, rate)| x + half * rate).collect()
        };
        let (q, dq) = (ahead(arm.path.q(), &arm.dq), ahead(&arm.dq, &arm.ddq));
        let mass = self.torque.mass_matrix(&q)?;
        let (gravity, coriolis) = (self.torque.gravity(&q)?, self.torque.coriolis(&q, &dq)?);
        let momentum = &mass * faer::ColRef::from_slice(&arm.dq);
        let pushed: Vec<f64> =
            (0..n).map(|j| momentum[j] + seconds * (tau[j] - gravity[j] - coriolis[j])).collect();
        let mut speed: Vec<f64> =
            arm.dq.iter().zip(&arm.ddq).map(|(dq, ddq)| dq + seconds * ddq).collect();
        for _ in 0..ROUNDS {
            let (mut matrix, mut right) = (mass.clone(), pushed.clone());
            for Weighted { term, coefficient, .. } in self.friction {
                let [constant, slope] = secant(term, &arm.path, &speed, seconds);
                let strength = seconds * coefficient * term.pressed(&gravity);
                for (i, a) in term.shaft.iter().enumerate().filter(|(_, a)| **a != 0.0) {
                    right[i] -= strength * a * constant;
                    for (j, b) in term.shaft.iter().enumerate() {
                        matrix[(i, j)] += strength * a * slope * b;
                    }
                }
            }
            let factor = matrix.llt(Side::Lower).map_err(|_| ModelError::NoInertia)?;
            let next = factor.solve(faer::ColRef::from_slice(&right));
            let change = speed.iter().zip(next.iter()).map(|(a, b)| (a - b).abs());
            let change = change.fold(0.0_f64, f64::max);
            speed.iter_mut().zip(next.iter()).for_each(|(speed, next)| *speed = *next);
            // Not a number is no agreement, and no later round mends it.
            if change < AGREED || !change.is_finite() {
                break;
            }
        }
        let q: Vec<f64> = (0..n).map(|j| arm.path.q()[j] + half * (arm.dq[j] + speed[j])).collect();
        arm.ddq = speed.iter().zip(&arm.dq).map(|(now, before)| (now - before) / seconds).collect();
        arm.path.step(&q);
        arm.dq = speed;
        Ok(())
    }

    /// Where a row of a trajectory leads under its torque, at each horizon; q, n each.
    fn window(
        &self,
        rows: &Rows,
        (path, first): (Path, usize),
        horizons: &[f64],
    ) -> Result<Vec<Vec<f64>>, ModelError> {
        let mut arm = self.start(path, rows.dq[first].clone());
        let (mut row, mut t) = (first, rows.t[first]);
        let mut reached = Vec::new();
        for horizon in horizons {
            let end = rows.t[first] + horizon;
            while t < end - 0.01 * STEP {
                let seconds = STEP.min(end - t);
                let middle = t + 0.5 * seconds;
                while row + 2 < rows.t.len() && rows.t[row + 1] <= middle {
                    row += 1;
                }
                self.step(&mut arm, &rows.between(&rows.tau, row, middle), seconds)?;
                t += seconds;
            }
            reached.push(arm.path.q().to_vec());
        }
        Ok(reached)
    }
}

/// Friction at the end of a step as c + s·v, exact at a speed that is near: \[c, s\] per unit of its
/// coefficient.
fn secant(term: &FrictionTerm, path: &Path, dq: &[f64], seconds: f64) -> [f64; 2] {
    let speed = term.speed(dq);
    let size = speed.abs().max(HELD);
    if let Some((joint, travel)) = term.element() {
        let before = path.state(joint, travel).unwrap_or(0.0);
        let kept = (-size * seconds / travel).exp();
        return [before * kept, (1.0 - kept) / size];
    }
    if term.law == FrictionLaw::Offset {
        return [term.at_speed(speed), 0.0];
    }
    let near = if speed < 0.0 { -size } else { size };
    [0.0, term.at_speed(near) / near]
}

/// Rows of one trajectory without gaps.
#[derive(Default)]
struct Rows {
    t: Vec<f64>,
    q: Vec<Vec<f64>>,
    dq: Vec<Vec<f64>>,
    tau: Vec<Vec<f64>>,
}

impl Rows {
    fn add(&mut self, block: &Motion, row: usize) -> Result<(), ReadError> {
        let of = |x: faer::MatRef<'_, f64>| x.row(row).iter().copied().collect::<Vec<f64>>();
        self.tau.push(of(block.require_tau()?));
        self.t.push(block.t()[row]);
        self.q.push(of(block.q()));
        self.dq.push(of(block.dq()));
        Ok(())
    }

    /// A signal at a time after a row, on the line to the next.
    fn between(&self, x: &[Vec<f64>], row: usize, t: f64) -> Vec<f64> {
        let Some(next) = x.get(row + 1) else { return x[row].clone() };
        let share = (t - self.t[row]) / (self.t[row + 1] - self.t[row]);
        x[row].iter().zip(next).map(|(a, b)| a + share * (b - a)).collect()
    }

    /// Whether a row goes on after those that are here.
    fn goes_on(&self, t: f64) -> bool {
        match self.t[..] {
            [] => true,
            [before] => t > before,
            [first, second, ..] => {
                let since = t - self.t[self.t.len() - 1];
                since > 0.0 && since < GAP * (second - first)
            }
        }
    }
}

/// Sums of squares of each horizon: of the drift and of the held velocity, n each.
type Squares = (usize, Vec<[Vec<f64>; 2]>);

/// Simulates windows all over a recording from their first measured state with the measured torque,
/// and compares where they end with where the arm was.
///
/// - `horizons`: times from the start of a window \[s\], ascending
///
/// # Errors
/// The reader's message; [`ModelError`] if the recording is of another arm or without torque, or the
/// model cannot be simulated.
pub fn drifts(
    model: &Model,
    recording: &(impl Recording + ?Sized),
    horizons: &[f64],
) -> Result<Vec<Drift>, ReadError> {
    model.check_joints(recording.joints())?;
    let simulator = Simulator::new(model);
    let n = model.n_joints();
    let none = vec![[vec![0.0; n], vec![0.0; n]]; horizons.len()];
    let mut sums: Squares = (0, none);
    let (mut rows, mut own) = (Rows::default(), None);
    recording.read(&mut |trajectory, block| {
        for row in 0..block.n_rows() {
            if own != Some(trajectory) || !rows.goes_on(block.t()[row]) {
                add(&simulator, &std::mem::take(&mut rows), horizons, &mut sums)?;
                own = Some(trajectory);
            }
            rows.add(block, row)?;
        }
        Ok(())
    })?;
    add(&simulator, &rows, horizons, &mut sums)?;
    let (windows, squares) = sums;
    let rms = |squares: Vec<f64>| -> Vec<f64> {
        squares.iter().map(|square| (square / windows as f64).sqrt()).collect()
    };
    let drift = |(&horizon_s, [drift, held]): (&f64, [Vec<f64>; 2])| Drift {
        horizon_s,
        rms_drift_rad: rms(drift),
        hold_rms_rad: rms(held),
        windows,
    };
    Ok(if windows == 0 { Vec::new() } else { horizons.iter().zip(squares).map(drift).collect() })
}

/// Adds the windows of one trajectory, which begin half a horizon apart or more.
fn add(
    simulator: &Simulator<'_>,
    rows: &Rows,
    horizons: &[f64],
    (windows, squares): &mut Squares,
) -> Result<(), ModelError> {
    let (Some(&longest), [first, .., last]) = (horizons.last(), &rows.t[..]) else { return Ok(()) };
    let apart = (0.5 * longest).max((last - first - longest) / WINDOWS as f64);
    let mut path = simulator.torque.path();
    let mut starts: Vec<(Path, usize)> = Vec::new();
    let mut next = *first;
    for (row, q) in rows.q.iter().enumerate() {
        path.step(q);
        if rows.t[row] >= next && rows.t[row] + longest <= *last {
            starts.push((path.clone(), row));
            next = rows.t[row] + apart;
        }
    }
    let ends = |start: &(Path, usize)| simulator.window(rows, start.clone(), horizons);
    let ends = starts.par_iter().map(ends).collect::<Result<Vec<_>, ModelError>>()?;
    for ((_, row), ends) in starts.iter().zip(ends) {
        let mut now = *row;
        for ((horizon, end), [drift, held]) in horizons.iter().zip(ends).zip(squares.iter_mut()) {
            let t = rows.t[*row] + horizon;
            while now + 2 < rows.t.len() && rows.t[now + 1] <= t {
                now += 1;
            }
            for (joint, truth) in rows.between(&rows.q, now, t).into_iter().enumerate() {
                // What ran away is no number.
                let apart = end[joint] - truth;
                drift[joint] += if apart.is_finite() { apart.powi(2) } else { f64::INFINITY };
                held[joint] +=
                    (rows.q[*row][joint] + horizon * rows.dq[*row][joint] - truth).powi(2);
            }
        }
    }
    *windows += starts.len();
    Ok(())
}
