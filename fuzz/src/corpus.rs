//! Writes the seeds of all readers where `cargo fuzz run readers` looks for them.

use anyhow::Result;
use std::fs;
use std::path::Path;
use torquewise_fuzz::reader::READERS;
use torquewise_fuzz::seeds::seeds;

fn main() -> Result<()> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus/readers");
    fs::create_dir_all(&folder)?;
    for (number, reader) in (0_u8..).zip(READERS) {
        for (place, seed) in seeds(reader)?.iter().enumerate() {
            let input = [vec![number], seed.bytes()].concat();
            fs::write(folder.join(format!("{reader}-{place}")), input)?;
        }
    }
    println!("{}", folder.display());
    Ok(())
}
