//! The Stribeck curve (17) of each joint, forward and backward, and bristles.

use crate::{Result, SimError, check_between};
use serde::Deserialize;
use std::collections::BTreeMap;

/// f(v) = \[f_c + (f_s − f_c) exp(−(v/v_s)²)\] sign(v) + f_v v, method.md (17), for one direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stribeck {
    /// f_c \[N·m\], 0 or more: dry friction of fast motion.
    pub coulomb: f64,
    /// f_s \[N·m\], at least `coulomb`: dry friction of motion that is about to stop.
    pub stiction: f64,
    /// v_s \[rad/s\], above 0: where the one turns into the other.
    pub speed: f64,
    /// f_v \[N·m·s/rad\], 0 or more.
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

/// Bristles of the model of LuGre: dry friction that bends before it slips, so that it turns over
/// along a way and stays at rest.
///
/// dz = v − σ₀|v|/g(v)·z, f = σ₀ z + σ₁ dz + f_v v, where g is the curve of dry friction.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Bristles {
    /// σ₀ \[N·m/rad\], above 0.
    stiffness: f64,
    /// σ₁ \[N·m·s/rad\], 0 or more.
    damping: f64,
}

/// Bristles that slip before they are bent so far \[rad\] are none.
const LEAST_BEND: f64 = 1e-5;
/// Steps of a bristle between two samples.
const STEPS: u32 = 10;

/// Friction of every joint of an arm, counted from 0; a joint that is not there panics.
///
/// The sign is smooth, tanh(v/`width`), so that the motion has one solution and an integrator with
/// error control finds it. An arm that sticks then creeps: under a load of a share s of the
/// breakaway torque at atanh(s)·`width`, 0.55 mrad/s at half of it by default.
#[derive(Clone, Debug, PartialEq)]
pub struct Friction {
    joints: Vec<[Stribeck; 2]>,
    bristles: Vec<Option<Bristles>>,
    /// Half width \[rad/s\] of the reversal: from 4 times it on the sign is ±1 to 0.1 %.
    pub width: f64,
}

/// How far the bristles of each joint are bent \[rad\], and how fast the joints last moved
/// \[rad/s\].
#[derive(Clone, Debug, Default)]
pub struct Bent {
    deflection: Vec<f64>,
    dq: Vec<f64>,
}

/// Half width of the reversal \[rad/s\] where none is given.
const WIDTH: f64 = 1e-3;

#[derive(Deserialize)]
struct Table {
    width: Option<f64>,
    #[serde(flatten)]
    joints: BTreeMap<String, Row>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Row {
    coulomb: f64,
    stiction: Option<f64>,
    speed: Option<f64>,
    #[serde(default)]
    viscous: f64,
    stiffness: Option<f64>,
    #[serde(default)]
    damping: f64,
    backward: Option<Backward>,
}

/// What is not said is as forward.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Backward {
    coulomb: Option<f64>,
    stiction: Option<f64>,
    speed: Option<f64>,
    viscous: Option<f64>,
}

impl Backward {
    /// - `stiction`: forward, where it was given
    fn beside(&self, forward: Stribeck, stiction: Option<f64>) -> Stribeck {
        let coulomb = self.coulomb.unwrap_or(forward.coulomb);
        Stribeck {
            coulomb,
            stiction: self.stiction.or(stiction).unwrap_or(coulomb),
            speed: self.speed.unwrap_or(forward.speed),
            viscous: self.viscous.unwrap_or(forward.viscous),
        }
    }
}

impl Friction {
    /// None on n joints.
    pub fn none(n_joints: usize) -> Self {
        let (joints, bristles) = (vec![[Stribeck::NONE; 2]; n_joints], vec![None; n_joints]);
        Self { joints, bristles, width: WIDTH }
    }

    /// The same curve in both directions, one per joint.
    ///
    /// # Errors
    /// [`SimError::Setting`] for a number out of bounds.
    pub fn new(joints: &[Stribeck]) -> Result<Self> {
        let bristles = vec![None; joints.len()];
        Self::checked(joints.iter().map(|&both| [both; 2]).collect(), bristles, WIDTH)
    }

