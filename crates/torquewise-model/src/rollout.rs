//! Rollouts: simulation from a measured state with the measured torque (E23).

mod window;

pub use window::{SeeStep, Window, windows};

use crate::{FrictionLaw, FrictionTerm, Model, ModelError, Torque, Weighted};
use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use serde::Serialize;
use torquewise_motion::{Path, ReadError, Recording};

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

/// Arms that a model may as well be, and what is not known of the motion that they are held against.
#[derive(Clone, Debug)]
pub struct Others {
    /// The arms.
    pub models: Vec<Model>,
    /// Deviation of the noise in the rows of q \[rad\] and q̇ \[rad/s\], n each.
    pub noise: [Vec<f64>; 2],
    /// Seed of that noise.
    pub seed: u64,
}

impl Others {
    /// Where the torques of the arms seem to lead.
    fn ends(
        &self,
        arms: &[Torque],
        window: &Window<'_>,
        horizons: &[f64],
    ) -> Result<Vec<Ends>, ModelError> {
        let mut random = ChaCha8Rng::seed_from_u64(self.seed);
        random.set_stream(window.first as u64);
        let sizes = [horizons.len(), self.noise[0].len()];
        let mut of = |arm| window.other(arm, &self.noise, horizons, &mut random);
        arms.iter().map(|arm| or_away(of(arm), sizes)).collect()
    }
}

/// Positions of all joints at each horizon.
type Ends = Vec<Vec<f64>>;

/// Ends at no number of an arm whose inertia is next to nothing in some direction.
fn or_away(ends: Result<Ends, ModelError>, [count, n]: [usize; 2]) -> Result<Ends, ModelError> {
    match ends {
        Err(ModelError::NoInertia) => Ok(vec![vec![f64::NAN; n]; count]),
        ends => ends,
    }
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

/// Simulates windows all over a recording from their first measured state with the measured torque,
/// and compares where they end with where the arm was.
///
/// - `others`: whose band is held against the measured ends
/// - `horizons`: times from the start of a window \[s\], ascending
///
/// # Errors
/// As of [`windows`].
pub fn drifts(
    model: &Model,
    others: Option<&Others>,
    recording: &(impl Recording + ?Sized),
    horizons: &[f64],
) -> Result<Vec<Drift>, ReadError> {
    let Some(&longest) = horizons.last() else { return Ok(Vec::new()) };
    let torque = Torque::new(model);
    let arms: Vec<Torque> =
        others.iter().flat_map(|own| own.models.iter().map(Torque::new)).collect();
    let n = model.n_joints();
    let begun = |&horizon_s: &f64| Drift {
        horizon_s,
        rms_drift_rad: vec![0.0; n],
        hold_rms_rad: vec![0.0; n],
        windows: 0,
        ran_away: 0,
        covered: others.map(|_| vec![0.0; n]),
    };
    // Sums of squares and counts first, means of them in the end.
    let mut drifts: Vec<Drift> = horizons.iter().map(begun).collect();
    windows(model, recording, (longest, others.map(|_| &torque)), &mut |windows| {
        let ends = |window: &Window<'_>| {
            let others = others.map(|own| own.ends(&arms, window, horizons)).transpose()?;
            let own = window.simulated(&torque, horizons, &mut |_, _| ());
            Ok((or_away(own, [horizons.len(), n])?, others.unwrap_or_default()))
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

/// Whether a value lies in the middle 90 % of some; half of those that are no number are beyond
/// either end.
fn is_in_band(mut among: Vec<f64>, value: f64) -> bool {
    let Some(last) = among.len().checked_sub(1) else { return false };
    let mut way = 1.0;
    for own in among.iter_mut().filter(|own| own.is_nan()) {
        (*own, way) = (way * f64::INFINITY, -way);
    }
    among.sort_by(f64::total_cmp);
    let outside = (last + OUTSIDE / 2) / OUTSIDE;
    (among[outside]..=among[last - outside]).contains(&value)
}
