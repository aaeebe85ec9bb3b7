//! torquewise-dynamics
