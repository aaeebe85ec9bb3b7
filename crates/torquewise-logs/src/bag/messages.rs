//! From bag file to topics and messages: what every storage of a bag is decoded to.

use crate::error::LogError;

/// The message type that is read.
pub(crate) const JOINT_STATE: &str = "sensor_msgs/msg/JointState";

/// Bytes of a message, or of a part of a bag that has to be held whole, at most.
pub(crate) const MAX_BYTES: usize = 1 << 27;

/// A topic of a bag.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Topic {
    pub(crate) name: String,
    /// Message type, such as sensor_msgs/msg/JointState.
    pub(crate) kind: String,
    pub(crate) encoding: String,
    pub(crate) n_messages: u64,
}

/// A message of the topic that is read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Message {
    /// When the bag received it \[ns\].
    pub(crate) received: i64,
    pub(crate) bytes: Vec<u8>,
}

/// The messages of one topic, roughly in order of time.
pub(crate) trait Messages {
    /// The next one; `None` at the end.
    fn next(&mut self) -> Result<Option<Message>, LogError>;
}