    /// Reads friction from TOML: a table for each joint that rubs, under its name.
    ///
    /// Each holds `coulomb` \[N·m\], and optionally `stiction` \[N·m\], `speed` \[rad/s\], 1 by default,
    /// `viscous` \[N·m·s/rad\] and `backward`, a table of what is another in the other direction.
    /// `stiffness` \[N·m/rad\] and `damping` \[N·m·s/rad\] make dry friction that of LuGre, which
    /// turns over along a way.
    /// Above the tables, `width` \[rad/s\] may say how sharply friction reverses.
    ///
    /// ```
    /// use torquewise_sim::{Arm, friction::Friction};
    ///
    /// let arm = Arm::builtin("puma560-3")?;
    /// let text = "[joint2]\ncoulomb = 4.0\nstiction = 6.0\nspeed = 0.1\nviscous = 2.0";
    /// let friction = Friction::from_toml(text, arm.joints())?;
    /// assert!((friction.torque(1, -1.0) + 6.0).abs() < 1e-9);
    /// assert_eq!(friction.torque(0, -1.0), 0.0);
    /// # Ok::<(), torquewise_sim::SimError>(())
    /// ```
    ///
    /// # Errors
    /// [`SimError::FrictionTable`] for broken TOML; [`SimError::UnknownJoint`] for a
    /// joint the arm does not have; [`SimError::Setting`] for a number out of bounds.
    pub fn from_toml(text: &str, joints: &[String]) -> Result<Self> {
        let mut table: Table = toml::from_str(text)
            .map_err(|source| SimError::FrictionTable { source: Box::new(source) })?;
        let stray = |(_, row): &(&String, &Row)| row.damping != 0.0 && row.stiffness.is_none();
        if let Some((joint, row)) = table.joints.iter().find(stray) {
            let what = format!("damping of joint `{joint}`");
            let expected = "none where no stiffness of bristles is given";
            return Err(SimError::Setting { what, found: row.damping, expected });
        }
        let laws = |name| {
            let Some(row) = table.joints.remove(name) else { return ([Stribeck::NONE; 2], None) };
            let Row { coulomb, viscous, damping, .. } = row;
            let stiction = row.stiction.unwrap_or(coulomb);
            let speed = row.speed.unwrap_or(Stribeck::NONE.speed);
            let forward = Stribeck { coulomb, stiction, speed, viscous };
            let bristles = row.stiffness.map(|stiffness| Bristles { stiffness, damping });
            let backward = row.backward.map_or(forward, |own| own.beside(forward, row.stiction));
            ([forward, backward], bristles)
        };
        let (curves, bristles) = joints.iter().map(laws).unzip();
        if let Some((joint, _)) = table.joints.pop_first() {
            let (what, known) = ("friction", joints.join(", "));
            return Err(SimError::UnknownJoint { what, joint, known });
        }
        Self::checked(curves, bristles, table.width.unwrap_or(WIDTH))
    }

    fn checked(
        joints: Vec<[Stribeck; 2]>,
        bristles: Vec<Option<Bristles>>,
        width: f64,
    ) -> Result<Self> {
        let above = |what: &str, joint: usize, found: f64, least: f64, expected| {
            let what = format!("{what} of joint `{}`", joint + 1);
            check_between(what, found, [least, f64::MAX], expected)
        };
        for (joint, curve) in joints.iter().enumerate().flat_map(|(j, c)| c.map(|c| (j, c))) {
            above("coulomb", joint, curve.coulomb, 0.0, "0 N·m or more")?;
            above("stiction", joint, curve.stiction, curve.coulomb, "coulomb or more")?;
            above("speed", joint, curve.speed, f64::MIN_POSITIVE, "above 0 rad/s")?;
            above("viscous", joint, curve.viscous, 0.0, "0 N·m·s/rad or more")?;
        }
        for (joint, own) in bristles.iter().enumerate() {
            let Some(Bristles { stiffness, damping }) = *own else { continue };
            above("stiffness", joint, stiffness, f64::MIN_POSITIVE, "above 0 N·m/rad")?;
            for curve in joints[joint] {
                let least = LEAST_BEND * stiffness;
                above("coulomb", joint, curve.coulomb, least, "1e-5 of the stiffness or more")?;
            }
            above("damping", joint, damping, 0.0, "0 N·m·s/rad or more")?;
        }
        above("width", 0, width, 1e-5, "1e-5 rad/s or more")?;
        Ok(Self { joints, bristles, width })
    }

    /// Number of joints n.
    pub fn n_joints(&self) -> usize {
        self.joints.len()
    }

    /// Friction of a joint, counted from 0, at v \[rad/s\]: what the drive has to add \[N·m\], once
    /// bristles slip.
    pub fn torque(&self, joint: usize, v: f64) -> f64 {
        self.dry(joint, v) * (v / self.width).tanh() + self.viscous(joint, v)
    }

