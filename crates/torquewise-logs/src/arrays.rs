//! From file of named arrays to rows: each array read as columns, time along its longer side.

mod numbers;
mod array;
mod npz;
mod mat_elements;
mod mat;
mod rows;

pub(crate) use rows::ArrayRows;
