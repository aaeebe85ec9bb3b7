//! Exact sums → their bytes in a file, and back.

use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use torquewise_sparse::exact::ExactSums;

pub(crate) fn serialize<S: Serializer>(sums: &ExactSums, to: S) -> Result<S::Ok, S::Error> {
    (sums.len(), sums.to_bytes()).serialize(to)
}

pub(crate) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<ExactSums, D::Error> {
    let (count, bytes) = <(usize, Vec<u8>)>::deserialize(from)?;
    let sums = ExactSums::from_bytes(&bytes, count);
    sums.ok_or_else(|| D::Error::custom("the sums are not what their number says"))
}