    /// Friction of a joint at the next sample of a motion, `seconds` after the one before, at v
    /// \[rad/s\]; that of [`Friction::torque`] where the joint has no bristles.
    ///
    /// - `bent`: what the samples before have left; of a motion that begins, the default
    pub fn next(&self, joint: usize, v: f64, seconds: f64, bent: &mut Bent) -> f64 {
        let Some(Bristles { stiffness, .. }) = self.bristles[joint] else {
            return self.torque(joint, v);
        };
        let n = self.n_joints();
        bent.deflection.resize(n, 0.0);
        bent.dq.resize(n, f64::NAN);
        let before = if bent.dq[joint].is_nan() { v } else { bent.dq[joint] };
        let z = &mut bent.deflection[joint];
        for step in 1..=STEPS {
            let part = (f64::from(step) - 0.5) / f64::from(STEPS);
            let speed = before + part * (v - before);
            let way = speed * seconds / f64::from(STEPS);
            let dry = self.dry(joint, speed).max(f64::MIN_POSITIVE);
            // The way is short: exact for one speed.
            let end = dry / stiffness * way.signum();
            let bend = (end - *z) * -(-way.abs() * stiffness / dry).exp_m1();
            *z += if way == 0.0 { 0.0 } else { bend };
        }
        bent.dq[joint] = v;
        let [torque, _] = self.bent(joint, v, *z);
        torque
    }

    /// Whether any joint has bristles.
    pub fn has_bristles(&self) -> bool {
        self.bristles.iter().any(Option::is_some)
    }

    /// Friction of a joint at v \[rad/s\] whose bristles are bent by z \[rad\], and how fast they
    /// bend \[rad/s\]; that of [`Friction::torque`] and 0 where the joint has none.
    pub fn bent(&self, joint: usize, v: f64, z: f64) -> [f64; 2] {
        let Some(Bristles { stiffness, damping }) = self.bristles[joint] else {
            return [self.torque(joint, v), 0.0];
        };
        let slope = v - stiffness * v.abs() / self.dry(joint, v).max(f64::MIN_POSITIVE) * z;
        [stiffness * z + damping * slope + self.viscous(joint, v), slope]
    }

    /// Dry friction of fast or slow sliding \[N·m\], 0 or more.
    fn dry(&self, joint: usize, v: f64) -> f64 {
        let curve = &self.joints[joint][usize::from(v < 0.0)];
        curve.at(v.abs()) - curve.viscous * v.abs()
    }

    fn viscous(&self, joint: usize, v: f64) -> f64 {
        self.joints[joint][usize::from(v < 0.0)].viscous * v
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
    fn the_curve_has_its_values_at_both_ends_and_may_be_another_backward() {
        let friction = Friction::new(&[CURVE]).unwrap();

        // 20 Stribeck speeds on the exponential is gone; at 5 widths tanh is 1 to 1e-4.
        assert!((friction.torque(0, 2.0) - 8.0).abs() < 1e-12);
        assert!((friction.torque(0, -2.0) + 8.0).abs() < 1e-12);
        assert!((friction.torque(0, 5e-3) - 6.0).abs() < 0.01);
        assert!(friction.torque(0, 0.0).abs() < f64::MIN_POSITIVE);
        let whole = "[b]\ncoulomb = 1.0\n[b.backward]\ncoulomb = 2.0\nstiction = 2.0\nspeed = 1.0";
        let less = "[b]\ncoulomb = 2.0\n[b.backward]\ncoulomb = 1.0";
        for (text, v, [forward, backward]) in [(whole, 3.0, [1.0, -2.0]), (less, 0.5, [2.0, -1.0])]
        {
            let both = Friction::from_toml(text, &joints()).unwrap();

            assert_eq!(both.torques(&[3.0, v]), [0.0, forward]);
            assert_eq!(both.torques(&[3.0, -v]), [0.0, backward]);
        }
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
            "[b]\ncoulomb = 1.0\nstiffness = 0.0",
            "[b]\ncoulomb = 1.0\ndamping = 2.0",
            "[b]\ncoulomb = 0.0\nstiffness = 400.0",
            "[b]\ncoulomb = 1.0\nstiffness = 10.0\ndamping = -1.0",
        ];

        for text in texts {
            let error = Friction::from_toml(text, &joints()).unwrap_err();
            assert!(matches!(error, SimError::Setting { .. }), "{text}: {error}");
        }
        let key = Friction::from_toml("[b]\ncolumb = 1.0", &joints());
        assert!(matches!(key, Err(SimError::FrictionTable { .. })));
    }

    #[test]
    fn bristles_turn_over_along_a_way_and_stay_bent_at_rest() {
        let text = "[a]\ncoulomb = 4.0\nstiffness = 400.0";
        let friction = Friction::from_toml(text, &joints()).unwrap();
        let mut bent = Bent::default();
        let mut moved =
            |v: f64, rows: usize| (0..rows).fold(0.0, |_, _| friction.next(0, v, 0.001, &mut bent));

        // 0.01 rad = g/σ₀ from rest: 1 − 1/e of it.
        assert!((moved(0.1, 100) - 4.0 * (1.0 - (-1.0_f64).exp())).abs() < 1e-9);
        assert!((moved(0.1, 2_000) - 4.0).abs() < 1e-6);
        assert!((moved(0.0, 500) - 4.0).abs() < 0.02, "at rest");
        assert!((moved(-0.1, 2_000) + 4.0).abs() < 1e-6);
    }
}
