//! Our side of the comparison with other programs, on rows in a folder.
//!
//! Arguments: a folder, then tasks to run, all by default. Writes there the rows of each task for
//! the peers to read, `ours.json` with the times, and what was found where a peer checks it.
//! `benches/peers/run.py` runs it.

#[path = "peers/trial.rs"]
mod trial;
#[path = "peers/library.rs"]
mod library;
#[path = "peers/rows.rs"]
mod rows;
#[path = "peers/steps.rs"]
mod steps;

use serde_json::{Map, Value};
use std::path::{Path, PathBuf};

type Task = fn(&Path) -> Value;

const TASKS: [(&str, Task); 3] =
    [("library", library::run), ("steps", steps::run), ("rows", rows::run)];

fn main() {
    let mut words = std::env::args().skip(1).filter(|word| !word.starts_with('-'));
    let Some(folder) = words.next().map(PathBuf::from) else {
        println!("name a folder to write to; benches/peers/run.py does");
        return;
    };
    let wanted: Vec<String> = words.collect();
    // The threads are started before anything is timed.
    rayon::join(|| (), || ());
    let mut found = Map::new();
    for (name, task) in TASKS {
        if wanted.is_empty() || wanted.iter().any(|word| word == name) {
            eprintln!("{name}:");
            found.insert(name.to_owned(), task(&folder));
        }
    }
    let text = serde_json::to_string_pretty(&found).expect("numbers");
    std::fs::write(folder.join("ours.json"), text).expect("a folder that can be written");
}
