//! Logs to try the page with: simulated when they are asked for.

use std::fmt::Write;
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
    let n = motion.n_joints();
    let named = ["q", "dq", "ddq", "tau"].map(|name| (1..=n).map(move |k| format!(",{name}{k}")));
    let header = named.into_iter().flatten().collect::<String>();
    written(motion, &format!("t{header}"), |motion, row| {
        let signals = [Some(motion.q()), Some(motion.dq()), Some(motion.ddq()), motion.tau()];
        let signals = signals.into_iter().flatten();
        let values = signals.flat_map(|signal| signal.row(row).iter().copied().collect::<Vec<_>>());
        std::iter::once(motion.t()[row]).chain(values).collect()
    })
}

/// A clock in ms, positions in degrees and currents, by names that a program cannot know.
fn raw(motion: &Motion) -> String {
    let letters = || (b'A'..).take(motion.n_joints()).map(char::from);
    let names = ["encoder", "drive"].map(|name| letters().map(move |k| format!(",{name}_{k}")));
    let header = names.into_iter().flatten().collect::<String>();
    written(motion, &format!("tick_ms{header}"), |motion, row| {
        let degrees = motion.q().row(row).iter().map(|q| q.to_degrees()).collect::<Vec<_>>();
        let tau =
            motion.tau().map(|tau| tau.row(row).iter().map(|x| x / TORQUE_CONSTANT).collect());
        let tau: Vec<f64> = tau.unwrap_or_default();
        std::iter::once((1e3 * motion.t()[row]).round()).chain(degrees).chain(tau).collect()
    })
}

fn written(motion: &Motion, header: &str, row: impl Fn(&Motion, usize) -> Vec<f64>) -> String {
    let mut text = format!("{header}\n");
    for k in 0..motion.n_rows() {
        for (place, value) in row(motion, k).into_iter().enumerate() {
            // A text takes all that is written into it.
            let _ = write!(text, "{}{value:?}", if place == 0 { "" } else { "," });
        }
        text.push('\n');
    }
    text
}
