//! Coupled joints: joint angles of a chain from logged coordinates, q_chain = Γ q (E18).

use serde::{Deserialize, Serialize};
use simba::simd::SimdRealField;

/// A joint whose angle in the chain is its logged coordinate and a multiple of that of a joint
/// before it, as behind a parallelogram or in a coupled wrist.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Coupled {
    /// The joint, counted from 0.
    pub joint: usize,
    /// The joint before it whose coordinate turns it as well.
    pub driver: usize,
    /// The multiple, not zero: energies stay sums of harmonics of the coordinates only if it is an
    /// integer.
    pub ratio: i8,
}

/// The map Γ from logged coordinates to joint angles, q_chain = Γ q, unit lower triangular. By
/// virtual work τ = Γᵀ τ_chain and M = Γᵀ M_chain Γ \[E18\]. Empty is the identity.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Coupling {
    /// Ascending by joint and driver.
    coupled: Vec<Coupled>,
}

/// Multiples that the coordinates of one joint may add up to.
const MOST_MULTIPLES: usize = 8;

impl Coupling {
    /// The same with another coupled joint; one of the same joint and driver is replaced.
    #[must_use]
    pub fn with(&self, coupled: Coupled) -> Self {
        let same = |own: &Coupled| (own.joint, own.driver) == (coupled.joint, coupled.driver);
        let mut all: Vec<Coupled> = self.coupled.iter().copied().filter(|own| !same(own)).collect();
        all.push(coupled);
        all.sort_unstable();
        Self { coupled: all }
    }

    /// Whether the logged coordinates are the angles of the chain.
    pub fn is_none(&self) -> bool {
        self.coupled.is_empty()
    }

    /// The coupled joints, ascending by joint and driver.
    pub fn coupled(&self) -> &[Coupled] {
        &self.coupled
    }

    /// Whether it couples joints of n, each to one before it, once, by multiples that energies can
    /// be listed with.
    pub fn is_sound(&self, n: usize) -> bool {
        let sound = |own: &Coupled| own.driver < own.joint && own.joint < n && own.ratio != 0;
        let once = |a: &Coupled, b: &Coupled| (a.joint, a.driver) < (b.joint, b.driver);
        self.coupled.iter().all(sound)
            && self.coupled.is_sorted_by(once)
            && (0..n).all(|joint| self.multiples_of(joint) <= MOST_MULTIPLES)
    }

    /// How often the coordinate of a joint turns joints of the chain: Σᵢ |Γᵢⱼ|, 1 where nothing
    /// is coupled to it.
    fn multiples_of(&self, joint: usize) -> usize {
        let driven = self.coupled.iter().filter(|own| own.driver == joint);
        1 + driven.map(|own| usize::from(own.ratio.unsigned_abs())).sum::<usize>()
    }

    /// The row of Γ of a joint: integer multiples of all coordinates, n.
    pub fn row(&self, joint: usize, n: usize) -> Vec<i8> {
        let mut row = vec![0; n];
        row[joint] = 1;
        for own in self.coupled.iter().filter(|own| own.joint == joint) {
            row[own.driver] = own.ratio;
        }
        row
    }

    /// What a joint of the chain does: Γq, Γq̇ or Γq̈ of one joint, from those of the log.
    pub(crate) fn drive<T: SimdRealField<Element = f64> + Copy>(
        &self,
        joint: usize,
        of: impl Fn(usize) -> T,
    ) -> T {
        let driving = self.coupled.iter().filter(|own| own.joint == joint);
        driving.fold(of(joint), |sum, own| sum + of(own.driver) * T::splat(own.ratio.into()))
    }

    /// Torques of the joints of the chain → those of the logged coordinates, in place: Γᵀτ.
    ///
    /// - `torque`: \[N·m\], n
    pub(crate) fn load<T: SimdRealField<Element = f64> + Copy>(&self, torque: &mut [T]) {
        // Ascending by joint: the torque of a joint is read before those beyond add to it.
        for own in &self.coupled {
            let load = torque[own.joint] * T::splat(own.ratio.into());
            torque[own.driver] += load;
        }
    }
}
