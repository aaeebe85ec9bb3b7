//! Travel of each joint since its last reversal.

#[derive(Clone, Debug)]
pub(crate) struct Turning {
    /// Way \[rad\] after which friction counts as turned.
    travel: f64,
    /// Direction of motion, 1 or −1; 0 before the first.
    way: f64,
    /// Where it began to go this way \[rad\], and the farthest it came.
    start: f64,
    farthest: f64,
    /// Whether friction had turned before it went this way.
    is_turned: bool,
}

/// A way back of this part of the travel is a reversal, and less is noise.
const REVERSAL: f64 = 0.1;

impl Turning {
    pub(crate) fn new(travel: f64) -> Self {
        Self { travel, way: 0.0, start: f64::NAN, farthest: f64::NAN, is_turned: false }
    }

    /// Takes the next position \[rad\]: q less that of the last reversal, above zero on the way
    /// forward; NaN before the first, and where friction had not turned before.
    pub(crate) fn step(&mut self, q: f64) -> f64 {
        if self.start.is_nan() {
            (self.start, self.farthest) = (q, q);
        }
        let beyond = q - self.farthest;
        if beyond * self.way >= 0.0 && self.way != 0.0 {
            self.farthest = q;
        } else if beyond.abs() > REVERSAL * self.travel {
            self.is_turned = (self.farthest - self.start).abs() >= self.travel;
            (self.way, self.start, self.farthest) = (beyond.signum(), self.farthest, q);
        }
        if self.is_turned { q - self.start } else { f64::NAN }
    }
}

#[cfg(test)]
mod tests {
    use super::Turning;

    #[test]
    fn the_way_counts_from_where_a_joint_turned_once_friction_has_turned() {
        let mut turning = Turning::new(0.1);

        // To and fro by less than a hundredth is noise.
        let ways = [0.0, 0.3, 0.295, 0.3, 0.2, 0.205, 0.1, 0.15, 0.2].map(|q| turning.step(q));

        assert!(ways[..4].iter().all(|way| way.is_nan()), "no reversal yet: {ways:?}");
        for (found, expected) in ways[4..].iter().zip([-0.1, -0.095, -0.2, 0.05, 0.1]) {
            assert!((found - expected).abs() < 1e-12, "{ways:?}");
        }
        let mut turning = Turning::new(0.1);

        let ways = [0.0, 0.3, 0.25, 0.3].map(|q| turning.step(q));

        assert!((ways[2] + 0.05).abs() < 1e-12 && ways[3].is_nan(), "{ways:?}");
    }
}
