//! Torques of the wrong sign: put right, a chain of rigid bodies explains those of all joints far better.

use crate::drive_terms::mirrored;
use crate::learn::searching;
use crate::{
    DriveTerm, HeldTo, Linearisation, Sizes, Unseen, Watch, chain_rows, columns, even_blocks,
    geometric_mean, spread,
};
use faer::Mat;
use rayon::prelude::*;
use torquewise_motion::Motion;
use torquewise_rigid::{Chain, ChainRows, Geometry, Kinematics, Search, refine};
use torquewise_stepwise::{IdentifyError, Survey, thinned};

/// Rows that are tried on; on fewer than these, some signs fit by chance.
pub(crate) const ROWS: usize = 400;
const LEAST_ROWS: usize = 100;
/// Other signs must leave this part of what the torques leave as they are, product of the mean squares
/// of all joints.
pub(crate) const QUARTER: f64 = 0.25;
/// A torque turned round or changed over must be explained but for this part, RMS; all of them in the
/// mean where all are turned.
pub(crate) const HALF: f64 = 0.5;
/// Friction alone tells a sign where it leaves this part, as where a torque is little but friction: of
/// the wrist of a UR10e 0.014 at most. Of 37 real logs as they should be none came below 0.1, but one of
/// joints that always move together, of which none is named.
const BY_FRICTION: f64 = 0.05;
/// Turned round, torques must leave a physical arm less than this part of what they leave it as they are,
/// held out, geometric mean of those named or of all: where seven of a Med7 have KUKA's sign 0.67, where
/// another joint spoilt the look above 1.
const BETTER: f64 = 0.8;
/// To it this part of the spread of a torque is noise at least.
const LEAST_MISSED: f64 = 0.01;
/// What signs leave is alike within this factor.
const ALIKE: f64 = 2.0;
/// Mean squares below this part of the variance are rounding and the ridge.
const LEAST_LEFT: f64 = 1e-6;
/// How often all signs are tried, axes put right in between.
const LOOKS: usize = 3;

/// Where the axes of an arm lie, and what loads its joints beside the links, as far as a fit to
/// torques of any sign has found them.
#[derive(Debug)]
pub(crate) struct SignTest {
    geometry: Geometry,
    /// Parameters of the geometry that may move.
    free: Vec<usize>,
    drive: Vec<DriveTerm>,
}

impl SignTest {
    /// What a pass over all rows was made at.
    ///
    /// - `is_given`: whether its axes were known beforehand, and so stay
    pub(crate) fn at(at: &Linearisation, is_given: bool) -> Self {
        let geometry = at.geometry.clone();
        let free = if is_given { Vec::new() } else { geometry.movable() };
        Self { geometry, free, drive: at.drive.clone() }
    }

