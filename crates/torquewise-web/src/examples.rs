//! Logs to try the page with: simulated when they are asked for.

use torquewise::Error;
use torquewise::dynamics::friction::{Friction, Stribeck};
use torquewise::dynamics::{Arm, MotionKind, MotionPlan, Noise, SimulatedLog, add_noise};
use torquewise::motion::Motion;

/// Rows per second.
const RATE: f64 = 100.0;

/// What an ampere is worth in the raw log \[N·m/A\].
const TORQUE_CONSTANT: f64 = 2.5;

/// An example as CSV, by what its file is called but for the ending; none by another name.
///
/// The raw one looks as robots record: positions in degrees, currents, names of its own.
///
/// # Errors
/// [`Error::Arm`] if it cannot be simulated.
pub fn csv(name: &str) -> Result<Option<String>, Error> {
    // The last is the case of noise, 1 for none.
    let (arm, kind, seconds, seed, case) = match name {
        "two-joints" => ("planar-2", MotionKind::Moves, 120.0, 1, 2),
        "two-joints-other-motion" => ("planar-2", MotionKind::Sines, 20.0, 2, 1),
        "raw-columns" => ("planar-2", MotionKind::Moves, 60.0, 3, 1),
        "gantry" => ("gantry-3", MotionKind::Moves, 60.0, 4, 2),
        _ => return Ok(None),
    };
    let is_raw = name == "raw-columns";
    let plan = MotionPlan { kind, seconds, rate: RATE, seed };
    let mut log = SimulatedLog::new(&Arm::builtin(arm)?, &plan)?;
    if is_raw {
        let law = |[dry, viscous]: [f64; 2]| {
            let (coulomb, stiction) = (dry, dry);
            Stribeck { coulomb, stiction, speed: 1.0, viscous }
        };
        log = log.with_friction(Friction::new(&[[1.5, 0.8], [0.6, 0.3]].map(law))?)?;
    }
    let mut motion = log.whole()?.motion;
    if case > 1 {
        motion = add_noise(&motion, &Noise::case(case)?, seed)?;
    }
    Ok(Some(if is_raw { raw(&motion) } else { plain(&motion) }))
}

/// Columns in SI units by their usual names.
fn plain(motion: &Motion) -> String {
    let signals = [("q", motion.q()), ("dq", motion.dq()), ("ddq", motion.ddq())];
    let mut columns = vec![("t".to_owned(), motion.t().to_vec())];
    for (name, signal) in signals.into_iter().chain(motion.tau().map(|tau| ("tau", tau))) {
        for (k, x) in (1..).zip(signal.col_iter()) {
            columns.push((format!("{name}{k}"), x.iter().copied().collect()));
        }
    }
    written(columns)
}

/// A clock in ms, positions in degrees and currents, by names that a program cannot know.
fn raw(motion: &Motion) -> String {
    let clock = motion.t().iter().map(|t| (1e3 * t).round()).collect();
    let mut columns = vec![("tick_ms".to_owned(), clock)];
    for (k, q) in ('A'..).zip(motion.q().col_iter()) {
        columns.push((format!("encoder_{k}"), q.iter().map(|q| q.to_degrees()).collect()));
    }
    for (k, tau) in ('A'..).zip(motion.tau().iter().flat_map(|tau| tau.col_iter())) {
        columns.push((format!("drive_{k}"), tau.iter().map(|tau| tau / TORQUE_CONSTANT).collect()));
    }
    written(columns)
}

fn written(columns: Vec<(String, Vec<f64>)>) -> String {
    let (names, columns): (Vec<_>, Vec<_>) = columns.into_iter().unzip();
    let row = |k: usize| columns.iter().map(|x| format!("{:?}", x[k])).collect::<Vec<_>>();
    let rows = (0..columns[0].len()).map(row);
    std::iter::once(names).chain(rows).map(|row| row.join(",") + "\n").collect()
}
