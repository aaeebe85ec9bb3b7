//! Right angles, what is put there, and what stays free.

use super::{Geometry, RIGHT_ANGLES, axis, nearest_right_angle};
use crate::ChainError;
use approx::assert_relative_eq;
use nalgebra::Vector3;
use std::f64::consts::{FRAC_PI_2, PI};

#[test]
fn right_angles_are_the_six_directions_of_the_frame_before() {
    let mut axes = RIGHT_ANGLES.map(|w| {
        let axis = axis(w);
        let whole: Vector3<f64> = axis.map(f64::round);
        assert_relative_eq!(axis, whole, epsilon = 1e-15);
        #[expect(clippy::cast_possible_truncation, reason = "−1, 0 or 1")]
        [whole.x as i32, whole.y as i32, whole.z as i32]
    });
    axes.sort_unstable();

    let all = [[-1, 0, 0], [0, -1, 0], [0, 0, -1], [0, 0, 1], [0, 1, 0], [1, 0, 0]];
    assert_eq!(axes, all);
}

#[test]
fn the_nearest_right_angle_of_one_is_itself_and_of_an_axis_turned_back_keeps_its_frame() {
    for right in RIGHT_ANGLES {
        let near = [right[0] + 0.1, right[1] - 0.2];

        let found = axis(nearest_right_angle(near));

        assert_relative_eq!(found, axis(right), epsilon = 1e-14);
    }
    // Half a turn about x − y, which no right angle is written as.
    let size = (PI - 0.1) / 2.0_f64.sqrt();

    let found = nearest_right_angle([size, -size]);

    assert_relative_eq!(found[0], -found[1], epsilon = 1e-14);
    assert_relative_eq!(axis(found), -Vector3::z(), epsilon = 1e-14);
}

#[test]
fn snapping_moves_what_is_near_and_frees_what_is_far_such_as_a_tilted_base() {
    let far = [0.7, 0.1, 0.2, -0.3];
    let near = [FRAC_PI_2 + 0.05, -0.02, 0.01, 0.4];
    let geometry = Geometry::new(&[&[0.02, -0.03], &far[..], &near[..]].concat()).unwrap();

    let (snapped, free) = geometry.snapped(0.1);

    // Gravity is near straight down, axis 2 far from all, axis 3 near x.
    let expected = [0.0, 0.0, 0.7, 0.1, 0.2, -0.3, FRAC_PI_2, 0.0, 0.01, 0.4];
    assert_eq!(snapped.parameters(), expected);
    assert_eq!(free, [2, 3, 4, 5, 8, 9]);
    let geometry = Geometry::new(&[0.3, 0.0, 0.0, 0.01, 0.0, 0.0]).unwrap();

    let (snapped, free) = geometry.snapped(0.1);

    assert_eq!(snapped.parameters(), [0.3, 0.0, 0.0, 0.0, 0.0, 0.0]);
    assert_eq!(free, [0, 1, 4, 5]);
}

#[test]
fn an_axis_turned_across_leaves_those_beyond_where_they_were() {
    let arm = [0.1, 0.0, 0.0, 0.0, 0.2, -0.3, FRAC_PI_2, 0.0, 0.1, 0.4];
    let geometry = Geometry::new(&arm).unwrap();
    assert!(geometry.is_parallel(1));

    let turned = geometry.turned_across(1);

    assert_eq!(turned.len(), 4);
    for other in turned {
        let (before, after) = (geometry.upright(), other.upright());
        assert!(!other.is_parallel(1));
        let [a, b] = [before[2].axis(), after[2].axis()];
        assert_relative_eq!(a, b, epsilon = 1e-12);
        // The third axis is the same line.
        let apart = before[2].origin - after[2].origin;
        assert_relative_eq!(apart.cross(&a).norm(), 0.0, epsilon = 1e-12);
    }
}

#[test]
fn gravity_of_a_straight_chain_points_down_and_turns_with_a_tilt() {
    let tilted = Geometry::new(&[0.2, 0.0]).unwrap();
    for (geometry, tilt) in [(Geometry::straight(3), 0.0_f64), (tilted, 0.2)] {
        let [x, y, z] = geometry.gravity();

        assert_relative_eq!(x, 0.0);
        assert_relative_eq!(y, super::GRAVITY * tilt.sin(), epsilon = 1e-14);
        assert_relative_eq!(z, -super::GRAVITY * tilt.cos(), epsilon = 1e-14);
    }
}

#[test]
fn numbers_that_make_no_chain_are_refused() {
    for count in [0, 1, 3, 5, 7] {
        let error = Geometry::new(&vec![0.0; count]).unwrap_err();

        assert!(
            matches!(error, ChainError::Shape { what: "geometry", found, .. } if found == count)
        );
    }
}
