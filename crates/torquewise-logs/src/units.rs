//! Warnings of values so large that their unit cannot be SI.

use crate::gaps::median_step;
use faer::MatRef;
use std::fmt;
use torquewise_motion::Motion;

/// A value that no arm reaches, or a step of t that no log has, in the unit expected.
#[derive(Clone, Debug, PartialEq)]
pub struct UnitWarning {
    /// Column in question, such as `q2` or `t`.
    pub column: String,
    /// The largest absolute value; for t the median step.
    pub value: f64,
    /// The limit it is over, in the unit expected.
    pub limit: f64,
    /// The unit expected, and the one it looks like.
    pub units: (&'static str, &'static str),
}

impl fmt::Display for UnitWarning {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { column, value, limit, units: (expected, likely) } = self;
        let what = if column == "t" { "has steps of" } else { "reaches" };
        write!(out, "{column} {what} {value} {expected}, over {limit}: is it in {likely}? ")?;
        write!(out, "Logs are read in SI units; convert it to {expected}")
    }
}

/// Columns of a motion that look as if they were not in SI units.
///
/// Limits: |q| ≤ 50 rad, |dq| ≤ 100 rad/s, |ddq| ≤ 10⁴ rad/s², |τ| ≤ 10⁵ N·m and a median step of
/// at most 0.5 s. An arm may well be within them in wrong units, so silence proves nothing.
pub fn unit_warnings(motion: &Motion) -> Vec<UnitWarning> {
    let signals = [
        ("q", Some(motion.q()), 50.0, ("rad", "degrees")),
        ("dq", Some(motion.dq()), 100.0, ("rad/s", "degrees/s")),
        ("ddq", Some(motion.ddq()), 1e4, ("rad/s²", "degrees/s²")),
        ("tau", motion.tau(), 1e5, ("N·m", "mN·m")),
    ];
    let mut warnings = Vec::new();
    if let Some(value) = median_step(motion.t()).filter(|step| *step > 0.5) {
        let units = ("s", "milliseconds");
        warnings.push(UnitWarning { column: "t".into(), value, limit: 0.5, units });
    }
    for (signal, values, limit, units) in signals {
        let Some(values) = values else { continue };
        for joint in 0..motion.n_joints() {
            let value = largest(values, joint);
            if value > limit {
                let column = format!("{signal}{}", joint + 1);
                warnings.push(UnitWarning { column, value, limit, units });
            }
        }
    }
    warnings
}

fn largest(values: MatRef<'_, f64>, joint: usize) -> f64 {
    (0..values.nrows()).map(|row| values[(row, joint)].abs()).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::unit_warnings;
    use faer::Mat;
    use torquewise_motion::{Motion, Signals};

    fn motion(step: f64, amplitude: f64) -> Motion {
        let x = Mat::from_fn(20, 2, |row, joint| joint as f64 * amplitude * (row as f64).sin());
        Motion::new(Signals {
            joints: vec!["hip".into(), "knee".into()],
            t: (0..20).map(|row| step * f64::from(row)).collect(),
            dq: x.clone(),
            ddq: x.clone(),
            tau: None,
            q: x,
        })
        .unwrap()
    }

    #[test]
    fn degrees_and_milliseconds_are_suspected() {
        let warnings = unit_warnings(&motion(1.0, 80.0));

        let columns: Vec<_> = warnings.iter().map(|warning| warning.column.as_str()).collect();
        assert_eq!(columns, ["t", "q2"]);
        assert!(warnings[1].to_string().contains("is it in degrees?"));
    }

    #[test]
    fn si_units_raise_no_warning() {
        assert_eq!(unit_warnings(&motion(0.002, 3.0)), []);
    }
}
