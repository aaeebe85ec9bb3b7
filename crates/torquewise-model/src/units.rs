//! Units of what is printed of an arm: those of its joints, whether they turn or slide.

use torquewise_rigid::{JointKind, JointKinds};

/// A unit of a joint that turns, as that of one of a kind: `N·m·s/rad` is `N·s/m` where it slides.
pub fn unit(kind: JointKind, text: &str) -> String {
    text.replace("N·m", kind.effort_unit).replace("rad", kind.unit)
}

/// A heading such as `F_c [N·m]` or `q [rad]`, with the units of sliding joints beside those of
/// turning ones, where an arm has any: `F_c [N·m, N]`.
pub fn heading(kinds: &JointKinds, text: &str) -> String {
    let Some((name, unit)) = text.trim_end_matches(']').rsplit_once('[') else {
        return text.to_owned();
    };
    let mut units = vec![unit.to_owned()];
    for own in Vec::from(kinds.clone()).into_iter().map(|kind| self::unit(kind, unit)) {
        if !units.contains(&own) {
            units.push(own);
        }
    }
    format!("{name}[{}]", units.join(", "))
}

#[cfg(test)]
mod tests {
    use super::heading;
    use torquewise_rigid::JointKinds;

    #[test]
    fn units_of_slides_stand_beside_those_of_turns() {
        let kinds = JointKinds::read("RP").unwrap();
        for (text, expected) in [
            ("F_v [N·m·s/rad]", "F_v [N·m·s/rad, N·s/m]"),
            ("dq to [rad/s]", "dq to [rad/s, m/s]"),
            ("joint1 [mrad]", "joint1 [mrad, mm]"),
            ("NRMSE [%]", "NRMSE [%]"),
            ("joint", "joint"),
        ] {
            assert_eq!(heading(&kinds, text), expected);
            assert_eq!(heading(&JointKinds::default(), text), text);
        }
    }
}
