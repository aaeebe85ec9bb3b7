//! Files of every format → recordings, and bad ones → errors that say where.

mod arrays;
mod bags;
mod hostile_parquet;
mod made_bags;
mod made_mats;
mod oracle;
mod profiles;
mod real_robots;
mod recording;
mod round_trip;
