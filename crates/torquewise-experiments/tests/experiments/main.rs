//! The experiments as a whole.

mod report;
mod same_seed;

use torquewise_experiments::Settings;

/// Every experiment, none longer than it has to be.
fn smallest(seed: u64) -> Settings {
    Settings {
        seconds: 20.0,
        seeds: 1,
        lengths: vec![20.0],
        arms: vec![("planar-2", 20.0)],
        ..Settings::quick(seed)
    }
}
