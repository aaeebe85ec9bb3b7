//! Logs to try the page with: simulated when they are asked for.

use torquewise::Error;
use torquewise::dynamics::friction::{Friction, Stribeck};
use torquewise::dynamics::{Arm, MotionKind, MotionPlan, Noise, SimulatedLog, add_noise};
use torquewise::motion::Motion;

/// A log to try the page with.
#[derive(Clone, Copy, Debug)]
pub struct Example {
    /// What the page asks for it by, and what its file is called but for the ending.
    pub name: &'static str,
    /// Which of the built-in arms moves.
    arm: &'static str,
    kind: MotionKind,
    seconds: f64,
    seed: u64,
    /// Noise as the command line counts it, 1 for none.
    case: u8,
    /// Dry friction \[N·m\] and viscous friction \[N·m·s/rad\] of each joint.
    friction: &'static [[f64; 2]],
    /// Whether it looks as robots record: positions in degrees, currents, names of its own.
    is_raw: bool,
}

/// Rows per second.
const RATE: f64 = 100.0;

/// What an ampere is worth in the raw log \[N·m/A\].
const TORQUE_CONSTANT: f64 = 2.5;

const USUAL: Example = Example {
    name: "",
    arm: "planar-2",
    kind: MotionKind::Moves,
    seconds: 60.0,
    seed: 1,
    case: 1,
    friction: &[],
    is_raw: false,
};

/// All of them.
pub const EXAMPLES: [Example; 4] = [
    Example { name: "two-joints", seconds: 120.0, case: 2, ..USUAL },
    Example {
        name: "two-joints-other-motion",
        kind: MotionKind::Sines,
        seconds: 20.0,
        seed: 2,
        ..USUAL
    },
    Example {
        name: "raw-columns",
        seed: 3,
        friction: &[[1.5, 0.8], [0.6, 0.3]],
        is_raw: true,
        ..USUAL
    },
    Example { name: "gantry", arm: "gantry-3", seed: 4, case: 2, ..USUAL },
];

impl Example {
    /// The log as CSV.
    ///
    /// # Errors
    /// [`Error::Arm`] if the arm is not known.
    pub fn csv(&self) -> Result<String, Error> {
        let arm = Arm::builtin(self.arm)?;
        let plan =
            MotionPlan { kind: self.kind, seconds: self.seconds, rate: RATE, seed: self.seed };
        let mut log = SimulatedLog::new(&arm, &plan)?;
        if !self.friction.is_empty() {
            let law = |&[dry, viscous]: &[f64; 2]| Stribeck {
                coulomb: dry,
                stiction: dry,
                speed: 1.0,
                viscous,
            };
            let laws: Vec<Stribeck> = self.friction.iter().map(law).collect();
            log = log.with_friction(Friction::new(&laws)?)?;
        }
        let mut motion = log.whole()?.motion;
        if self.case > 1 {
            motion = add_noise(&motion, &Noise::case(self.case)?, self.seed)?;
        }
        Ok(if self.is_raw { raw(&motion) } else { plain(&motion) })
    }
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
