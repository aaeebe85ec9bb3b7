//! What each joint may do, and what the plan keeps to.

use crate::{Arm, Result, SimError, check_between};
use std::f64::consts::PI;
use torquewise_rigid::JointKind;

/// What a joint may do at most.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Bounds {
    /// Lower and upper position \[rad\].
    pub position: [f64; 2],
    /// Speed \[rad/s\].
    pub velocity: f64,
    /// Acceleration \[rad/s²\].
    pub acceleration: f64,
}

impl Bounds {
    /// The same at a share of the speed.
    pub(crate) fn slowed(&self, speed: f64) -> Self {
        let acceleration = speed * speed * self.acceleration;
        Self { velocity: speed * self.velocity, acceleration, ..*self }
    }
}

/// The limits of one joint.
#[derive(Clone, Debug, PartialEq)]
pub struct Limits {
    /// Name of the joint.
    pub joint: String,
    /// Whether it turns or slides.
    pub kind: JointKind,
    /// What the arm can do.
    pub arm: Bounds,
    /// What the plan keeps to.
    pub planned: Bounds,
    /// Which limits of the arm nobody gave, so that they are assumed.
    pub assumed: Vec<&'static str>,
}

/// A value for all joints, one for each, or some for joints by name.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct JointValues<T>(pub Vec<(Option<String>, T)>);

/// What the user says about limits; where he says nothing, those of the arm hold.
#[derive(Clone, Debug, PartialEq)]
pub struct Wishes {
    /// Positions \[rad\] to keep to, within the limits of the arm.
    pub range: JointValues<[f64; 2]>,
    /// Limit of the speed \[rad/s\], in place of the arm's.
    pub velocity: JointValues<f64>,
    /// Acceleration \[rad/s²\] to keep to.
    pub acceleration: JointValues<f64>,
    /// Speeds of the plan as a share of the limits.
    pub speed_scale: f64,
    /// Distance from each limit of the position, as a share of the way between them.
    pub margin: f64,
}

impl Default for Wishes {
    fn default() -> Self {
        Self {
            range: JointValues::default(),
            velocity: JointValues::default(),
            acceleration: JointValues::default(),
            speed_scale: 0.5,
            margin: 0.05,
        }
    }
}

/// Limit of the speed \[rad/s\] of a joint about which nothing is known.
pub const ASSUMED_VELOCITY: f64 = 2.0;
/// The same of a slide \[m/s\]: the reduced speed of ISO 10218-1.
const ASSUMED_SLIDE: f64 = 0.25;
/// Time \[s\] in which the planned speed is reached where no acceleration is given.
pub const SECONDS_TO_SPEED: f64 = 0.5;
/// Limits from here to there are those of an arm; others are a mistake, or would overflow.
const SENSIBLE: [f64; 2] = [1e-4, 1e4];

impl<T: Copy> JointValues<T> {
    pub(crate) fn resolve(&self, what: &'static str, joints: &[String]) -> Result<Vec<Option<T>>> {
        let (n, found) = (joints.len(), self.0.len());
        if found > 0 && self.0.iter().all(|(name, _)| name.is_none()) {
            return match found {
                1 => Ok(vec![Some(self.0[0].1); n]),
                _ if found == n => Ok(self.0.iter().map(|(_, value)| Some(*value)).collect()),
                _ => Err(SimError::Count { what, found, joints: n }),
            };
        }
        let mut values = vec![None; n];
        for (name, value) in &self.0 {
            let Some(joint) = name.clone() else { return Err(SimError::Mixed { what }) };
            let Some(place) = joints.iter().position(|own| *own == joint) else {
                return Err(SimError::UnknownJoint { what, joint, known: joints.join(", ") });
            };
            values[place] = Some(*value);
        }
        Ok(values)
    }
}

/// The limits of each joint of an arm, n.
///
/// The plan keeps `margin` off each limit of the position and moves a joint without such limits
/// within one turn; it uses `speed_scale` of the speed and of the acceleration of a URDF 1.2.
/// Without an acceleration, the planned speed is reached in half a second.
///
/// # Errors
/// [`SimError`], naming the joint and the number at fault.
pub fn limits(arm: &Arm, wishes: &Wishes) -> Result<Vec<Limits>> {
    let joints = arm.joints();
    check_between("speed scale", wishes.speed_scale, [0.01, 1.0], "from 0.01 to 1")?;
    check_between("margin", wishes.margin, [0.0, 0.45], "from 0 to 0.45")?;
    let ranges = wishes.range.resolve("a range", joints)?;
    let velocities = wishes.velocity.resolve("a velocity", joints)?;
    let accelerations = wishes.acceleration.resolve("an acceleration", joints)?;
    let turns = arm.ranges();
    let mut all = Vec::with_capacity(joints.len());
    for (i, (joint, known)) in joints.iter().zip(arm.limits()).enumerate() {
        let (kind, mut assumed) = (arm.kinds().of(i), Vec::new());
        let limit = velocities[i].or(known.velocity).unwrap_or_else(|| {
            assumed.push("velocity");
            if kind.turns() { ASSUMED_VELOCITY } else { ASSUMED_SLIDE }
        });
        check_rate("velocity", joint, limit)?;
        let velocity = wishes.speed_scale * limit;
        let scaled = known.acceleration.map(|limit| wishes.speed_scale * limit);
        let acceleration = accelerations[i].or(scaled).unwrap_or_else(|| {
            assumed.push("acceleration");
            velocity / SECONDS_TO_SPEED
        });
        check_rate("acceleration", joint, acceleration)?;
        if known.position.is_none() && ranges[i].is_none() {
            assumed.push("position");
        }
        let inner = known.position.map(|[lower, upper]| {
            let distance = wishes.margin * (upper - lower);
            [lower + distance, upper - distance]
        });
        // As asked, within the limits less their margin, at most one turn unless asked otherwise.
        let [lower, upper] = match (ranges[i], inner) {
            (Some([a, b]), Some([lower, upper])) => [a.max(lower), b.min(upper)],
            (Some(range), None) => range,
            (None, Some([lower, upper])) => [lower.max(turns[i][0]), upper.min(turns[i][1])],
            (None, None) => turns[i],
        };
        let asked_well = ranges[i].is_none_or(|[a, b]| a < b);
        let [least, most] = SENSIBLE;
        if !(asked_well && upper - lower >= least && lower.abs().max(upper.abs()) <= most) {
            let [lower, upper] = ranges[i].unwrap_or([lower, upper]);
            return Err(SimError::Range { joint: joint.clone(), lower, upper });
        }
        all.push(Limits {
            kind,
            joint: joint.clone(),
            arm: Bounds {
                position: known.position.unwrap_or(ranges[i].unwrap_or([-PI, PI])),
                velocity: limit,
                acceleration: accelerations[i].or(known.acceleration).unwrap_or(acceleration),
            },
            planned: Bounds { position: [lower, upper], velocity, acceleration },
            assumed,
        });
    }
    Ok(all)
}

pub(crate) fn check_rate(what: &str, joint: &str, found: f64) -> Result<()> {
    check_between(format!("{what} of joint `{joint}`"), found, SENSIBLE, "from 0.0001 to 10000")
}

#[cfg(test)]
mod tests;
