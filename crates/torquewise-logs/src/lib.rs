//! torquewise-logs
