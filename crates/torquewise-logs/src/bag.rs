//! From bag of ROS 2 to rows of its joint states: time, and position, velocity and effort by joint
//! name.

mod joint_state;
mod messages;
mod db3_messages;
mod mcap_messages;
mod aligned;
mod in_order;
mod survey;
mod rows;

pub(crate) use rows::BagRows;
pub(crate) use survey::Survey;
