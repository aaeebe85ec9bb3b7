//! The command line as its users and their programs see it.

mod terminal;
mod whole_way;
mod json_contract;
mod bad_input;
mod usage;
