//! The experiments as a whole.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use serde_json::Value;
use torquewise_paper::{Results, Settings, page, reproduce};

/// Every experiment, none longer than it has to be.
fn smallest(threads: usize) -> Results {
    let settings = Settings {
        seconds: 20.0,
        seeds: 1,
        lengths: vec![20.0],
        arms: vec![("planar-2", 20.0)],
        ..Settings::quick(3)
    };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    pool.install(|| reproduce(&settings, &|_| {})).unwrap()
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
fn the_same_seed_gives_the_same_results_at_any_number_of_threads_and_the_page_shows_them() {
    let (one, three) = (smallest(1), smallest(3));

    let [first, second] = [&one, &three].map(|results| {
        let mut json: Value = serde_json::from_str(&results.to_json().unwrap()).unwrap();
        assert!(remove_seconds(&mut json) > 0, "times are told apart");
        json
    });
    assert_eq!(first, second);
    assert_eq!(one.claims().count(), 10);
    let html = page(&one).unwrap();
    for claim in one.claims() {
        assert!(html.contains(&claim.claim), "{}", claim.claim);
    }
    for figure in one.figures() {
        assert!(!figure.svg().unwrap().contains("NaN"), "{}", figure.name);
        assert!(html.contains(&figure.caption.replace('/', "&#x2f;")), "{}", figure.name);
    }
}
