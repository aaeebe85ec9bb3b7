//! What the joint states of a bag hold, found in one pass before the rows are read.

#[cfg(feature = "sqlite")]
use crate::bag::db3_messages::{self, Db3Messages};
use crate::bag::joint_state::JointState;
use crate::bag::mcap_messages::{self, McapMessages};
use crate::bag::{JOINT_STATE, Messages, Topic};
use crate::{Format, LogError, LogInput, Result, RowPlace, joints, listed, shown};
use std::path::{Path, PathBuf};

/// Stamps beyond this \[ns\] are dates; seconds since 1970 cannot tell microseconds in 64 bits.
const LONGEST_RUN: i64 = 1_000_000_000_000_000;

#[derive(Clone, Debug, PartialEq, Eq)]
#[expect(clippy::struct_excessive_bools, reason = "one for each question")]
pub(crate) struct Survey {
    format: Format,
    topic: String,
    pub(crate) joints: Vec<String>,
    /// Whether the joints were asked for by name, so that messages of others are passed over.
    passes_over: bool,
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

    /// The messages that are about the joints.
    pub(super) fn states(&self, file: &LogInput) -> Result<JointStates> {
        let messages: Box<dyn Messages> = match self.format {
            #[cfg(feature = "sqlite")]
            Format::Db3 => Box::new(Db3Messages::open(file, &self.topic)?),
            _ => Box::new(McapMessages::open(file, Some(&self.topic))?),
        };
        Ok(JointStates {
            file: file.into(),
            messages,
            joints: self.joints.clone(),
            passes_over: self.passes_over,
            first_names: Vec::new(),
            names: Vec::new(),
            places: Vec::new(),
            n_messages: 0,
        })
    }

    /// Time of a message \[ns\].
    pub(super) fn stamp(&self, state: &JointState, received: i64) -> i64 {
        (if self.is_stamped { state.stamp } else { received }).saturating_sub(self.zero)
    }

    fn complete(&mut self, file: &LogInput) -> Result<()> {
        let mut states = self.states(file)?;
        let (mut first_stamp, mut first_received) = (i64::MAX, i64::MAX);
        let mut n_found = 0_u64;
        while let Some((state, received)) = states.next()? {
            let is_known = |values: &[f64]| {
                let mut places = states.places.iter();
                places.any(|place| values.get(*place).is_some_and(|value| !value.is_nan()))
            };
            self.has_velocity |= is_known(&state.velocity);
            self.has_effort |= is_known(&state.effort);
            self.is_stamped |= state.stamp != 0;
            first_stamp = first_stamp.min(state.stamp);
            first_received = first_received.min(received);
            n_found += 1;
        }
        if states.n_messages == 0 {
            return Err(LogError::NoRows { file: file.into() });
        }
        self.joints = states.joints;
        if n_found == 0 || states.first_names.is_empty() {
            let (wanted, found) = (self.joints.join(", "), listed(&states.first_names, 40));
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

/// The messages of a bag that are about the joints which are read, one after the other.
pub(super) struct JointStates {
    file: PathBuf,
    messages: Box<dyn Messages>,
    /// Those of the first message where none were asked for.
    joints: Vec<String>,
    passes_over: bool,
    first_names: Vec<String>,
    /// Names of the message last looked at, and where the joints stand in it.
    names: Vec<String>,
    pub(super) places: Vec<usize>,
    /// Messages read so far, of other joints among them.
    pub(super) n_messages: u64,
}

impl JointStates {
    /// The next message, and when the bag received it \[ns\]; `None` at the end.
    pub(super) fn next(&mut self) -> Result<Option<(JointState, i64)>> {
        while let Some(message) = self.messages.next()? {
            self.n_messages += 1;
            let state = JointState::decode(&message.bytes).map_err(|reason| {
                let problem = format!(": the message is no joint state, {reason}");
                LogError::unusable(self.place(), &problem, "record or convert the bag again")
            })?;
            if self.n_messages == 1 {
                self.first_names.clone_from(&state.names);
                if self.joints.is_empty() {
                    self.joints.clone_from(&state.names);
                }
            }
            if self.is_about_the_joints(&state)? {
                return Ok(Some((state, message.received)));
            }
        }
        Ok(None)
    }

    /// Finds where the joints stand in a message; an error if it has only some of them.
    fn is_about_the_joints(&mut self, state: &JointState) -> Result<bool> {
        if self.places.is_empty() || self.names != state.names {
            let find = |joint: &String| state.names.iter().position(|name| name == joint);
            let places: Vec<_> = self.joints.iter().map(find).collect();
            if self.passes_over && places.iter().all(Option::is_none) {
                return Ok(false);
            }
            if let Some(missing) = places.iter().position(Option::is_none) {
                let joint = shown(self.joints[missing].as_bytes());
                let (place, found) = (self.place(), listed(&state.names, 40));
                return Err(LogError::JointGone { place, joint, found });
            }
            self.places = places.into_iter().flatten().collect();
            self.names.clone_from(&state.names);
        }
        Ok(true)
    }

    fn place(&self) -> RowPlace {
        RowPlace { file: self.file.clone(), row: self.n_messages, line: None }
    }
}
