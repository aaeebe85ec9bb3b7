//! The friction that is offered: laws of each joint (17), with their speeds.

use torquewise_model::{Direction, FrictionLaw, FrictionTerm};
use torquewise_motion::path::TRAVELS;

/// Which friction is looked for (17).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FrictionKind {
    /// None: simulated arms, or torque measured behind the gears.
    #[default]
    None,
    /// Offset, viscous and dry friction of each joint.
    Linear,
    /// The same and the Stribeck curve, from a dictionary of speeds; forward and backward apart.
    Stribeck,
    /// None, linear or Stribeck, whichever predicts held-out rows best; the friction of a chain
    /// joint by joint, which may remember the path and depend on the load as well (E13).
    Auto,
}

/// Half width of the smooth sign, as a part of the peak speed of a joint.
const WIDTH: f64 = 0.01;
/// Widths that are tried, in the same parts: noise in a speed and filters blur its reversal, but
/// slow motion tells of the Stribeck curve only if the sign is sharp.
pub const WIDTHS: [f64; 3] = [WIDTH, 0.001, 0.003];
/// Stribeck speeds offered, as parts of the peak speed of a joint: each half as large again as the
/// one before, so that a curve of any speed between them is nearly a sum of two.
const STRIBECK_PARTS: [f64; 6] = [0.025, 0.035, 0.05, 0.075, 0.11, 0.17];

/// The choice among them, as the model file has it.
pub const REVERSAL: &str = "half width of the reversal of friction";

/// A width among the choices.
pub fn reversal_label(part: f64) -> String {
    format!("{} % of the peak speed", 100.0 * part)
}

/// A richer law must lower the error on held-out rows by this part, or it only follows how the sign
/// is smoothed.
pub const WORTH: f64 = 0.03;

/// Laws of friction by the speeds that joints reach.
#[derive(Clone, Debug)]
pub struct FrictionLibrary {
    /// Peak speed of each joint \[rad/s\], n.
    pub peak: Vec<f64>,
    /// Half width of the smooth sign of each joint \[rad/s\], n.
    pub width: Vec<f64>,
}

impl FrictionLibrary {
    /// - `peak`: peak speed of each joint \[rad/s\], n
    pub fn new(peak: Vec<f64>) -> Self {
        Self::with_width(peak, WIDTH)
    }

    /// - `part`: half width of the smooth sign, as a part of the peak speed
    pub fn with_width(peak: Vec<f64>, part: f64) -> Self {
        let width = peak.iter().map(|peak| rounded(part * peak)).collect();
        Self { peak, width }
    }

    /// Half width of the smooth sign of a shaft that several joints may turn \[rad/s\].
    pub fn width_of(&self, shaft: &[f64]) -> f64 {
        let turning = self.width.iter().zip(shaft).filter(|(_, part)| **part != 0.0);
        turning.map(|(width, _)| *width).fold(f64::INFINITY, f64::min)
    }

    /// All laws of a kind, joint by joint; those of `auto` are the largest dictionary.
    pub fn of(&self, kind: FrictionKind) -> Vec<FrictionTerm> {
        match kind {
            FrictionKind::None => Vec::new(),
            FrictionKind::Linear => self.linear(),
            FrictionKind::Stribeck | FrictionKind::Auto => {
                [self.linear(), self.stribeck()].concat()
            }
        }
    }

    /// Offset, viscous and dry friction of each joint.
    pub fn linear(&self) -> Vec<FrictionTerm> {
        let laws = |(joint, &width): (usize, &f64)| {
            [FrictionLaw::Offset, FrictionLaw::Viscous, FrictionLaw::Coulomb { width }]
                .map(|law| self.term(joint, law))
        };
        self.width.iter().enumerate().flat_map(laws).collect()
    }

    /// What the Stribeck curve of each joint adds to linear friction: exponentials of several
    /// speeds, and backward motion apart from forward motion.
    pub fn stribeck(&self) -> Vec<FrictionTerm> {
        (0..self.peak.len())
            .flat_map(|joint| {
                let width = self.width[joint];
                let speed = |part| rounded(part * self.peak[joint]).max(f64::MIN_POSITIVE);
                let bumps =
                    STRIBECK_PARTS.map(|part| FrictionLaw::Stribeck { speed: speed(part), width });
                let dry = FrictionLaw::Coulomb { width };
                let backward = bumps.into_iter().chain([FrictionLaw::Viscous, dry]);
                let backward = backward.map(move |law| FrictionTerm {
                    direction: Direction::Backward,
                    ..self.term(joint, law)
                });
                bumps.into_iter().map(move |law| self.term(joint, law)).chain(backward)
            })
            .collect()
    }

    /// Dahl elements of a joint (E13).
    pub fn dahl(&self, joint: usize) -> Vec<FrictionTerm> {
        TRAVELS.map(|travel| self.term(joint, FrictionLaw::Dahl { travel })).to_vec()
    }

    fn term(&self, joint: usize, law: FrictionLaw) -> FrictionTerm {
        FrictionTerm::of_joint(self.peak.len(), joint, law)
    }
}

/// To two digits: these are chosen, not measured, and people read them.
fn rounded(x: f64) -> f64 {
    if x <= 0.0 || !x.is_finite() {
        return 0.0;
    }
    let unit = 10_f64.powf(x.log10().floor() - 1.0);
    let digits = (x / unit).round();
    // Dividing by a power of ten gives the decimal that is meant, multiplying a neighbour.
    if unit < 1.0 { digits / (1.0 / unit).round() } else { digits * unit }
}

#[cfg(test)]
mod tests {
    use super::rounded;

    #[test]
    fn speeds_are_decimals_of_two_digits() {
        let text = [0.012_345, 1.987, 0.1, 43.21, 0.0].map(|x| format!("{}", rounded(x)));
        assert_eq!(text, ["0.012", "2", "0.1", "43", "0"]);
    }
}
