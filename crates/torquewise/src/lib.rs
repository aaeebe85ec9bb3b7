//! torquewise
