//! What of a geometry may move, and in what other ways its axes may lie.

use std::f64::consts::PI;

use super::{Geometry, PER_JOINT, RIGHT_ANGLES, axis, first_of, nearest_right_angle, turn};

impl Geometry {
    /// Whether torque depends on the place of a joint, counted from 0: it and one before it are revolute.
    pub fn has_place(&self, joint: usize) -> bool {
        let turns = |joint: usize| self.kinds.of(joint).turns();
        turns(joint) && (0..joint).any(turns)
    }

    /// The parameters that torque may depend on: all but places that are none.
    pub fn movable(&self) -> Vec<usize> {
        // No angle is less than zero: nothing is put anywhere.
        self.snapped(0.0).1
    }

    /// The same arm with axes nearer than `angle` \[rad\] to a right angle put there, gravity among
    /// them, and the parameters that may move: all places, and directions farther away.
    pub fn snapped(&self, angle: f64) -> (Self, Vec<usize>) {
        let mut snapped = self.clone();
        let mut free = Vec::new();
        for joint in 0..self.n_joints() {
            let (first, turn) = (first_of(joint), self.turn_of(joint));
            let right = nearest_right_angle(turn);
            if axis(turn).angle(&axis(right)) < angle {
                snapped.set_turn(joint, right);
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

    /// The same arm but for one axis, which is turned by an eighth and a quarter of a turn in each of four
    /// ways, and round; the axes beyond lie where they lay at q = 0.
    pub fn turned_each_way(&self, joint: usize) -> impl Iterator<Item = Self> {
        let eighths = RIGHT_ANGLES[1..5].iter().map(|direction| direction.map(|w| 0.5 * w));
        let all = RIGHT_ANGLES[1..].iter().copied().chain(eighths);
        all.map(move |direction| self.turned(joint, direction))
    }

    /// The same arm but for one axis, which points the other way.
    pub fn turned_back(&self, joint: usize) -> Self {
        self.turned(joint, [PI, 0.0])
    }

    /// The mirror image of an arm whose joints all turn, seen from axes that point the other way.
    pub(crate) fn mirrored(&self) -> Self {
        let mut mirrored = self.clone();
        for joint in 1..self.n_joints() {
            mirrored.set_turn(joint, self.turn_of(joint).map(|w| 0.0 - w));
        }
        let [x, y] = self.turn_of(0);
        let angle = x.hypot(y);
        let other = |w: f64| w * (PI - angle) / angle;
        mirrored.set_turn(0, if angle > 0.0 { [x, y].map(other) } else { [PI, 0.0] });
        mirrored
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
            geometry.set_turn(0, self.turn_of(0));
        }
        geometry.coupled(self.coupling.clone())
    }
}
