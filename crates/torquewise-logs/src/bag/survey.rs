//! What the joint states of a bag hold, found in one pass before the rows are read.

#[cfg(feature = "sqlite")]
use crate::bag::db3_messages::{self, Db3Messages};
use crate::bag::joint_state::JointState;
use crate::bag::mcap_messages::{self, McapMessages};
use crate::bag::{JOINT_STATE, Messages, Topic};
use crate::error::{LogError, Result, RowPlace, listed, shown};
use crate::format::Format;
use crate::joints;
use crate::log_input::LogInput;
use std::path::Path;

/// Stamps beyond this \[ns\] are dates; seconds since 1970 cannot tell microseconds in 64 bits.
const LONGEST_RUN: i64 = 1_000_000_000_000_000;

#[derive(Clone, Debug, PartialEq, Eq)]
#[expect(clippy::struct_excessive_bools, reason = "one for each question")]
pub(crate) struct Survey {
    format: Format,
    topic: String,
    pub(crate) joints: Vec<String>,
    /// Whether the joints were asked for by name, so that messages of others are passed over.
    pub(super) passes_over: bool,
    /// Whether the time of a message is that of its sender, not that of the bag.
    is_stamped: bool,
    /// Time stamp that counts as zero \[ns\].
    zero: i64,
    pub(crate) has_velocity: bool,
    pub(crate) has_effort: bool,
}

impl Survey {
    /// Goes through the messages of the topic that is wanted, or of the only one there is.
    pub(crate) fn new(
        file: &LogInput,
        format: Format,
        topic: Option<&str>,
        joints: &[String],
    ) -> Result<Self> {
        let topics = match format {
            #[cfg(feature = "sqlite")]
            Format::Db3 => db3_messages::topics(file)?,
            _ => mcap_messages::topics(file)?,
        };
        let mut survey = Self {
            format,
            topic: chosen(file, &topics, topic)?,
            joints: joints.to_vec(),
            passes_over: !joints.is_empty(),
            is_stamped: false,
            zero: 0,
            has_velocity: false,
            has_effort: false,
        };
        survey.complete(file)?;
        joints::check(&survey.joints)?;
        Ok(survey)
    }

    pub(super) fn messages(&self, file: &LogInput) -> Result<Box<dyn Messages>> {
        Ok(match self.format {
            #[cfg(feature = "sqlite")]
            Format::Db3 => Box::new(Db3Messages::open(file, &self.topic)?),
            _ => Box::new(McapMessages::open(file, Some(&self.topic))?),
        })
    }

    /// Time of a message \[ns\].
    pub(super) fn stamp(&self, state: &JointState, received: i64) -> i64 {
        (if self.is_stamped { state.stamp } else { received }).saturating_sub(self.zero)
    }

    fn complete(&mut self, file: &LogInput) -> Result<()> {
        let mut messages = self.messages(file)?;
        let mut aligned = self.passes_over.then(|| Aligned::new(&self.joints, true));
        let (mut first_stamp, mut first_received) = (i64::MAX, i64::MAX);
        let mut first_names = None;
        let (mut n_messages, mut n_found) = (0, 0_u64);
        while let Some(message) = messages.next()? {
            n_messages += 1;
            let place = || RowPlace { file: file.into(), row: n_messages, line: None };
            let state = decoded(&message.bytes, place)?;
            first_names.get_or_insert_with(|| state.names.clone());
            let aligned = aligned.get_or_insert_with(|| Aligned::new(&state.names, false));
            let Some(places) = aligned.find(&state, place)? else { continue };
            let is_known = |values: &[f64]| {
                places.iter().any(|place| values.get(*place).is_some_and(|value| !value.is_nan()))
            };
            self.has_velocity |= is_known(&state.velocity);
            self.has_effort |= is_known(&state.effort);
            self.is_stamped |= state.stamp != 0;
            first_stamp = first_stamp.min(state.stamp);
            first_received = first_received.min(message.received);
            n_found += 1;
        }
        let found = first_names.ok_or_else(|| LogError::NoRows { file: file.into() })?;
        if self.joints.is_empty() {
            self.joints.clone_from(&found);
        }
        if n_found == 0 || found.is_empty() {
            let (wanted, found) = (self.joints.join(", "), listed(&found, 40));
            let problem =
                format!(" has no message of the joints {wanted}, its first names {found}");
            let help = "name joints as the bag does";
            return Err(LogError::unusable(file.display(), &problem, help));
        }
        let first = if self.is_stamped { first_stamp } else { first_received };
        self.zero = if first > LONGEST_RUN { first } else { 0 };
        Ok(())
    }
}

