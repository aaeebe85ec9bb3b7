//! Files read whole, up to a limit: a device that never ends must not take all memory.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

/// Bytes of a text, or of what is no regular file, at most: 64 MB.
pub const LONGEST_TEXT: u64 = 64 << 20;
/// Bytes of a regular file that is read whole at most: 1 GB.
pub const LONGEST_FILE: u64 = 1 << 30;

/// Reads a file of bytes: at most [`LONGEST_FILE`], or [`LONGEST_TEXT`] of a pipe or device.
///
/// # Errors
/// Those of reading, or [`io::ErrorKind::FileTooLarge`].
pub fn read(file: &Path) -> io::Result<Vec<u8>> {
    let input = File::open(file)?;
    let limit = if input.metadata()?.is_file() { LONGEST_FILE } else { LONGEST_TEXT };
    read_at_most(input, limit)
}

/// Reads a file of UTF-8 text of at most [`LONGEST_TEXT`].
///
/// # Errors
/// Those of reading, [`io::ErrorKind::FileTooLarge`], or [`io::ErrorKind::InvalidData`].
pub fn read_text(file: &Path) -> io::Result<String> {
    let bytes = read_at_most(File::open(file)?, LONGEST_TEXT)?;
    String::from_utf8(bytes)
        .map_err(|_| io::Error::new(io::ErrorKind::InvalidData, "it is not UTF-8 text"))
}

fn read_at_most(input: File, limit: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    input.take(limit + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > limit {
        let reason = format!("it has over {} MB", limit >> 20);
        return Err(io::Error::new(io::ErrorKind::FileTooLarge, reason));
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::{LONGEST_TEXT, read, read_text};
    use std::fs::File;
    use std::io::ErrorKind;

    #[test]
    fn a10_a_file_without_an_end_is_refused() -> std::io::Result<()> {
        let folder = tempfile::tempdir()?;
        let file = folder.path().join("long.toml");
        File::create(&file)?.set_len(LONGEST_TEXT + 1)?;
        let refused = |file: &std::path::Path| read_text(file).err().map(|error| error.kind());
        assert_eq!(refused(&file), Some(ErrorKind::FileTooLarge));
        assert_eq!(read(&file)?.len() as u64, LONGEST_TEXT + 1);
        #[cfg(unix)]
        {
            let link = folder.path().join("link.json");
            std::os::unix::fs::symlink("/dev/zero", &link)?;
            assert_eq!(refused(&link), Some(ErrorKind::FileTooLarge));
            let refused = read(&link).err().map(|error| error.kind());
            assert_eq!(refused, Some(ErrorKind::FileTooLarge));
        }
        std::fs::write(&file, "a = 1\n")?;
        assert_eq!(read_text(&file)?, "a = 1\n");
        Ok(())
    }
}
