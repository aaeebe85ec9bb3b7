//! Plants and controllers beside identities.

mod plant;
mod tracking;
