//! Puts the page of `web/` into the program: the files of the folder that `TORQUEWISE_PAGE` names,
//! compressed; none without it.

use flate2::Compression;
use flate2::write::GzEncoder;
use std::error::Error;
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::{env, fs};

fn main() -> Result<(), Box<dyn Error>> {
    println!("cargo:rerun-if-env-changed=TORQUEWISE_PAGE");
    let out = PathBuf::from(env::var_os("OUT_DIR").ok_or("no OUT_DIR")?);
    let mut list = String::from("&[");
    if let Some(folder) = env::var_os("TORQUEWISE_PAGE").filter(|folder| !folder.is_empty()) {
        let folder = Path::new(&folder);
        println!("cargo:rerun-if-changed={}", folder.display());
        let no = |error| format!("TORQUEWISE_PAGE, {}: {error}", folder.display());
        let mut files =
            fs::read_dir(folder).and_then(Iterator::collect::<Result<Vec<_>, _>>).map_err(no)?;
        files.sort_by_key(fs::DirEntry::file_name);
        for file in files {
            let name = file.file_name().to_string_lossy().into_owned();
            let mut packed = GzEncoder::new(Vec::new(), Compression::best());
            packed.write_all(&fs::read(file.path())?)?;
            fs::write(out.join(&name), packed.finish()?)?;
            write!(list, "({name:?}, include_bytes!({name:?})),")?;
        }
    }
    Ok(fs::write(out.join("page.rs"), list + "]")?)
}
