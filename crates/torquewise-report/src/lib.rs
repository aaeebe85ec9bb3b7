//! torquewise-report
