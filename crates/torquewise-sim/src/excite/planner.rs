//! Three recordings that a model can be reconstructed from, on one page.

use crate::excite::design::Task;
use crate::excite::information::DesignCriterion;
use crate::excite::library::{Library, Stage};
use crate::excite::limits::Limits;
use crate::excite::recording::Planned;
use crate::excite::segment::Segment;
use crate::excite::torques::Torques;
use crate::{Bounds, Result, SimError, check_between, check_joints};
use faer::Mat;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use torquewise_motion::motion::stacked;
use torquewise_motion::whole;
use torquewise_rigid::JointKind;

/// What is to be planned.
#[derive(Clone, Debug, PartialEq)]
pub struct ExcitationPlan {
    /// Time \[s\] at most of the recordings at standstill, uniform and variable velocity.
    pub seconds: [f64; 3],
    /// Time \[s\] a pose is held, or passed in each direction.
    pub dwell: f64,
    /// Whether poses are passed slowly in both directions, so that dry friction is defined.
    pub slow_sweeps: bool,
    /// Rows per second.
    pub rate: f64,
    /// Pose \[rad\] at both ends of each recording; `None` for zero where a joint may be there,
    /// else the middle of its range.
    pub home: Option<Vec<f64>>,
    /// How many joint angles a term of the library may hold; `None`: two if that is feasible.
    pub interaction: Option<usize>,
    /// Poses, sweeps and sines to choose from, each time; 1 takes the first.
    pub tries: usize,
    /// Seed of everything random: one seed, one plan, bit by bit.
    pub seed: u64,
}

impl Default for ExcitationPlan {
    fn default() -> Self {
        Self {
            seconds: [60.0, 120.0, 60.0],
            dwell: 0.5,
            slow_sweeps: false,
            rate: 100.0,
            home: None,
            interaction: None,
            tries: 24,
            seed: 0,
        }
    }
}

/// Three recordings, and how much they tell.
#[derive(Clone, Debug)]
pub struct Excitation {
    /// `standstill`, `uniform`, `variable`.
    pub recordings: [Planned; 3],
    /// How far each joint goes in each recording, 3×n: least and greatest position, largest speed and
    /// acceleration.
    pub peaks: [Vec<Bounds>; 3],
    /// What is told once each recording is there: by poses about V and offsets; by sweeps too,
    /// about the part of M that depends on q and friction besides; by all rows about everything.
    pub criteria: [DesignCriterion; 3],
    /// The same of recordings drawn at random within the same limits and times.
    pub random: [DesignCriterion; 3],
    /// How many joint angles a term of the library may hold.
    pub interaction: usize,
    /// Speeds of the plan as a share of those planned without limits of the torque.
    pub speed: f64,
    /// Largest torque of each joint \[N·m\], n; none where it has no limits.
    pub torques: Option<Vec<f64>>,
    /// Joints that never sweep alone, because the time is too short.
    pub not_alone: Vec<String>,
}

/// Names of the recordings, in the order in which the method uses them.
const NAMES: [&str; 3] = ["standstill", "uniform", "variable"];
const PIECES: [&str; 3] = ["pose", "sweep", "period of sines"];
/// Poses are cheap to judge.
const POSES_PER_TRY: usize = 8;
/// More columns than these have one round less, in which each part is looked at again.
const QUICK_COLUMNS: usize = 700;
/// States of the three recordings by which all of them together are judged, at least.
const GRID: usize = 600;
/// Rows of a recording at most: all are checked, and instants between them.
const MOST_ROWS: f64 = 2e6;
/// How often the last recording is planned anew where a random plan is better conditioned.
const AGAIN: u64 = 3;
/// How much finer recordings are judged than parts are compared.
const DENSITY: u8 = 4;

