//! A recording as waypoints and YAML: `trajectory_msgs/msg/JointTrajectory` of ROS 2.

use crate::excite::recording::Planned;
use crate::{Result, State, check_between};
use torquewise_motion::{Recording, whole};

/// Points from which splines of order 5 make the motion again, at least `rate` per second: the time
/// since the start \[ns\], and where the joints are and how they move then.
///
/// There is a point wherever another polynomial begins, so that glides and sweeps are met exactly;
/// sines are met to h⁶/46080 of their sixth derivative, h the time between two points.
///
/// # Errors
/// `SimError::Setting` if `rate` is not from 1 to 1000 Hz.
pub fn waypoints(recording: &Planned, rate: f64) -> Result<Vec<(u64, State)>> {
    check_between("ROS rate [Hz]", rate, [1.0, 1000.0], "from 1 to 1000")?;
    let breaks = recording.breaks();
    let mut points: Vec<(u64, State)> = Vec::new();
    let mut add = |t: f64| {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "from 0 to a few hours; a float cast saturates"
        )]
        let nanoseconds = (t * 1e9).round() as u64;
        if points.last().is_none_or(|(last, _)| last + LEAST_STEP <= nanoseconds) {
            // The state of the time that is written, not of the one it was rounded from.
            points.push((nanoseconds, recording.state_at(nanoseconds as f64 / 1e9)));
        }
    };
    for pair in breaks.windows(2) {
        let [from, to] = [pair[0], pair[1]];
        let steps = ((to - from) * rate).ceil().max(1.0);
        (0..whole(steps)).for_each(|step| add(from + (to - from) * step as f64 / steps));
    }
    // At rest at home, for certain.
    add((recording.seconds * 1e9).ceil() / 1e9 + 1e-6);
    Ok(points)
}

/// Points closer than a microsecond would be a division by nothing.
const LEAST_STEP: u64 = 1_000;

/// The message as YAML, as `ros2 topic pub` and most tools read it.
///
/// # Errors
/// As [`waypoints`].
pub fn joint_trajectory(recording: &Planned, rate: f64) -> Result<String> {
    let names: Vec<String> = recording.joints().iter().map(|name| quoted(name)).collect();
    let points = waypoints(recording, rate)?;
    let point = |(nanoseconds, state): &(u64, State)| {
        format!(
            "- positions: {}\n  velocities: {}\n  accelerations: {}\n  effort: []\n  \
             time_from_start: {{sec: {}, nanosec: {}}}\n",
            numbers(&state.q),
            numbers(&state.dq),
            numbers(&state.ddq),
            nanoseconds / 1_000_000_000,
            nanoseconds % 1_000_000_000,
        )
    };
    Ok(format!(
        "# trajectory_msgs/msg/JointTrajectory: {}, {:.3} s, begins and ends at rest\n\
         header:\n  stamp: {{sec: 0, nanosec: 0}}\n  frame_id: \"\"\n\
         joint_names: [{}]\npoints:\n{}",
        recording.name,
        recording.seconds,
        names.join(", "),
        points.iter().map(point).collect::<String>(),
    ))
}

/// A name as YAML cannot misread it: a JSON string is one of YAML.
fn quoted(name: &str) -> String {
    serde_json::Value::from(name).to_string()
}

/// Without exponents, which YAML 1.1 takes for words.
fn numbers(values: &[f64]) -> String {
    let number = |value: &f64| {
        let text = format!("{value:.12}");
        if text.trim_start_matches('-').bytes().all(|byte| byte == b'0' || byte == b'.') {
            "0.0".to_owned()
        } else {
            text
        }
    };
    format!("[{}]", values.iter().map(number).collect::<Vec<_>>().join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_numbers_have_no_exponent_and_no_negative_zero_and_names_are_quoted() {
        assert_eq!(numbers(&[-1e-15, 1e-7, -2.5]), "[0.0, 0.000000100000, -2.500000000000]");
        assert_eq!(quoted("on: \"\u{1}"), "\"on: \\\"\\u0001\"");
    }
}
