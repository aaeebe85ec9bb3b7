//! torquewise-model