/// Plans three recordings within the limits of n joints.
///
/// Poses, sweeps at constant speed and sums of sines are chosen one by one, each as the one of
/// some random ones that adds most information per second about the coefficients of the energy
/// library and of friction, then varied as long as that helps. Every recording begins and ends at
/// rest at home. Limits hold at every instant: those of glides and sweeps in closed form, those of
/// sines by a bound on trigonometric polynomials; all are checked on a fine grid besides.
///
/// Collisions, of the arm with itself or its surroundings, are not known here.
///
/// - `torques`: what the drives can do; speeds are lowered together until motions keep to it
/// - `progress`: told the share of the work that is done, and what is planned
///
/// # Errors
/// [`SimError`]: a setting out of bounds, a recording too short for a single part, or a torque that
/// no motion keeps to.
pub fn excite(
    limits: &[Limits],
    torques: Option<&Torques>,
    plan: &ExcitationPlan,
    progress: Tell<'_>,
) -> Result<Excitation> {
    let home = home(limits, plan)?;
    plan.check()?;
    let joints: Vec<String> = limits.iter().map(|limits| limits.joint.clone()).collect();
    let kinds: Vec<JointKind> = limits.iter().map(|limits| limits.kind).collect();
    let bounds: Vec<Bounds> = limits.iter().map(|limits| limits.planned).collect();
    let slowed = torques.map(|torques| torques.slowed(&bounds, &home)).transpose()?;
    let (speed, bounds) = slowed.unwrap_or((1.0, bounds));
    let library = Library::new(&kinds, &bounds, plan.interaction)?;
    let setting = Setting { plan, joints: &joints, bounds: &bounds, home: &home, torques, library };

    let random = setting.criteria(&setting.design(1, &mut |_, _| {})?)?;
    let mut recordings = setting.design(plan.tries, progress)?;
    progress(1.0, "judging");
    let mut criteria = setting.criteria(&recordings)?;
    for again in 1..=AGAIN {
        if criteria[2].condition <= random[2].condition {
            break;
        }
        // The most information need not be the best conditioned: other sines may be.
        let before = [&recordings[0], &recordings[1]];
        let other = setting.recording(&before, plan.tries, again, &mut |_, _| {})?;
        let other = [recordings[0].clone(), recordings[1].clone(), other];
        let judged = setting.criteria(&other)?;
        if judged[2].condition < criteria[2].condition {
            (recordings, criteria) = (other, judged);
        }
    }
    let [standstill, uniform, variable] = recordings.each_ref().map(|own| own.peaks(&bounds));
    Ok(Excitation {
        criteria,
        random,
        speed,
        torques: torques.map(|torques| torques.checked(&recordings)).transpose()?,
        not_alone: setting.not_alone(&recordings[1]),
        interaction: setting.library.interaction,
        peaks: [standstill?, uniform?, variable?],
        recordings,
    })
}

/// Who is told the share of the work that is done, and what is planned.
pub type Tell<'a> = &'a mut dyn FnMut(f64, &'static str);

struct Setting<'a> {
    plan: &'a ExcitationPlan,
    joints: &'a [String],
    bounds: &'a [Bounds],
    home: &'a [f64],
    torques: Option<&'a Torques>,
    library: Library,
}

