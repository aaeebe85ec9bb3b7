//! Public logs of real arms → docs/real-arms.md: torque models without kinematics beside a full
//! rigid-body regressor that is given them.
//!
//! `cargo bench -p torquewise --bench real_arms` writes the page; arguments name sets to run.
//! The data are other people's and stay beside the project: `TORQUEWISE_SHARED` says where.

#[path = "real_arms/peer.rs"]
mod peer;
#[path = "real_arms/sets.rs"]
mod sets;
#[path = "real_arms/delan.rs"]
mod delan;
#[path = "real_arms/page.rs"]
mod page;

use peer::Peer;
use sets::{Set, Split};
use std::error::Error;
use std::path::{Path, PathBuf};
use std::time::Instant;
use torquewise::identify::cutoff::{MULTIPLES, choose_cutoff};
use torquewise::identify::plan::ChainOptions;
use torquewise::identify::{reconstruct, score};
use torquewise::logs::{Clock, ConditionedLogs, LogError, Logs, Options, Profile};
use torquewise::model::Model;
use torquewise::model::model::Choice;
use torquewise::motion::{BLOCK_ROWS, Motion, ReadError, Recording, Signals};
use torquewise::signals::{ConditionReport, Conditioning};

/// What is put down of one set.
struct Outcome {
    set: Set,
    report: ConditionReport,
    rows: [usize; 2],
    joints: Vec<String>,
    model: Model,
    seconds: f64,
    ours: Errors,
    peer: Errors,
}

/// Errors on the test rows, by joint.
struct Errors {
    rmse: Vec<f64>,
    nrmse: Vec<f64>,
}

fn main() -> Result<(), Box<dyn Error + Send + Sync>> {
    let Some(shared) = shared() else {
        println!("skipped: the data are not there; set TORQUEWISE_SHARED to their folder");
        return Ok(());
    };
    let wanted: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with("--")).collect();
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
    if wanted.is_empty() {
        let page = page::page(&outcomes, parts.as_ref());
        std::fs::write(project().join("docs/real-arms.md"), page)?;
    }
    Ok(())
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
    let (conditioned, cutoff) = conditioned(logs)?;
    let motion = whole(&conditioned)?;
    let noise = noise_of(&conditioned, &motion)?;
    let (train, test) = split(&motion, set.split);
    let (train, noise, test) = (motion.select(&train), noise.select(&train), motion.select(&test));

    let start = Instant::now();
    let options = ChainOptions {
        counterbalanced: set.counterbalanced.iter().map(ToString::to_string).collect(),
        ..ChainOptions::default()
    };
    let recording = Filtered { motion: &train, noise: &noise };
    let mut found = reconstruct(&recording, &options.into(), &mut |_| {})?;
    found.model.choices.splice(0..0, cutoff);
    let seconds = start.elapsed().as_secs_f64();
    let scores = score(&found.model, &test)?;
    let ours = Errors {
        rmse: scores.joints.iter().map(|joint| joint.rmse).collect(),
        nrmse: scores.joints.iter().map(|joint| joint.nrmse_percent / 100.0).collect(),
    };
    let peer =
        Peer::fit(&set.arm(data)?, set.shafts, set.counterbalanced, &train)?.errors(&test)?;
    Ok(Outcome {
        report: conditioned.report().clone(),
        rows: [train.n_rows(), test.n_rows()],
        joints: motion.joints().to_vec(),
        model: found.model,
        seconds,
        ours,
        peer,
        set,
    })
}

/// Logs filtered at the cut-off that `fit` would choose, and the record of the choice.
fn conditioned(logs: Logs) -> Result<(ConditionedLogs, Option<Choice>), LogError> {
    let logs = ConditionedLogs::new(logs, &Conditioning::default(), true)?;
    let suggested = logs.report().cutoff.unwrap_or_default();
    let candidates = logs.at_cutoffs(&MULTIPLES.map(|multiple| multiple * suggested))?;
    Ok(match choose_cutoff(&candidates) {
        Some((place, choice)) if place > 0 => {
            (logs.with_cutoff(candidates[place].0)?, Some(choice))
        }
        found => (logs, found.map(|(_, choice)| choice)),
    })
}

/// Seed of the noise.
const SEED: u64 = 1;

/// What noise of the raw samples becomes in the rows of a recording.
fn noise_of(
    recording: &ConditionedLogs,
    motion: &Motion,
) -> Result<Motion, Box<dyn Error + Send + Sync>> {
    let mut noise: Vec<Motion> = Vec::new();
    for log in 0..recording.n_logs() {
        recording.read_log_with_noise(log, SEED, &mut |_, _, own| {
            noise.push(own.clone());
            Ok(())
        })?;
    }
    joined(motion.joints(), &noise)
}

/// Rows that went through a filter, and what became of their noise there.
struct Filtered<'a> {
    motion: &'a Motion,
    noise: &'a Motion,
}

impl Recording for Filtered<'_> {
    fn joints(&self) -> &[String] {
        self.motion.joints()
    }

    fn is_filtered(&self) -> bool {
        true
    }

    fn read(
        &self,
        visit: &mut dyn FnMut(usize, &Motion) -> Result<(), ReadError>,
    ) -> Result<(), ReadError> {
        self.motion.read(visit)
    }

    fn read_log_with_noise(
        &self,
        log: usize,
        _: u64,
        visit: &mut dyn FnMut(usize, &Motion, &Motion) -> Result<(), ReadError>,
    ) -> Result<bool, ReadError> {
        let rows: Vec<usize> = (0..self.motion.n_rows()).filter(|_| log == 0).collect();
        let mut blocks = rows.chunks(BLOCK_ROWS);
        blocks.try_for_each(|b| visit(0, &self.motion.select(b), &self.noise.select(b)))?;
        Ok(true)
    }
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

/// Rows to train on and to test on.
fn split(motion: &Motion, split: Split) -> (Vec<usize>, Vec<usize>) {
    let t = motion.t();
    let (begin, end) = (t[0], t[t.len() - 1]);
    let is_test = |row: usize| match split {
        Split::Time => t[row] > begin + 0.7 * (end - begin),
        Split::Blocks(seconds) => ((t[row] - begin) / seconds) % 3.0 >= 2.0,
    };
    (0..t.len()).partition(|&row| !is_test(row))
}
