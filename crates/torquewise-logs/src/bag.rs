//! ROS 2 bags: rows of joint states, position, velocity and effort by joint name.

mod joint_state;
#[cfg(feature = "sqlite")]
mod db3_messages;
mod mcap_messages;
mod survey;
mod rows;

use crate::Result;

pub(crate) use rows::BagRows;
pub(crate) use survey::Survey;

const JOINT_STATE: &str = "sensor_msgs/msg/JointState";

/// Bytes of a message, or of a part of a bag that has to be held whole, at most.
const MAX_BYTES: usize = 1 << 27;

struct Topic {
    name: String,
    kind: String,
    encoding: String,
    n_messages: u64,
}

struct Message {
    /// When the bag received it \[ns\].
    received: i64,
    bytes: Vec<u8>,
}

trait Messages {
    fn next(&mut self) -> Result<Option<Message>>;
}
