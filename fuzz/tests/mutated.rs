//! Every reader on its seeds and on mutations of them, the same each time.

#![expect(clippy::unwrap_used, reason = "a test may panic")]

#[path = "../../crates/torquewise-logs/tests/logs/shared.rs"]
mod shared;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use shared::shared;
use std::fs;
use std::time::{Duration, Instant};
use torquewise_fuzz::reader::{READERS, takes};
use torquewise_fuzz::seeds::seeds;

/// Mutations of each seed.
const CASES: u64 = 400;
/// Longest that a case may take.
const LONGEST: Duration = Duration::from_secs(20);

/// Whether a reader takes bytes, in time and without leaving a file.
fn tried(reader: &str, bytes: &[u8]) -> bool {
    let (folder, begun) = (tempfile::tempdir().unwrap(), Instant::now());
    let is_taken = takes(reader, bytes, folder.path());
    assert!(begun.elapsed() < LONGEST, "{reader}: {:?}", begun.elapsed());
    let own = format!("case.{reader}");
    let left = fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name());
    assert!(left.into_iter().all(|name| name.to_str() == Some(own.as_str())), "{reader}");
    is_taken
}

/// Flips a bit, sets a number at which readers go wrong, leaves out a range or copies one.
fn mutate(bytes: &mut Vec<u8>, random: &mut ChaCha8Rng) {
    let Some(last) = bytes.len().checked_sub(1) else { return };
    let at = random.random_range(0..=last);
    let range = at..(at + random.random_range(1..=64)).min(bytes.len());
    match random.random_range(0..6) {
        0 => bytes[at] ^= 1 << random.random_range(0..8),
        1 => bytes[range].fill(if random.random() { 0xff } else { 0 }),
        2 => bytes[at] = *b"-9e,\n[\"\x7f".get(random.random_range(0..8)).unwrap(),
        3 => drop(bytes.drain(range)),
        4 => {
            let copied = bytes[range].to_vec();
            let to = random.random_range(0..=bytes.len());
            bytes.splice(to..to, copied);
        }
        _ if random.random_range(0..4) == 0 => bytes.truncate(at),
        _ => bytes[at] = random.random(),
    }
}

#[test]
fn every_seed_is_taken_and_no_mutation_does_harm() {
    for (number, reader) in (0..).zip(READERS) {
        let mut random = ChaCha8Rng::seed_from_u64(number);
        let mut refused = 0;
        for seed in seeds(reader).unwrap() {
            assert!(tried(reader, &seed.bytes()), "a seed of {reader} is refused");
            for _ in 0..CASES {
                let mut own = seed.clone();
                for _ in 0..random.random_range(1..=4) {
                    let part = random.random_range(0..own.parts.len());
                    mutate(&mut own.parts[part], &mut random);
                }
                refused += u64::from(!tried(reader, &own.bytes()));
            }
        }
        assert!(refused > CASES / 10, "{reader} takes what is broken");
    }
}

/// Files that once did harm, where they are at hand.
#[test]
fn what_once_did_harm_does_none() {
    let Some(folder) = shared("repro") else { return };
    for file in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
        let bytes = fs::read(&file).unwrap();
        let ending = file.extension().and_then(|ending| ending.to_str()).unwrap_or_default();
        let readers: &[&str] = match ending {
            "json" => &["model"],
            "toml" => &["profile", "dh", "friction"],
            own => &[own],
        };
        for reader in readers {
            assert!(READERS.contains(reader), "{}", file.display());
            tried(reader, &bytes);
        }
    }
}
