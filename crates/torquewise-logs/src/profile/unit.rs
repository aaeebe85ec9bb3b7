//! From names of units to factors to SI.

use std::f64::consts::{PI, TAU};
use torquewise_motion::Signal;

const POSITION: [(&str, f64); 4] = [("rad", 1.0), ("deg", PI / 180.0), ("rev", TAU), ("m", 1.0)];

const VELOCITY: [(&str, f64); 5] =
    [("rad/s", 1.0), ("deg/s", PI / 180.0), ("rpm", TAU / 60.0), ("rev/s", TAU), ("m/s", 1.0)];

const ACCELERATION: [(&str, f64); 3] = [("rad/s2", 1.0), ("deg/s2", PI / 180.0), ("m/s2", 1.0)];

/// With amperes: the torque constant is a factor of its own.
const TORQUE: [(&str, f64); 7] = [
    ("N.m", 1.0),
    ("Nm", 1.0),
    ("mN.m", 1e-3),
    ("mNm", 1e-3),
    ("N", 1.0),
    (AMPERE, 1.0),
    ("mA", 1e-3),
];

const TIME: [(&str, f64); 4] = [("s", 1.0), ("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9)];

pub(crate) const AMPERE: &str = "A";

pub(crate) fn factor(signal: Signal, unit: Option<&str>) -> Option<f64> {
    unit.map_or(Some(1.0), |unit| find(of(signal), unit))
}

pub(crate) fn time_factor(unit: Option<&str>) -> Option<f64> {
    unit.map_or(Some(1.0), |unit| find(&TIME, unit))
}

/// The unit of time whose usual steps are of this length, for logs of 10 Hz to 10 kHz.
pub(crate) fn of_step(step: f64) -> (&'static str, f64) {
    match step {
        step if step < 0.2 => ("s", 1.0),
        step if step < 200.0 => ("ms", 1e-3),
        step if step < 2e5 => ("us", 1e-6),
        _ => ("ns", 1e-9),
    }
}

pub(crate) fn is_current(unit: Option<&str>) -> bool {
    unit.is_some_and(|unit| unit == AMPERE || unit == "mA")
}

pub(crate) fn known(signal: Option<Signal>) -> String {
    let units = signal.map_or(&TIME[..], of);
    units.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(", ")
}

fn of(signal: Signal) -> &'static [(&'static str, f64)] {
    [&POSITION[..], &VELOCITY, &ACCELERATION, &TORQUE][signal as usize]
}

fn find(units: &[(&str, f64)], name: &str) -> Option<f64> {
    units.iter().find(|(known, _)| *known == name).map(|(_, factor)| *factor)
}

#[cfg(test)]
mod tests {
    use super::{factor, known, time_factor};
    use torquewise_motion::signals::Signal;

    #[test]
    fn a_turn_is_the_same_in_every_unit_and_units_of_another_signal_are_unknown() {
        let radians = |turn: f64, unit| turn * factor(Signal::Q, Some(unit)).unwrap();
        assert_eq!(radians(360.0, "deg").to_bits(), radians(1.0, "rev").to_bits());
        let per_second = |turn: f64, unit| turn * factor(Signal::Dq, Some(unit)).unwrap();
        assert_eq!(per_second(60.0, "rpm").to_bits(), per_second(1.0, "rev/s").to_bits());
        assert_eq!(per_second(180.0, "deg/s").to_bits(), std::f64::consts::PI.to_bits());
        assert_eq!(factor(Signal::Q, Some("rad/s")), None);
        assert_eq!(factor(Signal::Tau, Some("rad")), None);
        assert_eq!((factor(Signal::Ddq, None), time_factor(Some("min"))), (Some(1.0), None));
        assert_eq!(known(None), "s, ms, us, ns");
    }
}