    /// Joints whose torque, turned round, lets a chain explain the torques of all joints far better.
    ///
    /// All signs of the joints in doubt are tried, and all torques turned where kinetic energy asks for it, at these axes, and each joint alone with axes that
    /// move; then all again where the axes are now. Friction that drives a shaft counts as left unexplained; where a set
    /// of joints and the rest fit alike, kinetic energy is positive.
    pub(crate) fn wrong_signs(
        mut self,
        survey: &Survey,
        doubtful: &[usize],
        watch: Watch<'_>,
    ) -> Result<Vec<usize>, IdentifyError> {
        let motion = thinned(&survey.sample, ROWS);
        let n = motion.n_joints();
        if motion.n_rows() < LEAST_ROWS {
            return Ok(Vec::new());
        }
        self.drive.extend(mirrored(&self.drive));
        let extras = columns(&self.drive, &motion, None);
        let rows = chain_rows(&motion, extras.clone())?.measured();
        let tried = |rows: &ChainRows, signs: u32, geometry: &Geometry, free: &[usize]| {
            let rows = joints_of(signs).fold(rows.clone(), ChainRows::turned);
            let rounds = if free.is_empty() { 0 } else { Search::default().rounds };
            let search = Search { rounds, ..Search::default() };
            let chain =
                refine(&rows, &Chain::at(geometry.clone()), free, &search, &searching(watch)).ok();
            let left = |chain: &Chain| self.left(chain, &rows, &motion, &extras);
            Tried { signs, left: chain.as_ref().map_or(f64::INFINITY, left), chain }
        };
        let as_it_is = tried(&rows, 0, &self.geometry, &self.free);
        let all_turned = (1_u32 << n) - 1;
        let in_doubt: u32 = doubtful.iter().map(|joint| 1 << joint).sum();
        // Without friction a motion and its torque turned round fit alike: kinetic energy tells.
        let is_mirrored =
            as_it_is.chain.as_ref().is_some_and(|chain| self.kinetic_energy(chain, &motion) < 0.0);
        let likely = |signs: &u32| signs & !in_doubt == 0 || is_mirrored && *signs == all_turned;
        let ways: Vec<u32> = (0..=all_turned).filter(likely).collect();
        let (mut found, mut geometry) = (0, self.geometry.clone());
        for look in 0..LOOKS {
            let rows = rows.clone().placed(&geometry);
            let all: Vec<Tried> =
                ways.par_iter().map(|&signs| tried(&rows, signs, &geometry, &[])).collect();
            let best = self.best(&all, &motion).signs;
            if look > 0 && best == found {
                break;
            }
            // Axes that were found with the signs as they are may lie elsewhere.
            let alone = doubtful.iter().map(|joint| 1 << joint).filter(|_| look == 0);
            let moved: Vec<u32> = std::iter::once(best).chain(alone).collect();
            let moved: Vec<Tried> = moved
                .into_par_iter()
                .map(|signs| tried(&rows, signs, &geometry, &self.free))
                .collect();
            let Some(Tried { signs, left, chain: Some(chain) }) = moved.into_iter().min_by(least)
            else {
                return Ok(Vec::new());
            };
            if left > QUARTER * as_it_is.left && !(is_mirrored && signs == all_turned) {
                if !is_mirrored {
                    return Ok(Vec::new());
                }
                (found, geometry) = (all_turned, self.geometry.clone());
                break;
            }
            (found, geometry) = (signs, chain.geometry);
        }
        let sizes = Sizes::of(survey);
        // Axes that move follow some signs as well as others: a physical arm does not.
        let mirror = (is_mirrored && found != all_turned)
            .then(|| tried(&rows, all_turned, &self.geometry, &self.free));
        let rows = rows.placed(&geometry);
        let here = |signs: u32| tried(&rows, signs, &geometry, &[]);
        let whole = self.likelier(here(found), mirror, &motion, &sizes);
        let told = self.told(&whole, is_mirrored && whole.signs == all_turned, &rows, &here);
        Ok(self.mended(told, [&as_it_is, &whole], &motion, &sizes))
    }

    /// The joints that were turned round and tell so; all, if they are explained, where motion and torque
    /// are mirrored.
    ///
    /// - `here`: the same with other signs, 1 bit each
    fn told(
        &self,
        whole: &Tried,
        is_mirror: bool,
        rows: &ChainRows,
        here: &(impl Fn(u32) -> Tried + Sync),
    ) -> Vec<usize> {
        let n = rows.n_joints();
        if is_mirror {
            let left: f64 = (0..n).map(|joint| whole.part(rows, joint)).product();
            return (0..n).filter(|_| left < HALF.powf(n as f64)).collect();
        }
        let found = whole.signs;
        let parts = (0..found).filter(|signs| signs & !found == 0).collect::<Vec<u32>>();
        let parts: Vec<Tried> = parts.into_par_iter().map(here).collect();
        joints_of(found).filter(|joint| self.tells(*joint, whole, &parts, rows)).collect()
    }

    /// Of two sets of signs, if there are two, that which leaves a physical arm less of held-out torque.
    fn likelier(&self, one: Tried, other: Option<Tried>, motion: &Motion, sizes: &Sizes) -> Tried {
        let missed = |tried: &Tried| {
            let missed = self.missed(tried, motion, sizes);
            missed.map_or(f64::INFINITY, |missed| geometric_mean(&missed))
        };
        other.filter(|other| missed(other) < missed(&one)).unwrap_or(one)
    }

