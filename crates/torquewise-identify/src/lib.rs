//! torquewise-identify
