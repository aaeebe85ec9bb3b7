//! Arms, motions and noise beside identities and values of another program.

mod identities;
mod motions;
mod noise;
mod oracles;
mod urdf_chain;
