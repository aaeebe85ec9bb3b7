//! torquewise-sparse
