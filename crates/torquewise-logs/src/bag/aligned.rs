//! From joint states that list joints in any order to places of the joints that are read.

use crate::bag::joint_state::JointState;

/// Finds the joints that are read in one message after the other.
#[derive(Clone, Debug)]
pub(super) struct Aligned {
    joints: Vec<String>,
    /// Whether messages without any of the joints are passed over.
    passes_over: bool,
    /// Names of the message last looked at, and where the joints stand in it.
    names: Vec<String>,
    places: Vec<usize>,
}

/// What a message holds of the joints that are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Holds<'a> {
    /// All of them, at these places.
    All(&'a [usize]),
    /// None of them: a message of another part of the robot.
    None,
    /// Some, but not this one.
    NotThis(&'a str),
}

impl Aligned {
    pub(super) fn new(joints: &[String], passes_over: bool) -> Self {
        Self { joints: joints.to_vec(), passes_over, names: Vec::new(), places: Vec::new() }
    }

    pub(super) fn find(&mut self, state: &JointState) -> Holds<'_> {
        if self.places.is_empty() || self.names != state.names {
            let place = |joint: &String| state.names.iter().position(|name| name == joint);
            let places: Vec<_> = self.joints.iter().map(place).collect();
            if let Some(missing) = places.iter().position(Option::is_none) {
                let is_other = self.passes_over && places.iter().all(Option::is_none);
                return if is_other { Holds::None } else { Holds::NotThis(&self.joints[missing]) };
            }
            self.places = places.into_iter().flatten().collect();
            self.names.clone_from(&state.names);
        }
        Holds::All(&self.places)
    }
}

#[cfg(test)]
mod tests {
    use super::{Aligned, Holds};
    use crate::bag::joint_state::JointState;

    fn state(names: &[&str]) -> JointState {
        let names = names.iter().map(|name| (*name).to_owned()).collect();
        JointState { names, ..JointState::default() }
    }

    #[test]
    fn joints_are_found_wherever_they_stand() {
        let mut aligned = Aligned::new(&["hip".to_owned(), "knee".to_owned()], true);

        assert_eq!(aligned.find(&state(&["hip", "knee"])), Holds::All(&[0, 1]));
        assert_eq!(aligned.find(&state(&["knee", "eye", "hip"])), Holds::All(&[2, 0]));
        assert_eq!(aligned.find(&state(&["eye"])), Holds::None);
        assert_eq!(aligned.find(&state(&["knee"])), Holds::NotThis("hip"));
        assert_eq!(aligned.find(&state(&["knee", "eye", "hip"])), Holds::All(&[2, 0]));

        let mut strict = Aligned::new(&["hip".to_owned()], false);
        assert_eq!(strict.find(&state(&["eye"])), Holds::NotThis("hip"));
    }
}
