//! Plants and controllers beside identities.

mod bristles;
mod plant;
mod tracking;