impl Setting<'_> {
    /// Plans the recordings one after the other; each knows what those before tell.
    fn design(&self, tries: usize, tell: Tell<'_>) -> Result<[Planned; 3]> {
        let standstill = self.recording(&[], tries, 0, tell)?;
        let uniform = self.recording(&[&standstill], tries, 0, tell)?;
        let variable = self.recording(&[&standstill, &uniform], tries, 0, tell)?;
        Ok([standstill, uniform, variable])
    }

    /// `again`: which numbers are drawn by.
    fn recording(
        &self,
        before: &[&Planned],
        tries: usize,
        again: u64,
        tell: Tell<'_>,
    ) -> Result<Planned> {
        let Self { plan, joints, bounds, home, torques, .. } = *self;
        let k = before.len();
        let (name, seconds, stage) = (NAMES[k], plan.seconds[k], self.stages()[k]);
        let library = &self.library.share(stage);
        let known = library.rows_of(before.iter().flat_map(|recording| &recording.parts), 1)?;
        let rounds = match tries {
            1 => 0,
            _ if self.library.n_columns() > QUICK_COLUMNS => 1,
            _ => 2,
        };
        let tries = if tries > 1 && k == 0 { POSES_PER_TRY * tries } else { tries };
        let task = Task { stage, library, limits: bounds, home, torques, seconds, tries, rounds };
        // Each recording has numbers of its own, whatever the others draw.
        let mut rng = ChaCha8Rng::seed_from_u64(plan.seed);
        rng.set_stream(k as u64 + NAMES.len() as u64 * again);
        let mut tell = |share: f64| tell((k as f64 + share) / 3.0, name);
        let parts = task.design(&known, &mut rng, &mut tell)?;
        if parts.is_empty() {
            return Err(SimError::TooShort { recording: name, seconds, piece: PIECES[k] });
        }
        Ok(Planned::new(name, joints, plan.rate, home, parts, bounds))
    }

    fn stages(&self) -> [Stage; 3] {
        let ExcitationPlan { dwell, slow_sweeps: creep, .. } = *self.plan;
        [Stage::Standstill { dwell, creep }, Stage::Uniform, Stage::Variable]
    }

    fn criteria(&self, recordings: &[Planned; 3]) -> Result<[DesignCriterion; 3]> {
        let library = &self.library;
        let of = |rows: &[Mat<f64>], seconds| {
            let columns = rows.first().map_or(0, Mat::ncols);
            let parts: Vec<_> = rows.iter().map(Mat::as_ref).collect();
            DesignCriterion::of(stacked(columns, &parts).as_ref(), seconds)
        };
        let until = |stage: usize| {
            let parts = || recordings[..=stage].iter().flat_map(|recording| &recording.parts);
            let seconds = parts().flat_map(|part| part.states(1).seconds).sum();
            let rows = library.share(self.stages()[stage]).rows_of(parts(), DENSITY)?;
            Ok::<_, SimError>(of(&rows, seconds))
        };
        let seconds: f64 = recordings.iter().map(|recording| recording.seconds).sum();
        let least = GRID.max(3 * library.n_columns() / self.bounds.len());
        let mut rows = Vec::with_capacity(recordings.len());
        for recording in recordings {
            let points = whole((least as f64 * recording.seconds / seconds).ceil());
            rows.push(library.rows(&recording.grid(points.max(1)))?);
        }
        Ok([until(0)?, until(1)?, of(&rows, seconds)])
    }

    fn not_alone(&self, uniform: &Planned) -> Vec<String> {
        let alone = |joint: usize| {
            uniform.parts.iter().any(|part| match &part.there {
                Segment::Stroke { travel, .. } => {
                    travel.iter().enumerate().all(|(k, way)| (k == joint) == (*way != 0.0))
                }
                _ => false,
            })
        };
        let names = self.joints.iter().enumerate().filter(|(joint, _)| !alone(*joint));
        names.map(|(_, name)| name.clone()).collect()
    }
}

/// The pose at both ends: as asked, else zero, else the middle of the range.
fn home(limits: &[Limits], plan: &ExcitationPlan) -> Result<Vec<f64>> {
    let n = limits.len();
    check_joints("home", plan.home.as_ref().map_or(n, Vec::len), n)?;
    let of_joint = |(joint, limits): (usize, &Limits)| {
        let [lower, upper] = limits.planned.position;
        let usual = if lower <= 0.0 && 0.0 <= upper { 0.0 } else { f64::midpoint(lower, upper) };
        let home = plan.home.as_ref().map_or(usual, |home| home[joint]);
        if (lower..=upper).contains(&home) {
            return Ok(home);
        }
        Err(SimError::Home { joint: limits.joint.clone(), home, lower, upper })
    };
    limits.iter().enumerate().map(of_joint).collect()
}

impl ExcitationPlan {
    /// Refuses numbers of which no plan can be made, or only one beyond all memory and patience.
    fn check(&self) -> Result<()> {
        for (name, seconds) in NAMES.into_iter().zip(self.seconds) {
            let what = format!("time of `{name}` [s]");
            check_between(what, seconds, [1.0, 3_600.0], "from 1 to 3600")?;
        }
        check_between("dwell [s]", self.dwell, [0.05, 60.0], "from 0.05 to 60")?;
        check_between("rate [Hz]", self.rate, [1.0, 10_000.0], "from 1 to 10000")?;
        check_between("number of tries", self.tries as f64, [1.0, 1e5], "from 1 to 100000")?;
        let rows = self.rate * self.seconds.iter().copied().fold(0.0, f64::max);
        let expected = "seconds times rate up to 2000000";
        check_between("number of rows", rows, [0.0, MOST_ROWS], expected)?;
        let order = self.interaction.unwrap_or(1) as f64;
        check_between("interaction order", order, [1.0, f64::INFINITY], "1 or more")
    }
}
