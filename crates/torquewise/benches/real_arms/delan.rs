//! The DeLaN characters: a simulated two-link arm whose torque parts are known.

use std::error::Error;
use std::path::{Path, PathBuf};
use torquewise::identify::{Plan, reconstruct};
use torquewise::logs::{Clock, ConditionedLogs, Logs, Options, Profile};
use torquewise::model::{Model, Torque};
use torquewise::motion::{Motion, Recording};
use torquewise::signals::Conditioning;

/// RMS error of each part and joint over the RMS of the part, with q̈ given and with q̈ derived.
pub(crate) struct Parts {
    pub(crate) given: [[f64; 2]; 3],
    pub(crate) derived: [[f64; 2]; 3],
    pub(crate) terms: [usize; 2],
    pub(crate) rows: usize,
}

/// Runs the set if its archives are there: `examples/delan_to_npz.py` makes them.
pub(crate) fn run(project: &Path) -> Result<Option<Parts>, Box<dyn Error + Send + Sync>> {
    let Some(folder) = std::env::var_os("TORQUEWISE_DELAN").map(PathBuf::from) else {
        return Ok(None);
    };
    let mut files: Vec<PathBuf> = std::fs::read_dir(folder)?
        .map(|entry| entry.map(|entry| entry.path()))
        .collect::<Result<_, _>>()?;
    files.sort();
    let profile = std::fs::read_to_string(project.join("profiles/delan_character.toml"))?;
    let open = |text: &str| -> Result<Logs, Box<dyn Error + Send + Sync>> {
        let profile = Some(Profile::from_toml(text)?);
        Ok(Logs::open_with(&files, &Options { profile, topic: None, clock: Clock::Repair })?)
    };
    let truths = ["m", "c", "g"].map(|part| profile.replace("\"tau\"", &format!("\"{part}\"")));
    let truths: Vec<Logs> = truths.iter().map(|text| open(text)).collect::<Result<_, _>>()?;
    let without = profile.replace("[ddq]\ncolumns = \"ddq\"\nunit = \"rad/s2\"\n", "");
    let (given, derived) = (open(&profile)?, open(&without)?);
    let first = reconstruct(&given, &Plan::default(), &mut |_| {})?;
    let filtered = ConditionedLogs::new(derived, &Conditioning::default(), true)?;
    let second = reconstruct(&filtered, &Plan::chain(), &mut |_| {})?;
    Ok(Some(Parts {
        terms: [first.model.n_coefficients(), second.model.n_coefficients()],
        rows: first.survey.rows,
        given: errors(&first.model, &given, &truths)?,
        derived: errors(&second.model, &given, &truths)?,
    }))
}

fn all(recording: &impl Recording) -> Result<Vec<Motion>, Box<dyn Error + Send + Sync>> {
    let mut blocks = Vec::new();
    recording.read(&mut |_, block| {
        blocks.push(block.clone());
        Ok(())
    })?;
    Ok(blocks)
}

fn errors(
    model: &Model,
    logs: &Logs,
    truths: &[Logs],
) -> Result<[[f64; 2]; 3], Box<dyn Error + Send + Sync>> {
    let torque = Torque::new(model);
    let parts =
        (all(logs)?.iter()).map(|block| torque.parts(block)).collect::<Result<Vec<_>, _>>()?;
    let mut errors = [[0.0; 2]; 3];
    for (place, truth) in truths.iter().enumerate() {
        let truth = all(truth)?;
        for (joint, error) in errors[place].iter_mut().enumerate() {
            let (mut apart, mut size) = (0.0, 0.0);
            for (block, parts) in truth.iter().zip(&parts) {
                let found = [&parts.inertia, &parts.coriolis, &parts.gravity][place];
                let tau = block.require_tau()?;
                for row in 0..block.n_rows() {
                    apart += (found[(row, joint)] - tau[(row, joint)]).powi(2);
                    size += tau[(row, joint)].powi(2);
                }
            }
            *error = (apart / size).sqrt();
        }
    }
    Ok(errors)
}
