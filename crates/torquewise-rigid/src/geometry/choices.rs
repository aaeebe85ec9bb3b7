//! What of a geometry may move, and in what other ways its axes may lie.

use std::f64::consts::PI;

use super::{Geometry, PER_BASE, PER_JOINT, RIGHT_ANGLES, axis, nearest_right_angle, turn};

impl Geometry {
    /// Whether torque depends on the place of a joint, counted from 0: it and one before it are revolute.
    pub fn has_place(&self, joint: usize) -> bool {
        let turns = |joint: usize| self.kinds.of(joint).turns();
        turns(joint) && (0..joint).any(turns)
    }

    /// The parameters that torque may depend on: all but places that are none.
    pub fn movable(&self) -> Vec<usize> {
        let of_joint = |joint: usize| {
            let first = PER_BASE + PER_JOINT * (joint - 1);
            first..first + if self.has_place(joint) { PER_JOINT } else { 2 }
        };
        (0..PER_BASE).chain((1..self.n_joints()).flat_map(of_joint)).collect()
    }

    /// The same arm with axes nearer than `angle` \[rad\] to a right angle put there, gravity among
    /// them, and the parameters that may move: all places, and directions farther away.
    pub fn snapped(&self, angle: f64) -> (Self, Vec<usize>) {
        let mut snapped = self.clone();
        let mut free = Vec::new();
        let right = nearest_right_angle(self.tilt());
        if axis(self.tilt()).angle(&axis(right)) < angle {
            snapped.set_tilt(right);
        } else {
            free.extend(0..PER_BASE);
        }
        for joint in 1..self.n_joints() {
            let first = PER_BASE + PER_JOINT * (joint - 1);
            let direction = self.direction(joint);
            let right = nearest_right_angle(direction);
            if axis(direction).angle(&axis(right)) < angle {
                snapped.set_direction(joint, right);
            } else {
                free.extend([first, first + 1]);
            }
            if self.has_place(joint) {
                free.extend(first + 2..first + PER_JOINT);
            }
        }
        (snapped, free)
    }

    /// Whether the axis of a joint, not the first, is parallel to that of the joint before.
    pub fn is_parallel(&self, joint: usize) -> bool {
        axis(nearest_right_angle(self.direction(joint))).z.abs() > 0.5
    }

    /// The same arm but for one axis, which is turned to stand across the one before in each of four
    /// ways; the axes beyond lie where they lay at q = 0.
    pub fn turned_across(&self, joint: usize) -> Vec<Self> {
        let across = RIGHT_ANGLES.iter().filter(|w| axis(**w).z.abs() < 0.5);
        across.map(|direction| self.turned(joint, *direction)).collect()
    }

    /// The same arm but for one axis, which points the other way.
    pub fn turned_back(&self, joint: usize) -> Self {
        self.turned(joint, [PI, 0.0])
    }

    fn turned(&self, joint: usize, direction: [f64; 2]) -> Self {
        let mut frames = self.placements();
        let by = turn(direction);
        frames[joint].rotation *= by;
        if let Some(next) = frames.get_mut(joint + 1) {
            next.rotation = by.tr_mul(&next.rotation);
            next.origin = by.tr_mul(&next.origin);
        }
        let (mut geometry, _) = Self::of_joints(&frames, &self.kinds, self.gravity());
        if joint > 0 {
            geometry.set_tilt(self.tilt());
        }
        geometry.coupled(self.coupling.clone())
    }
}