    /// The joints that are told where a physical arm, too, misses less of the held-out torque with the signs
    /// that were found; else none.
    fn mended(
        &self,
        told: Vec<usize>,
        tried: [&Tried; 2],
        motion: &Motion,
        sizes: &Sizes,
    ) -> Vec<usize> {
        if told.is_empty() {
            return told;
        }
        let [as_it_is, turned] = tried.map(|tried| self.missed(tried, motion, sizes));
        let Some(turned) = turned else { return Vec::new() };
        let Some(as_it_is) = as_it_is else { return told };
        let part = |joint: usize| Some(turned[joint] / as_it_is[joint]).filter(|x| x.is_finite());
        // What one of the wrong sign spoils may be another's.
        let all: Vec<f64> = (0..turned.len()).filter_map(part).collect();
        let own: Vec<f64> = told.iter().copied().filter_map(part).collect();
        if geometric_mean(&own).min(geometric_mean(&all)) < BETTER { told } else { Vec::new() }
    }

    /// RMSE of a physical arm at the axes of a chain on blocks of time that are held out \[N·m\], n; `None`
    /// where there is none.
    fn missed(&self, tried: &Tried, motion: &Motion, sizes: &Sizes) -> Option<Vec<f64>> {
        let (chain, tau) = (tried.chain.as_ref()?, motion.tau()?);
        let mut at =
            Linearisation::of(chain, (self.drive.clone(), &chain.drive), vec![0.0; tau.ncols()]);
        // Weights without end would leave no prior.
        for (weight, tau) in at.weights.iter_mut().zip(tau.col_iter()) {
            *weight = weight.min(1.0 / (LEAST_MISSED * spread(tau)));
        }
        let turn = |joint: usize| if tried.signs >> joint & 1 == 1 { -1.0 } else { 1.0 };
        let tau =
            Mat::from_fn(tau.nrows(), tau.ncols(), |row, joint| turn(joint) * tau[(row, joint)]);
        let (target, blocks) = ([(&tau, &tau)], even_blocks(motion));
        let columns = at.columns_of(motion, true).ok()?;
        let unseen = Unseen::of_columns(columns, motion.n_rows(), &target, &blocks)?;
        Some(unseen.physical_errors(&HeldTo::of(&at, sizes, 1.0))?.rms_by_joint())
    }

    /// Whether one of several joints that were turned round tells so by itself and is explained: turned
    /// back alone, the rest fits worse, by torque as by friction; and whatever others are turned, by one
    /// of the two, if all its friction brakes; or always far worse by friction.
    ///
    /// - `parts`: all other sets of the joints that `whole` turns
    fn tells(&self, joint: usize, whole: &Tried, parts: &[Tried], rows: &ChainRows) -> bool {
        let all =
            |tried: &Tried| (0..rows.n_joints()).map(|k| tried.part(rows, k)).product::<f64>();
        let brakes = whole.chain.as_ref().is_some_and(|chain| {
            let own = |drive: &DriveTerm| drive.resists().is_some_and(|shaft| shaft[joint] != 0.0);
            let mut own = self.drive.iter().zip(&chain.drive).filter(|(drive, _)| own(drive));
            own.all(|(_, coefficient)| *coefficient >= 0.0)
        });
        let is_worse = |part: &Tried| {
            let by_torque = all(whole) <= HALF * all(part);
            let by_friction = whole.left <= QUARTER * part.left;
            let is_told = if part.signs == whole.signs ^ 1 << joint {
                by_torque && by_friction
            } else {
                by_torque || by_friction && brakes
            };
            is_told || whole.left <= BY_FRICTION * part.left
        };
        let mut parts = parts.iter().filter(|part| part.signs >> joint & 1 == 0);
        whole.part(rows, joint) < HALF && parts.all(is_worse)
    }

