//! TOML → Friction: the Stribeck curve (17) of each joint, forward and backward.

use crate::error::DynamicsError;
use serde::Deserialize;
use std::collections::BTreeMap;

/// f(v) = \[f_c + (f_s − f_c) exp(−(v/v_s)²)\] sign(v) + f_v v, method.md (17), for one direction.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stribeck {
    /// f_c \[N·m\], 0 or more: dry friction of fast motion.
    pub coulomb: f64,
    /// f_s \[N·m\], at least `coulomb`: dry friction of motion that is about to stop.
    pub stiction: f64,
    /// v_s \[rad/s\], above 0: where the one turns into the other.
    pub speed: f64,
    /// f_v \[N·m·s/rad\], 0 or more.
    #[serde(default)]
    pub viscous: f64,
}

impl Stribeck {
    /// No friction.
    pub const NONE: Self = Self { coulomb: 0.0, stiction: 0.0, speed: 1.0, viscous: 0.0 };

    /// f at a speed |v| \[rad/s\] above zero \[N·m\].
    pub fn at(&self, speed: f64) -> f64 {
        let slow = (-(speed / self.speed).powi(2)).exp();
        self.coulomb + (self.stiction - self.coulomb) * slow + self.viscous * speed
    }
}

/// Friction of every joint of an arm.
///
/// The sign is smooth, tanh(v/`width`), so that the motion has one solution and an integrator with
/// error control finds it. An arm that sticks then creeps: under a load of a share s of the
/// breakaway torque at atanh(s)·`width`, 0.55 mrad/s at half of it by default.
#[derive(Clone, Debug, PartialEq)]
pub struct Friction {
    joints: Vec<[Stribeck; 2]>,
    width: f64,
}

/// Half width of the reversal \[rad/s\] where none is given.
const WIDTH: f64 = 1e-3;

/// Friction as its file says it.
#[derive(Deserialize)]
struct Table {
    #[serde(default = "default_width")]
    width: f64,
    #[serde(flatten)]
    joints: BTreeMap<String, Row>,
}

