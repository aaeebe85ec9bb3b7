//! Rollouts: simulation from a measured state with the measured torque (E23).

use crate::error::ModelError;
use crate::friction::{FrictionLaw, FrictionTerm};
use crate::model::{Model, Weighted};
use crate::torque::Torque;
use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use rayon::prelude::*;
use serde::Serialize;
use torquewise_motion::path::Path;
use torquewise_motion::{LARGEST, ReadError, Recording};

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
/// On either side of their band lies one of so many arms that a model may as well be.
const OUTSIDE: usize = 20;
/// Speed \[rad/s\] below which a shaft is held by its friction as by a viscous one.
const HELD: f64 = 1e-7;

/// How far the simulated arm is from the measured one after some time, over windows all over the
/// logs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Drift {
    /// Time since the measured state \[s\].
    pub horizon_s: f64,
    /// RMS of the distance of each joint \[rad\], n, over the windows whose simulation did not run
    /// away; infinite where all did.
    pub rms_drift_rad: Vec<f64>,
    /// The same of an arm that keeps the velocity that it had, over all windows.
    pub hold_rms_rad: Vec<f64>,
    /// Windows.
    pub windows: usize,
    /// Those of them whose simulation ran away: none of their joints counts in `rms_drift_rad`.
    pub ran_away: usize,
    /// Share of windows whose measured end lies in the band of 90 % of the arms that the model may as
    /// well be, n; where such arms were given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub covered: Option<Vec<f64>>,
}

/// Where a simulated arm is.
#[derive(Clone, Debug)]
pub struct Moving {
    /// Positions, and what friction remembers of the way to them.
    pub path: Path,
    /// \[rad/s\], n.
    pub dq: Vec<f64>,
    /// Of the last step \[rad/s²\], n.
    pub ddq: Vec<f64>,
}

