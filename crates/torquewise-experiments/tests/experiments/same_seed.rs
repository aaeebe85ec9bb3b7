//! Two runs of the same settings: the same numbers, but for times.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use crate::smallest;
use serde_json::Value;
use torquewise_experiments::reproduce;

/// All results as JSON, times taken out.
fn without_times(threads: usize) -> Value {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let settings = smallest(3);
    let results = pool.install(|| reproduce(&settings, &|_| {})).unwrap();
    let mut json = serde_json::from_str(&results.to_json().unwrap()).unwrap();
    assert!(remove_seconds(&mut json) > 0, "times are told, and told apart");
    json
}

/// Takes out every `seconds` and counts them.
fn remove_seconds(json: &mut Value) -> usize {
    match json {
        Value::Object(fields) => {
            let own = usize::from(fields.remove("seconds").is_some());
            own + fields.values_mut().map(remove_seconds).sum::<usize>()
        }
        Value::Array(items) => items.iter_mut().map(remove_seconds).sum(),
        _ => 0,
    }
}

#[test]
fn the_same_seed_gives_the_same_results_at_any_number_of_threads() {
    assert_eq!(without_times(1), without_times(3));
}