fn default_width() -> f64 {
    WIDTH
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Row {
    coulomb: f64,
    stiction: Option<f64>,
    speed: Option<f64>,
    #[serde(default)]
    viscous: f64,
    backward: Option<Stribeck>,
}

impl Row {
    fn directions(self) -> [Stribeck; 2] {
        let Self { coulomb, viscous, .. } = self;
        let stiction = self.stiction.unwrap_or(coulomb);
        let speed = self.speed.unwrap_or(Stribeck::NONE.speed);
        let forward = Stribeck { coulomb, stiction, speed, viscous };
        [forward, self.backward.unwrap_or(forward)]
    }
}

impl Friction {
    /// None on n joints.
    pub fn none(n_joints: usize) -> Self {
        Self { joints: vec![[Stribeck::NONE; 2]; n_joints], width: WIDTH }
    }

    /// The same curve in both directions, one per joint.
    ///
    /// # Errors
    /// [`DynamicsError::Friction`] for a number out of bounds.
    pub fn new(joints: &[Stribeck]) -> Result<Self, DynamicsError> {
        Self::checked(joints.iter().map(|&both| [both; 2]).collect(), WIDTH)
    }

    /// Reads friction from TOML: a table for each joint that rubs, under its name.
    ///
    /// Each holds `coulomb` \[N·m\], and optionally `stiction` \[N·m\], `speed` \[rad/s\],
    /// `viscous` \[N·m·s/rad\] and `backward`, a whole curve of its own for the other direction.
    /// Above the tables, `width` \[rad/s\] may say how sharply friction reverses.
    ///
    /// ```
    /// use torquewise_dynamics::{Arm, friction::Friction};
    ///
    /// let arm = Arm::builtin("puma560-3")?;
    /// let text = "[joint2]\ncoulomb = 4.0\nstiction = 6.0\nspeed = 0.1\nviscous = 2.0";
    /// let friction = Friction::from_toml(text, arm.joints())?;
    /// assert!((friction.torque(1, -1.0) + 6.0).abs() < 1e-9);
    /// assert_eq!(friction.torque(0, -1.0), 0.0);
    /// # Ok::<(), torquewise_dynamics::DynamicsError>(())
    /// ```
    ///
    /// # Errors
    /// [`DynamicsError::FrictionTable`] for broken TOML; [`DynamicsError::FrictionJoint`] for a
    /// joint the arm does not have; [`DynamicsError::Friction`] for a number out of bounds.
    pub fn from_toml(text: &str, joints: &[String]) -> Result<Self, DynamicsError> {
        let mut table: Table = toml::from_str(text)
            .map_err(|source| DynamicsError::FrictionTable { source: Box::new(source) })?;
        let curves = joints
            .iter()
            .map(|name| table.joints.remove(name).map_or([Stribeck::NONE; 2], Row::directions))
            .collect();
        match table.joints.pop_first() {
            Some((joint, _)) => {
                Err(DynamicsError::FrictionJoint { joint, known: joints.join(", ") })
            }
            None => Self::checked(curves, table.width),
        }
    }

    fn checked(joints: Vec<[Stribeck; 2]>, width: f64) -> Result<Self, DynamicsError> {
        let above = |what, joint: usize, found: f64, least: f64, expected| {
            if found.is_finite() && found >= least {
                Ok(())
            } else {
                Err(DynamicsError::Friction { what, joint: joint + 1, found, expected })
            }
        };
        for (joint, curve) in joints.iter().enumerate().flat_map(|(j, c)| c.map(|c| (j, c))) {
            above("coulomb", joint, curve.coulomb, 0.0, "0 N·m or more")?;
            above("stiction", joint, curve.stiction, curve.coulomb, "coulomb or more")?;
            above("speed", joint, curve.speed, f64::MIN_POSITIVE, "above 0 rad/s")?;
            above("viscous", joint, curve.viscous, 0.0, "0 N·m·s/rad or more")?;
        }
        above("width", 0, width, 1e-5, "1e-5 rad/s or more")?;
        Ok(Self { joints, width })
    }

    /// Number of joints n.
    pub fn n_joints(&self) -> usize {
        self.joints.len()
    }

    /// Half width \[rad/s\] of the reversal: from 4 times it on the sign is ±1 to 0.1 %.
    pub fn width(&self) -> f64 {
        self.width
    }

    /// Friction of a joint, counted from 0, at v \[rad/s\]: what the drive has to add \[N·m\].
    ///
    /// # Panics
    /// If there is no such joint.
    pub fn torque(&self, joint: usize, v: f64) -> f64 {
        let [forward, backward] = &self.joints[joint];
        let curve = if v < 0.0 { backward } else { forward };
        let viscous = curve.viscous * v;
        (curve.at(v.abs()) - viscous.abs()) * (v / self.width).tanh() + viscous
    }

    /// [`Friction::torque`] of all joints at dq \[rad/s\], n.
    ///
    /// # Panics
    /// If `dq` does not hold n numbers.
    pub fn torques(&self, dq: &[f64]) -> Vec<f64> {
        let (found, expected) = (dq.len(), self.n_joints());
        assert!(found == expected, "dq holds {found} numbers, expected {expected}");
        dq.iter().enumerate().map(|(joint, &v)| self.torque(joint, v)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CURVE: Stribeck = Stribeck { coulomb: 4.0, stiction: 6.0, speed: 0.1, viscous: 2.0 };

    fn joints() -> Vec<String> {
        vec!["a".into(), "b".into()]
    }

    #[test]
    fn the_curve_has_its_values_at_both_ends() {
        let friction = Friction::new(&[CURVE]).unwrap();

        // 20 Stribeck speeds on the exponential is gone; at 5 widths tanh is 1 to 1e-4.
        assert!((friction.torque(0, 2.0) - 8.0).abs() < 1e-12);
        assert!((friction.torque(0, -2.0) + 8.0).abs() < 1e-12);
        assert!((friction.torque(0, 5e-3) - 6.0).abs() < 0.01);
        assert!(friction.torque(0, 0.0).abs() < f64::MIN_POSITIVE);
    }

    #[test]
    fn backward_motion_may_rub_otherwise() {
        let text = "[b]\ncoulomb = 1.0\n[b.backward]\ncoulomb = 2.0\nstiction = 2.0\nspeed = 1.0";

        let friction = Friction::from_toml(text, &joints()).unwrap();

        assert_eq!(friction.torques(&[3.0, 3.0]), [0.0, 1.0]);
        assert_eq!(friction.torques(&[3.0, -3.0]), [0.0, -2.0]);
    }

    #[test]
    fn friction_that_cannot_be_is_refused() {
        let texts = [
            "[b]\ncoulomb = -1.0",
            "[b]\ncoulomb = 2.0\nstiction = 1.0",
            "[b]\ncoulomb = 2.0\nspeed = 0.0",
            "[b]\ncoulomb = nan",
            "[b]\ncoulomb = 1.0\nviscous = inf",
            "width = 0.0\n[b]\ncoulomb = 1.0",
        ];

        for text in texts {
            let error = Friction::from_toml(text, &joints()).unwrap_err();
            assert!(matches!(error, DynamicsError::Friction { .. }), "{text}: {error}");
        }
    }

    #[test]
    fn a_joint_or_key_that_does_not_exist_is_refused() {
        let joint = Friction::from_toml("[c]\ncoulomb = 1.0", &joints()).unwrap_err();
        let key = Friction::from_toml("[b]\ncolumb = 1.0", &joints()).unwrap_err();

        assert!(joint.to_string().contains("`c`") && joint.to_string().contains("a, b"));
        assert!(matches!(key, DynamicsError::FrictionTable { .. }));
    }
}