impl Torque {
    /// Lets a torque \[N·m\], n, act for a short time \[s\].
    ///
    /// Links move by the midpoint rule. Dry friction is that of the speed at the end of the step, so
    /// that it never turns a joint round: what it cannot carry past rest stays at rest. Viscous
    /// friction is its mean over the step, as of a speed that decays.
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
        let mass = self.mass_matrix(&q)?;
        let (gravity, coriolis) = (self.gravity(&q)?, self.coriolis(&q, &dq)?);
        let momentum = &mass * faer::ColRef::from_slice(&arm.dq);
        let pushed: Vec<f64> =
            (0..n).map(|j| momentum[j] + seconds * (tau[j] - gravity[j] - coriolis[j])).collect();
        let mut speed: Vec<f64> =
            arm.dq.iter().zip(&arm.ddq).map(|(dq, ddq)| dq + seconds * ddq).collect();
        let late = self.late(&mass, &arm.dq, seconds)?;
        for _ in 0..ROUNDS {
            let (mut matrix, mut right) = (mass.clone(), pushed.clone());
            for (Weighted { term, coefficient, .. }, [part, early]) in
                self.friction.iter().zip(&late)
            {
                let [constant, slope] = secant(term, &arm.path, &speed, seconds);
                let (constant, slope) = (part * constant + early, part * slope);
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

    /// How much of each friction is that of the end of a step, and what that of its start adds, per
    /// unit of its coefficient.
    fn late(&self, mass: &Mat<f64>, dq: &[f64], seconds: f64) -> Result<Vec<[f64; 2]>, ModelError> {
        let factor = mass.llt(Side::Lower).map_err(|_| ModelError::NoInertia)?;
        let of = |Weighted { term, coefficient, .. }: &Weighted<FrictionTerm>| {
            if term.law != FrictionLaw::Viscous {
                return [1.0, 0.0];
            }
            let shaft = faer::ColRef::from_slice(&term.shaft);
            let yields = shaft.transpose() * factor.solve(shaft);
            let x = (coefficient * yields * seconds).max(0.0);
            // Where the mean of e⁻ˣᵗ from t = 0 to 1 lies between its ends, from ½ to 1, that at the
            // end: by its series where the difference would be rounding.
            let part = if x < 1e-3 { 0.5 + x / 12.0 } else { 1.0 / -(-x).exp_m1() - 1.0 / x };
            [part, (1.0 - part) * term.at_speed(term.speed(dq))]
        };
        Ok(self.friction.iter().map(of).collect())
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
    /// A signal at a time after a row, on the line to the next.
    fn between(&self, x: &[Vec<f64>], row: usize, t: f64) -> Vec<f64> {
        let Some(next) = x.get(row + 1) else { return x[row].clone() };
        let share = (t - self.t[row]) / (self.t[row + 1] - self.t[row]);
        x[row].iter().zip(next).map(|(a, b)| a + share * (b - a)).collect()
    }

    /// The last row at a time or before, from a row on.
    fn before(&self, mut row: usize, t: f64) -> usize {
        while row + 2 < self.t.len() && self.t[row + 1] <= t {
            row += 1;
        }
        row
    }

    /// Windows of some length \[s\].
    fn windows(&self, mut path: Path, longest: f64) -> Vec<Window<'_>> {
        let [first, .., last] = self.t[..] else { return Vec::new() };
        let apart = (0.5 * longest).max((last - first - longest) / WINDOWS as f64);
        let (mut windows, mut next) = (Vec::new(), first);
        for (row, q) in self.q.iter().enumerate() {
            path.step(q);
            if self.t[row] >= next && self.t[row] + longest <= last {
                windows.push(Window { rows: self, path: path.clone(), first: row });
                next = self.t[row] + apart;
            }
        }
        windows
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

/// A stretch of a trajectory that can be simulated: from a measured state on, with measured torque.
pub struct Window<'r> {
    rows: &'r Rows,
    path: Path,
    first: usize,
}

/// What is shown each step of a simulation: the arm after it, and how long it took \[s\].
pub type SeeStep<'s> = dyn FnMut(&Moving, f64) + 's;

impl Window<'_> {
    /// Where it leads at each horizon \[s\], ascending; q, n each.
    ///
    /// # Errors
    /// As [`Torque::step`].
    pub fn simulated(
        &self,
        torque: &Torque,
        horizons: &[f64],
        see: &mut SeeStep<'_>,
    ) -> Result<Vec<Vec<f64>>, ModelError> {
        let Self { rows, path, first } = self;
        let (path, dq) = (path.clone(), rows.dq[*first].clone());
        let mut arm = Moving { path, ddq: vec![0.0; dq.len()], dq };
        let (mut row, mut t) = (*first, rows.t[*first]);
        let mut reached = Vec::new();
        for horizon in horizons {
            let end = rows.t[*first] + horizon;
            while t < end - 0.01 * STEP {
                let seconds = STEP.min(end - t);
                let middle = t + 0.5 * seconds;
                row = rows.before(row, middle);
                torque.step(&mut arm, &rows.between(&rows.tau, row, middle), seconds)?;
                see(&arm, seconds);
                t += seconds;
            }
            reached.push(arm.path.q().to_vec());
        }
        Ok(reached)
    }

    /// Where the arm was after some time \[s\]; q, n.
    pub fn measured(&self, after: f64) -> Vec<f64> {
        let t = self.rows.t[self.first] + after;
        self.rows.between(&self.rows.q, self.rows.before(self.first, t), t)
    }

    /// Whether a simulated joint was faster than any is, or ends at no number.
    fn ran_away(&self, end: &[f64], after: f64) -> bool {
        let may_be = |(end, start): (&f64, &f64)| (end - start).abs() <= LARGEST[1] * after;
        !end.iter().zip(&self.rows.q[self.first]).all(may_be)
    }

    /// Where it would be at the velocity that it had; q, n.
    fn held(&self, after: f64) -> Vec<f64> {
        let state = self.rows.q[self.first].iter().zip(&self.rows.dq[self.first]);
        state.map(|(q, dq)| q + after * dq).collect()
    }
}

/// Hands over windows all over a recording, those of a stretch without gaps together; they begin
/// half their length apart or more.
///
/// - `longest`: their length \[s\]
///
/// # Errors
/// The reader's message; [`ModelError`] if the recording is of another arm or without torque.
pub fn windows(
    model: &Model,
    recording: &(impl Recording + ?Sized),
    longest: f64,
    take: &mut dyn FnMut(&[Window<'_>]) -> Result<(), ReadError>,
) -> Result<(), ReadError> {
    model.check_joints(recording.joints())?;
    let path = Torque::new(model).path();
    let (mut rows, mut own) = (Rows::default(), None);
    recording.read(&mut |trajectory, block| {
        for row in 0..block.n_rows() {
            if own != Some(trajectory) || !rows.goes_on(block.t()[row]) {
                take(&std::mem::take(&mut rows).windows(path.clone(), longest))?;
                own = Some(trajectory);
            }
            let of = |x: faer::MatRef<'_, f64>| x.row(row).iter().copied().collect::<Vec<f64>>();
            rows.tau.push(of(block.require_tau()?));
            rows.t.push(block.t()[row]);
            rows.q.push(of(block.q()));
            rows.dq.push(of(block.dq()));
        }
        Ok(())
    })?;
    take(&rows.windows(path, longest))
}

/// Simulates windows all over a recording from their first measured state with the measured torque,
/// and compares where they end with where the arm was.
///
/// - `others`: arms that the model may as well be, whose band is held against the measured ends
/// - `horizons`: times from the start of a window \[s\], ascending
///
/// # Errors
/// As of [`windows`].
pub fn drifts(
    model: &Model,
    others: &[Model],
    recording: &(impl Recording + ?Sized),
    horizons: &[f64],
) -> Result<Vec<Drift>, ReadError> {
    let Some(&longest) = horizons.last() else { return Ok(Vec::new()) };
    let torque = Torque::new(model);
    let others: Vec<Torque> = others.iter().map(Torque::new).collect();
    let n = model.n_joints();
    let begun = |&horizon_s: &f64| Drift {
        horizon_s,
        rms_drift_rad: vec![0.0; n],
        hold_rms_rad: vec![0.0; n],
        windows: 0,
        ran_away: 0,
        covered: (!others.is_empty()).then(|| vec![0.0; n]),
    };
    // Sums of squares and counts first, means of them in the end.
    let mut drifts: Vec<Drift> = horizons.iter().map(begun).collect();
    windows(model, recording, longest, &mut |windows| {
        let ends = |window: &Window<'_>| {
            let of = |torque| window.simulated(torque, horizons, &mut |_, _| ());
            // An arm whose inertia is next to nothing in some direction runs away.
            let of = |torque| match of(torque) {
                Err(ModelError::NoInertia) => Ok(vec![vec![f64::NAN; n]; horizons.len()]),
                ends => ends,
            };
            let others = others.iter().map(of).collect::<Result<Vec<_>, ModelError>>()?;
            Ok((of(&torque)?, others))
        };
        let ends = windows.par_iter().map(ends).collect::<Result<Vec<_>, ModelError>>()?;
        for (window, (ends, others)) in windows.iter().zip(ends) {
            for (k, (drift, end)) in drifts.iter_mut().zip(ends).enumerate() {
                let (truth, held) = (window.measured(horizons[k]), window.held(horizons[k]));
                for (joint, inside) in drift.covered.iter_mut().flatten().enumerate() {
                    let among = others.iter().map(|ends| ends[k][joint]).collect();
                    *inside += f64::from(u8::from(is_in_band(among, truth[joint])));
                }
                let ran_away = window.ran_away(&end, horizons[k]);
                drift.windows += 1;
                drift.ran_away += usize::from(ran_away);
                let end = if ran_away { truth.clone() } else { end };
                let sums = [&mut drift.rms_drift_rad, &mut drift.hold_rms_rad];
                for (sums, ends) in sums.into_iter().zip([end, held]) {
                    for ((sum, end), truth) in sums.iter_mut().zip(ends).zip(&truth) {
                        *sum += (end - truth).powi(2);
                    }
                }
            }
        }
        Ok(())
    })?;
    drifts.retain(|drift| drift.windows > 0);
    for Drift { rms_drift_rad, hold_rms_rad, windows, ran_away, covered, .. } in &mut drifts {
        let [all, kept] = [*windows, *windows - *ran_away].map(|count| count as f64);
        for (count, squares) in [(kept, rms_drift_rad), (all, hold_rms_rad)] {
            for x in squares {
                *x = if count > 0.0 { (*x / count).sqrt() } else { f64::INFINITY };
            }
        }
        covered.iter_mut().flatten().for_each(|x| *x /= all);
    }
    Ok(drifts)
}

/// Whether a value lies in the middle 90 % of some.
fn is_in_band(mut among: Vec<f64>, value: f64) -> bool {
    among.sort_by(f64::total_cmp);
    let Some(last) = among.len().checked_sub(1) else { return false };
    let outside = (last + OUTSIDE / 2) / OUTSIDE;
    (among[outside]..=among[last - outside]).contains(&value)
}
