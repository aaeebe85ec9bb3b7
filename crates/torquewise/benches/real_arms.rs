//! From public logs of real arms to docs/real-arms.md: torque models without kinematics beside a
//! full rigid-body regressor that is given them.
//!
//! `cargo bench -p torquewise --bench real_arms` writes the page; arguments name sets to run;
//! `further` writes the section of the arms without kinematics alone. The data are other people's
//! and stay beside the project: `TORQUEWISE_SHARED` and `TORQUEWISE_ARMS` name their folders.

#[path = "real_arms/peer.rs"]
mod peer;
#[path = "real_arms/sets.rs"]
mod sets;
#[path = "real_arms/delan.rs"]
mod delan;
#[path = "real_arms/further.rs"]
mod further;
#[path = "real_arms/page.rs"]
mod page;
#[path = "real_arms/published.rs"]
mod published;
#[path = "real_arms/split.rs"]
mod split;

use peer::Peer;
use sets::Set;
use std::error::Error;
use std::path::{Path, PathBuf};
use torquewise::dynamics::Arm;
use torquewise::identify::plan::KnownGeometry;
use torquewise::identify::score;
use torquewise::log::Prepared;
use torquewise::logs::{Clock, ConditionedLogs, Logs, Options, Profile};
use torquewise::motion::{Motion, Recording, Signals};
use torquewise::signals::ConditionReport;
use torquewise::{Filter, Fit, FitOptions, FitResult, Library, Log, Model};

/// What is put down of one set.
struct Outcome {
    set: Set,
    joints: Vec<String>,
    /// One for each way to cut the log.
    runs: Vec<Run>,
}

/// One training part and its test.
struct Run {
    report: ConditionReport,
    rows: [usize; 2],
    model: Model,
    seconds: f64,
    ours: Errors,
    /// Ours, told where the axes lie, in the same band.
    told: Errors,
    told_seconds: f64,
    peer: Errors,
}

/// Errors on the test rows, by joint.
struct Errors {
    rmse: Vec<f64>,
    nrmse: Vec<f64>,
}

fn main() -> Result<(), Box<dyn Error + Send + Sync>> {
    let wanted: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with("--")).collect();
    let file = project().join("docs/real-arms.md");
    let old = std::fs::read_to_string(&file)?;
    let (mut sets, mut arms) = published::parted(&old);
    let only_further = wanted == ["further"];
    if !only_further {
        sets = run_sets(&wanted)?.unwrap_or(sets);
    }
    if only_further || wanted.is_empty() {
        match further::run()? {
            Some(outcomes) => {
                arms = published::section(&outcomes)?;
                print!("{arms}");
            }
            None => println!("skipped: further arms; set TORQUEWISE_ARMS to their folder"),
        }
        std::fs::write(file, sets + &arms)?;
    }
    Ok(())
}

/// The page of all sets, if their data are there.
fn run_sets(wanted: &[String]) -> Result<Option<String>, Box<dyn Error + Send + Sync>> {
    let Some(shared) = shared() else {
        println!("skipped: the data are not there; set TORQUEWISE_SHARED to their folder");
        return Ok(None);
    };
    let mut outcomes = Vec::new();
    for set in sets::all() {
        if !wanted.is_empty() && !wanted.iter().any(|name| set.name.contains(name.as_str())) {
            continue;
        }
        let outcome = run(set, &shared)?;
        print!("{}", page::section(&outcome));
        outcomes.push(outcome);
    }
    let parts = delan::run(&project())?;
    print!("{}", page::parts(parts.as_ref()));
    Ok(Some(page::page(&outcomes, parts.as_ref())))
}

fn project() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// The folder of the data, if it is there.
fn shared() -> Option<PathBuf> {
    let named = std::env::var_os("TORQUEWISE_SHARED").map(PathBuf::from);
    let folder = named.unwrap_or_else(|| project().join("../shared")).join("data");
    folder.is_dir().then_some(folder)
}