    /// The signs that leave least; where others fit alike, those of fewer joints, and of a set and
    /// the rest those with which kinetic energy is positive.
    fn best<'a>(&self, tried: &'a [Tried], motion: &Motion) -> &'a Tried {
        let best = tried.iter().min_by(|a, b| least(a, b)).unwrap_or(&tried[0]);
        let is_negative =
            best.chain.as_ref().is_some_and(|chain| self.kinetic_energy(chain, motion) < 0.0);
        let all_turned = (1 << motion.n_joints()) - 1;
        let rest = tried.iter().find(|rest| is_negative && rest.signs == best.signs ^ all_turned);
        rest.filter(|rest| rest.left <= ALIKE * best.left).unwrap_or(best)
    }

    /// Product over joints of the mean square that a chain leaves, or that friction adds which drives
    /// its shaft, over the variance of the torque: a joint that nothing explains does not count.
    fn left(&self, chain: &Chain, rows: &ChainRows, motion: &Motion, extras: &Mat<f64>) -> f64 {
        let mut left: Vec<f64> = chain.residual_rms.iter().map(|rms| rms * rms).collect();
        let mut shafts: Vec<&[f64]> = self.drive.iter().filter_map(DriveTerm::resists).collect();
        shafts.sort_by(|a, b| a.partial_cmp(b).unwrap_or(std::cmp::Ordering::Equal));
        shafts.dedup();
        for shaft in shafts {
            let own = |drive: &DriveTerm| drive.resists() == Some(shaft);
            let load = |row: usize, joint: usize| -> f64 {
                let terms = self.drive.iter().zip(&chain.drive).enumerate();
                let own = terms.filter(|(_, (drive, _))| own(drive));
                own.map(|(k, (_, coefficient))| {
                    coefficient * extras[(joint * motion.n_rows() + row, k)]
                })
                .sum()
            };
            let joints: Vec<usize> = (0..shaft.len()).filter(|&j| shaft[j] != 0.0).collect();
            let (mut power, mut squares) = (0.0, vec![0.0; shaft.len()]);
            for row in 0..motion.n_rows() {
                for &joint in &joints {
                    let load = load(row, joint);
                    power += load * motion.dq()[(row, joint)];
                    squares[joint] += load * load / motion.n_rows() as f64;
                }
            }
            if power < 0.0 {
                left.iter_mut().zip(squares).for_each(|(left, square)| *left += square);
            }
        }
        let deviation = |joint: usize| rows.deviation_of(joint).max(f64::MIN_POSITIVE);
        let part = |(joint, left): (usize, &f64)| (left / deviation(joint).powi(2)).max(LEAST_LEFT);
        left.iter().enumerate().map(part).product()
    }

    /// Twice that of links and rotors, summed over the rows.
    fn kinetic_energy(&self, chain: &Chain, motion: &Motion) -> f64 {
        let kinematics = Kinematics::new(&chain.geometry).without_gravity();
        let (dq, mut sum) = (motion.dq(), 0.0);
        kinematics.torques([Some(motion.q()), None, Some(dq)], &chain.inertial, |row, joint, p| {
            sum += p * dq[(row, joint)];
        });
        for (drive, inertia) in self.drive.iter().zip(&chain.drive) {
            let DriveTerm::Rotor(shaft) = drive else { continue };
            for row in 0..motion.n_rows() {
                let turning = shaft.iter().enumerate().map(|(joint, s)| s * dq[(row, joint)]);
                sum += inertia * turning.sum::<f64>().powi(2);
            }
        }
        sum
    }
}

/// A chain with the torque of some joints turned round.
struct Tried {
    /// Bit k: joint k is turned.
    signs: u32,
    left: f64,
    chain: Option<Chain>,
}

impl Tried {
    /// What the chain leaves of the torque of a joint, RMS over the spread.
    fn part(&self, rows: &ChainRows, joint: usize) -> f64 {
        let rms = self.chain.as_ref().and_then(|chain| chain.residual_rms.get(joint));
        rms.map_or(f64::INFINITY, |rms| rms / rows.deviation_of(joint).max(f64::MIN_POSITIVE))
    }
}

/// What leaves least first, then what turns fewer joints.
fn least(a: &Tried, b: &Tried) -> std::cmp::Ordering {
    a.left.total_cmp(&b.left).then(a.signs.count_ones().cmp(&b.signs.count_ones()))
}

/// The joints that signs turn.
fn joints_of(signs: u32) -> impl Iterator<Item = usize> {
    (0..u32::BITS as usize).filter(move |joint| signs >> joint & 1 == 1)
}
