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

impl Aligned {
    pub(super) fn new(joints: &[String], passes_over: bool) -> Self {
        Self { joints: joints.to_vec(), passes_over, names: Vec::new(), places: Vec::new() }
    }

    /// Where the joints stand in a message; `None` if it is about other joints, and the name of the
    /// first that is not there if it has only some of them.
    pub(super) fn find(&mut self, state: &JointState) -> Result<Option<&[usize]>, &str> {
        if self.places.is_empty() || self.names != state.names {
            let place = |joint: &String| state.names.iter().position(|name| name == joint);
            let places: Vec<_> = self.joints.iter().map(place).collect();
            if let Some(missing) = places.iter().position(Option::is_none) {
                let is_other = self.passes_over && places.iter().all(Option::is_none);
                return if is_other { Ok(None) } else { Err(&self.joints[missing]) };
            }
            self.places = places.into_iter().flatten().collect();
            self.names.clone_from(&state.names);
        }
        Ok(Some(&self.places))
    }
}

#[cfg(test)]
mod tests {
    use super::Aligned;
    use crate::bag::joint_state::JointState;

    #[test]
    fn joints_are_found_wherever_they_stand() {
        let find = |aligned: &mut Aligned, names: &[&str]| {
            let names = names.iter().map(|name| (*name).to_owned()).collect();
            let state = JointState { names, ..JointState::default() };
            let found = aligned.find(&state).map(|places| places.map(<[usize]>::to_vec));
            found.map_err(str::to_owned)
        };
        let mut aligned = Aligned::new(&["hip".to_owned(), "knee".to_owned()], true);

        assert_eq!(find(&mut aligned, &["hip", "knee"]), Ok(Some(vec![0, 1])));
        assert_eq!(find(&mut aligned, &["knee", "eye", "hip"]), Ok(Some(vec![2, 0])));
        assert_eq!(find(&mut aligned, &["eye"]), Ok(None));
        assert_eq!(find(&mut aligned, &["knee"]), Err("hip".to_owned()));
        assert_eq!(find(&mut aligned, &["knee", "eye", "hip"]), Ok(Some(vec![2, 0])));

        let mut strict = Aligned::new(&["hip".to_owned()], false);
        assert_eq!(find(&mut strict, &["eye"]), Err("hip".to_owned()));
    }
}
