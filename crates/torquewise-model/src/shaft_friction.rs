//! Friction in engineering values: Coulomb, static, Stribeck speed, viscous, stiffness.

use crate::{FrictionLaw, FrictionTerm, LEAST_T, Model};
use serde::Serialize;

/// A number with its standard error, both in one unit; the error is 0 where it is not known.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Estimated {
    /// The number.
    pub value: f64,
    /// Its standard error.
    pub std_error: f64,
}

/// Friction of a shaft that slides one way, without load; `None` where it is not resolved.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Sliding {
    /// F_c \[N·m\]: dry friction of fast motion, where the exponentials of Stribeck are gone.
    pub coulomb: Option<Estimated>,
    /// F_s \[N·m\]: dry friction of motion that is about to stop, v → 0; only where it is told from
    /// F_c. It is below F_c where friction rises steeply from rest, as of some lubricated gears.
    pub stiction: Option<Estimated>,
    /// v_s \[rad/s\]: where what dry friction differs from F_c by has fallen to 1/e of F_s − F_c.
    pub stribeck_speed: Option<Estimated>,
    /// F_v \[N·m·s/rad\].
    pub viscous: Option<Estimated>,
}

/// Friction of a shaft as engineers read it; `None` where it is not resolved.
///
/// No number within two standard errors of zero is resolved, nor one below zero but for the offset;
/// nor a Stribeck curve that reversal or the filter makes. Where the model keeps a covariance of its
/// parameters, errors are of the whole of it (delta method); else coefficients are independent.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FrictionParameters {
    /// Constant torque of the drive \[N·m\].
    pub offset: Option<Estimated>,
    /// v > 0.
    pub forward: Sliding,
    /// v < 0; torques are counted against the motion.
    pub backward: Sliding,
    /// Σ cₖ over δ \[N·m/rad\] of Dahl elements without load, where Σ cₖ e^(−δ/δₖ) = Σ cₖ/e: dF/dq
    /// from the middle of the loop, as σ₀ of LuGre; after a full turn it begins at twice that. Two
    /// elements that stand for one between them give nearly its δ, but are steeper at first.
    pub stiffness: Option<Estimated>,
    /// Way \[rad\] after a reversal at which 90 % of the turn of the Dahl elements is done, from
    /// −Σ cₖ to Σ cₖ: Σ cₖ e^(−way/δₖ) = 0.1 Σ cₖ.
    pub travel: Option<Estimated>,
    /// Dry friction per N·m that gravity loads the gear with \[1\], mean of both directions.
    pub load_factor: Option<Estimated>,
}

/// The friction of one shaft of a model: of a joint, or of several that turn it.
#[derive(Clone, Copy, Debug)]
pub struct ShaftFriction<'m> {
    model: &'m Model,
    shaft: &'m [f64],
}

/// A curve that bends below so many half widths of the reversal of friction is not resolved: slower
/// rows hardly count in a fit, and those of an arm that noise keeps moving bend it too (puma560-3 with
/// dwells: v_s .06 in place of .1, F_s 9.6 in place of 7, at 4 half widths).
const SEEN: f64 = 5.0;
/// A fit takes no friction for none: a load factor up to this is what it leaves where none is.
const LEAST_LOAD: f64 = 2e-3;
/// What is left of the turn of a reversal after its travel.
const LEFT: f64 = 0.1;
/// Even steps in which a decay is looked for, and halvings of the step that it is in.
const STEPS: u32 = 1_000;
const HALVINGS: u32 = 50;

/// Speeds of a line, even steps up to the peak, and those that are too slow for it.
const SPEEDS: u32 = 50;
const SLOW_SPEEDS: u32 = 5;

impl<'m> ShaftFriction<'m> {
    /// All shafts with friction: those of single joints in their order, then shared ones.
    pub fn all(model: &'m Model) -> Vec<Self> {
        let mut all: Vec<Self> = Vec::new();
        for shaft in model.friction.iter().map(|weighted| &weighted.term.shaft) {
            if all.iter().all(|own| own.shaft != shaft) {
                all.push(Self { model, shaft });
            }
        }
        all.sort_by_key(|own| own.joint().unwrap_or(usize::MAX));
        all
    }