fn run(set: Set, data: &Path) -> Result<Outcome, Box<dyn Error + Send + Sync>> {
    let profile = Profile::read(&project().join("profiles").join(set.profile))?;
    let options = Options { profile: Some(profile), topic: None, clock: Clock::Repair };
    let logs = Logs::open_with(&[data.join(set.log)], &options)?;
    let options = FitOptions {
        library: Some(Library::Chain),
        counterbalanced: set.counterbalanced.iter().map(ToString::to_string).collect(),
        ..FitOptions::default()
    };
    let arm = set.arm(data)?;
    let folder = std::env::temp_dir().join(format!("torquewise-real-arms-{}", std::process::id()));
    let mut runs = Vec::new();
    for way in 0..split::WAYS {
        let [train, test] = split::written(&logs, (set.split, way), &folder)?;
        runs.push(one(&set, &arm, (&train, &test), &options)?);
        std::fs::remove_dir_all(&folder)?;
    }
    Ok(Outcome { joints: logs.joints().to_vec(), runs, set })
}

/// Fits logs as the command line does.
fn fitted(
    logs: &[PathBuf],
    options: &FitOptions,
) -> Result<(FitResult, ConditionedLogs), Box<dyn Error + Send + Sync>> {
    let log = Log::open_all(logs, &Options::default())?;
    let mut fit = Fit::new(&log).options(options.clone()).run()?;
    let filtered = fit.log.take().and_then(Prepared::into_conditioned);
    Ok((fit, filtered.ok_or("the log is not filtered")?))
}

impl Errors {
    fn of(model: &Model, test: &ConditionedLogs) -> Result<Self, Box<dyn Error + Send + Sync>> {
        let joints = score(model, test)?.joints;
        Ok(Self {
            rmse: joints.iter().map(|joint| joint.rmse).collect(),
            nrmse: joints.iter().map(|joint| joint.nrmse_percent / 100.0).collect(),
        })
    }
}

/// Fits one training part, and judges it on the other.
fn one(
    set: &Set,
    arm: &Arm,
    (train, test): (&[PathBuf], &[PathBuf]),
    options: &FitOptions,
) -> Result<Run, Box<dyn Error + Send + Sync>> {
    let (fit, recording) = fitted(train, options)?;
    let test = ConditionedLogs::new(Logs::open(test)?, recording.settings(), false)?;
    let ours = Errors::of(&fit.model, &test)?;
    let mut same_band = Log::open_all(train, &Options::default())?;
    same_band.filter = recording.report().cutoff.map_or(Filter::Auto, Filter::Hz);
    same_band.delay = Some(recording.settings().delay);
    let geometry = Some(KnownGeometry { geometry: arm.geometry(), robot: None });
    let options = FitOptions { geometry, ..options.clone() };
    let told = Fit::new(&same_band).options(options).run()?;
    let (told, told_seconds) = (Errors::of(&told.model, &test)?, told.seconds);
    let (train, test) = (whole(&recording)?, whole(&test)?);
    let peer = Peer::fit(arm, set.shafts, set.counterbalanced, &train)?.errors(&test)?;
    Ok(Run {
        report: recording.report().clone(),
        rows: [train.n_rows(), test.n_rows()],
        model: fit.model.clone(),
        seconds: fit.seconds,
        ours,
        told,
        told_seconds,
        peer,
    })
}

/// All rows of a recording of one trajectory.
fn whole(recording: &impl Recording) -> Result<Motion, Box<dyn Error + Send + Sync>> {
    let mut blocks: Vec<Motion> = Vec::new();
    recording.read(&mut |_, block| {
        blocks.push(block.clone());
        Ok(())
    })?;
    joined(recording.joints(), &blocks)
}

/// Blocks as one motion.
fn joined(joints: &[String], blocks: &[Motion]) -> Result<Motion, Box<dyn Error + Send + Sync>> {
    let place: Vec<(usize, usize)> = (blocks.iter().enumerate())
        .flat_map(|(index, block)| (0..block.n_rows()).map(move |row| (index, row)))
        .collect();
    let n = joints.len();
    let signal = |of: &dyn Fn(&Motion, usize, usize) -> f64| {
        faer::Mat::from_fn(place.len(), n, |row, joint| {
            let (index, row) = place[row];
            of(&blocks[index], row, joint)
        })
    };
    Ok(Motion::new(Signals {
        joints: joints.to_vec(),
        t: blocks.iter().flat_map(Motion::t).copied().collect(),
        q: signal(&|block, row, joint| block.q()[(row, joint)]),
        dq: signal(&|block, row, joint| block.dq()[(row, joint)]),
        ddq: signal(&|block, row, joint| block.ddq()[(row, joint)]),
        tau: Some(signal(&|block, row, joint| block.tau().map_or(0.0, |tau| tau[(row, joint)]))),
    })?)
}
