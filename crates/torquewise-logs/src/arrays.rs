//! Rows of files of named arrays, time along the longer side.

mod numbers;
mod array;
mod npz;
mod mat_elements;
mod mat;
mod rows;

pub(crate) use rows::ArrayRows;