    /// Its speed per speed of each joint, n.
    pub fn shaft(&self) -> &'m [f64] {
        self.shaft
    }

    /// Its laws with their places in [`Model::friction`].
    pub fn laws(&self) -> impl Iterator<Item = (usize, &'m FrictionTerm)> + '_ {
        let laws = self.model.friction.iter().map(|weighted| &weighted.term).enumerate();
        laws.filter(|(_, term)| term.shaft == self.shaft)
    }

    /// The joint that it is the own shaft of, counted from 0.
    pub fn joint(&self) -> Option<usize> {
        let mut turning = self.shaft.iter().enumerate().filter(|(_, part)| **part != 0.0);
        let (joint, part) = turning.next()?;
        (turning.next().is_none() && part.to_bits() == 1.0_f64.to_bits()).then_some(joint)
    }

    /// Name of the joint, or the angle of a shared shaft: `q5 + q6`, joints counted from 1.
    pub fn name(&self) -> String {
        let joint = self.joint().and_then(|joint| self.model.joints.get(joint));
        let angle = || self.laws().next().map_or_else(String::new, |(_, term)| term.sum("q", "*"));
        joint.cloned().unwrap_or_else(angle)
    }

    /// What equations call it: `F2(dq2)`, `F2(q2, dq2)` where it remembers the path, `F2(q, dq2)`
    /// where it feels the load; none where its laws are linear and alike in both directions.
    pub fn symbol(&self) -> Option<String> {
        let laws = || self.laws().map(|(_, term)| term);
        let bends = |law| matches!(law, FrictionLaw::Stribeck { .. } | FrictionLaw::Dahl { .. });
        let first = laws().find(|t| bends(t.law) || t.load || !t.direction.is_both())?;
        let remembers = laws().any(|term| term.element().is_some());
        let place = match (laws().any(|term| term.load), remembers) {
            (true, _) => "q, ".to_owned(),
            (false, true) => first.sum("q", "*") + ", ",
            (false, false) => String::new(),
        };
        let turning = (1..).zip(self.shaft).filter(|(_, part)| **part != 0.0);
        let joints: String = turning.map(|(joint, _)| joint.to_string()).collect();
        Some(format!("F{joints}({place}{})", first.sum("dq", "*")))
    }

    /// Its parameters under their usual names.
    pub fn parameters(&self) -> FrictionParameters {
        let plain = |term: &FrictionTerm| !term.load;
        let offset = self.sum(|term| one(plain(term) && term.law == FrictionLaw::Offset));
        let element = |term: &FrictionTerm| match term.law {
            FrictionLaw::Dahl { travel } if plain(term) => Some(travel),
            _ => None,
        };
        let load_factor = self.sum(|term| {
            let ways = [1.0, -1.0].map(|way| one(term.direction.holds(way)));
            one(term.load && is_coulomb(term)) * 0.5 * (ways[0] + ways[1])
        });
        let turned = self.sum(|term| one(element(term).is_some())).positive();
        // The sum of c over the x at which Σ c e^(−x/travel) has fallen to 1/e.
        let stiffness = turned.and_then(|Estimated { value: sum, .. }| {
            let (x, change) = self.decayed(&element, (-1.0_f64).exp(), 1)?;
            let weight =
                |term: &FrictionTerm| (one(element(term).is_some()) - sum / x * change(term)) / x;
            Estimated { value: sum / x, std_error: self.std_error(weight) }.positive()
        });
        FrictionParameters {
            offset: offset.resolved(),
            forward: self.sliding(1.0),
            backward: self.sliding(-1.0),
            stiffness,
            travel: turned.and_then(|_| self.decay(element, LEFT, 1)),
            load_factor: load_factor.positive().filter(|own| own.value > LEAST_LOAD),
        }
    }

    fn sliding(&self, way: f64) -> Sliding {
        let acts = |term: &FrictionTerm| !term.load && term.direction.holds(way);
        let exponential = |term: &FrictionTerm| match term.law {
            FrictionLaw::Stribeck { speed, .. } if acts(term) => Some(speed),
            _ => None,
        };
        let is_dry = |term: &FrictionTerm| is_coulomb(term) || exponential(term).is_some();
        let excess = self.sum(|term| one(exponential(term).is_some())).resolved();
        let stiction = self.sum(|term| one(acts(term) && is_dry(term)));
        let viscous = self.sum(|term| one(acts(term) && term.law == FrictionLaw::Viscous));
        let speed = excess.and_then(|_| self.decay(exponential, (-1.0_f64).exp(), 2));
        let widths = self.laws().map(|(_, term)| SEEN * term.law.width());
        let least = widths.fold(self.blurred(), f64::max);
        let is_seen = |speed: &Estimated| speed.value > least;
        let excess = excess.filter(|_| speed.as_ref().is_none_or(is_seen));
        Sliding {
            coulomb: self.sum(|term| one(acts(term) && is_coulomb(term))).positive(),
            stiction: excess.and_then(|_| stiction.positive()),
            stribeck_speed: speed.filter(is_seen),
            viscous: viscous.positive(),
        }
    }

    /// F(v) \[N·m\] without load at a speed v \[rad/s\] of the shaft, elements as after a long way.
    pub fn at_speed(&self, speed: f64) -> Estimated {
        self.sum(|term| if term.load { 0.0 } else { term.at_speed(speed) })
    }

    /// Speed \[rad/s\] from zero in half a period of the cut-off, at half the peak acceleration: the
    /// filter makes a curve of dry friction that reverses, which bends below it.
    fn blurred(&self) -> f64 {
        let Some(filter) = &self.model.training.filter else { return 0.0 };
        self.of_shaft(&self.model.training.ddq_peak) / (4.0 * filter.cutoff_hz)
    }

    /// The most that the shaft does of what joints do at most, n.
    fn of_shaft(&self, peaks: &[f64]) -> f64 {
        self.shaft.iter().zip(peaks).map(|(part, peak)| part.abs() * peak).sum()
    }

    /// Viscous \[N·m·s/rad\] and dry friction \[N·m\] nearest to the curve without load and offset
    /// from a tenth of the peak speed of the log on, mean of both directions, none negative: for
    /// robot files and simulators.
    pub fn line(&self) -> [f64; 2] {
        let peak = self.of_shaft(&self.model.training.dq_peak);
        let peak = if peak > 0.0 { peak } else { 1.0 };
        let at = |speed: f64| -> f64 {
            let laws = self.laws().filter(|(_, t)| !t.load && t.law != FrictionLaw::Offset);
            laws.map(|(k, term)| self.model.friction[k].coefficient * term.at_speed(speed)).sum()
        };
        let (mut m, mut sums) = (0.0, [0.0; 4]);
        for k in SLOW_SPEEDS..=SPEEDS {
            let speed = peak * f64::from(k) / f64::from(SPEEDS);
            let torque = 0.5 * (at(speed) - at(-speed));
            m += 1.0;
            for (sum, x) in sums.iter_mut().zip([speed, torque, speed * speed, speed * torque]) {
                *sum += x;
            }
        }
        let [v, f, vv, vf] = sums.map(|sum| sum / m);
        let viscous = (vf - v * f) / (vv - v * v);
        if viscous <= 0.0 {
            return [0.0, f.max(0.0)];
        }
        let dry = f - viscous * v;
        if dry >= 0.0 { [viscous, dry] } else { [(vf / vv).max(0.0), 0.0] }
    }

    /// What does not depend on speed of F \[N·m\] without load, to and fro between ∓`reach`
    /// \[rad\], at a place `q` \[rad\] between them on the way forward (1) or backward (−1).
    ///
    /// The state of an element on a closed loop: x = 1 − (1 + tanh(reach/δ)) e^(−(q + reach)/δ) on
    /// the way forward, and what is symmetric to it on the way backward.
    pub fn on_loop(&self, q: f64, reach: f64, way: f64) -> Estimated {
        self.sum(|term| match term.law {
            _ if !term.is_speedless() => 0.0,
            FrictionLaw::Dahl { travel } => {
                let start = 1.0 + (reach / travel).tanh();
                way * (1.0 - start * (-(way * q + reach) / travel).exp())
            }
            FrictionLaw::Offset => 1.0,
            _ => way * one(term.direction.holds(way)),
        })
    }

    /// Σ weight · coefficient over its laws.
    fn sum(&self, weight: impl Fn(&FrictionTerm) -> f64) -> Estimated {
        Estimated { value: self.value(&weight), std_error: self.std_error(&weight) }
    }

    fn value(&self, weight: impl Fn(&FrictionTerm) -> f64) -> f64 {
        let coefficient = |k: usize| self.model.friction[k].coefficient;
        self.laws().map(|(k, term)| weight(term) * coefficient(k)).sum()
    }

    /// Standard error of Σ weight · coefficient.
    fn std_error(&self, weight: impl Fn(&FrictionTerm) -> f64) -> f64 {
        let weights = self.laws().map(|(k, term)| (k, weight(term)));
        let chain = self.model.chain.as_ref().filter(|chain| !chain.covariance_root.is_empty());
        let Some(chain) = chain else {
            let own = |(k, weight): (usize, f64)| weight * self.model.friction[k].std_error;
            return weights.map(|weight| own(weight).powi(2)).sum::<f64>().sqrt();
        };
        let friction = self.model.friction.len();
        let mut all = vec![0.0; chain.n_parameters(friction)];
        let first = all.len() - chain.fitted.len() - friction;
        weights.for_each(|(k, weight)| all[first + k] = weight);
        chain.std_error_of(&all)
    }

    /// Where Σ c e^(−(x/scale)^power) has fallen to a `share` of Σ c, over the laws that have a
    /// scale.
    fn decay(
        &self,
        scale: impl Fn(&FrictionTerm) -> Option<f64>,
        share: f64,
        power: i32,
    ) -> Option<Estimated> {
        let (value, change) = self.decayed(&scale, share, power)?;
        Estimated { value, std_error: self.std_error(change) }.positive()
    }

    /// The first x above 0 at which Σ c e^(−(x/scale)^power) has fallen to a `share` of Σ c, over
    /// the laws that have a scale, and dx/dc.
    ///
    /// From 0 = g(x) = Σ c (e^(−(x/scale)^power) − share) follows dx/dc = −(∂g/∂c)/(∂g/∂x).
    fn decayed<'f, S: Fn(&FrictionTerm) -> Option<f64>>(
        &self,
        scale: &'f S,
        share: f64,
        power: i32,
    ) -> Option<(f64, impl Fn(&FrictionTerm) -> f64 + use<'f, S>)> {
        let over = |term: &FrictionTerm, value: &dyn Fn(f64) -> f64| scale(term).map_or(0.0, value);
        let left = move |scale: f64, x: f64| (-(x / scale).powi(power)).exp();
        let excess = |x: f64| self.value(|term| over(term, &|s| left(s, x) - share));
        let start = excess(0.0);
        let is_above = |x: f64| start * excess(x) > 0.0;

        // Coefficients of one sign end before the longest scale does.
        let longest = self.laws().filter_map(|(_, term)| scale(term)).fold(0.0, f64::max);
        let end = 2.0 * longest * (-share.ln()).powf(1.0 / f64::from(power));
        let step = end / f64::from(STEPS);
        let past = (1..=STEPS).map(|k| f64::from(k) * step).find(|&x| !is_above(x))?;
        let (mut low, mut high) = (past - step, past);
        for _ in 0..HALVINGS {
            let middle = f64::midpoint(low, high);
            if is_above(middle) { low = middle } else { high = middle }
        }

        let slope_of = |s: f64| -f64::from(power) / s * (high / s).powi(power - 1) * left(s, high);
        let slope = self.value(|term| over(term, &slope_of));
        let change =
            move |term: &FrictionTerm| scale(term).map_or(0.0, |s| (share - left(s, high)) / slope);
        Some((high, change))
    }
}

impl Estimated {
    fn resolved(self) -> Option<Self> {
        let is_known = self.value.is_finite() && self.std_error.is_finite();
        (is_known && self.value.abs() > LEAST_T * self.std_error).then_some(self)
    }

    fn positive(self) -> Option<Self> {
        self.resolved().filter(|own| own.value > 0.0)
    }
}

/// Dry friction that does not fade with speed.
fn is_coulomb(term: &FrictionTerm) -> bool {
    matches!(term.law, FrictionLaw::Coulomb { .. } | FrictionLaw::Dahl { .. })
}

/// The weight of a law that counts, or does not.
fn one(counts: bool) -> f64 {
    f64::from(u8::from(counts))
}