pub(super) fn decoded(bytes: &[u8], place: impl Fn() -> RowPlace) -> Result<JointState> {
    let malformed = |reason| {
        let problem = format!(": the message is no joint state, {reason}");
        LogError::unusable(place(), &problem, "record or convert the bag again")
    };
    JointState::decode(bytes).map_err(malformed)
}

fn chosen(file: &Path, topics: &[Topic], wanted: Option<&str>) -> Result<String> {
    let listed = |topics: &[&Topic]| {
        let topic = |topic: &&Topic| {
            let (name, kind) = (shown(topic.name.as_bytes()), shown(topic.kind.as_bytes()));
            format!("{name} ({kind}, {} messages)", topic.n_messages)
        };
        topics.iter().map(topic).collect::<Vec<_>>().join(", ")
    };
    let is_read = |topic: &&Topic| {
        topic.kind == JOINT_STATE && topic.encoding == "cdr" && topic.n_messages > 0
    };
    let read: Vec<_> = topics.iter().filter(is_read).collect();
    let found = || {
        if topics.is_empty() { "none".into() } else { listed(&topics.iter().collect::<Vec<_>>()) }
    };
    let refused = |problem: &str, help| Err(LogError::unusable(file.display(), problem, help));
    match (wanted, read.as_slice()) {
        (Some(wanted), read) if read.iter().any(|topic| topic.name == wanted) => Ok(wanted.into()),
        (Some(wanted), _) => {
            let topic = shown(wanted.as_bytes());
            refused(
                &format!(" has no joint states on topic {topic}, its topics are {}", found()),
                "choose one of type sensor_msgs/msg/JointState that has messages",
            )
        }
        (None, [only]) => Ok(only.name.clone()),
        (None, []) => refused(
            &format!(
                " has no joint states (sensor_msgs/msg/JointState in CDR), its topics are {}",
                found()
            ),
            "record /joint_states",
        ),
        (None, several) => refused(
            &format!(" has several topics of joint states, {}", listed(several)),
            "choose one by its name, in the options or by topic = \"…\" in a profile",
        ),
    }
}

/// Finds the joints that are read in one message after the other.
#[derive(Clone, Debug)]
pub(super) struct Aligned {
    joints: Vec<String>,
    passes_over: bool,
    /// Names of the message last looked at, and where the joints stand in it.
    names: Vec<String>,
    places: Vec<usize>,
}

impl Aligned {
    pub(super) fn new(joints: &[String], passes_over: bool) -> Self {
        Self { joints: joints.to_vec(), passes_over, names: Vec::new(), places: Vec::new() }
    }

    /// Where the joints stand in a message; `None` if it is about other joints, an error if it has
    /// only some of them.
    pub(super) fn find(
        &mut self,
        state: &JointState,
        place: impl Fn() -> RowPlace,
    ) -> Result<Option<&[usize]>> {
        if self.places.is_empty() || self.names != state.names {
            let find = |joint: &String| state.names.iter().position(|name| name == joint);
            let places: Vec<_> = self.joints.iter().map(find).collect();
            if self.passes_over && places.iter().all(Option::is_none) {
                return Ok(None);
            }
            if let Some(missing) = places.iter().position(Option::is_none) {
                let joint = shown(self.joints[missing].as_bytes());
                let (place, found) = (place(), listed(&state.names, 40));
                return Err(LogError::JointGone { place, joint, found });
            }
            self.places = places.into_iter().flatten().collect();
            self.names.clone_from(&state.names);
        }
        Ok(Some(&self.places))
    }
}
