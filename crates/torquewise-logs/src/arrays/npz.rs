//! From NumPy archive (.npz) to arrays, one at a time.

use crate::arrays::array::{Array, Arrays, MAX_BYTES, Order};
use crate::arrays::npy::{self, Header};
use crate::error::LogError;
use crate::guarded::guarded;
use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::{BufReader, Read};
use std::path::{Path, PathBuf};
use zip::ZipArchive;
use zip::result::ZipError;

/// Bytes of a header that are looked at.
const MAX_HEADER: u64 = 1 << 16;

/// An archive and what its headers say.
pub(super) struct Npz {
    file: PathBuf,
    arrays: Vec<Array>,
    /// For each array, its place in the archive.
    places: Vec<usize>,
}

impl Npz {
    /// Reads the headers of all arrays.
    pub(super) fn open(file: &Path) -> Result<Self, LogError> {
        let mut archive = archive(file)?;
        let mut npz = Self { file: file.into(), arrays: Vec::new(), places: Vec::new() };
        for place in 0..archive.len() {
            let mut head = Vec::new();
            let name = guarded(file, || {
                let entry = archive.by_index(place).map_err(LogError::npz(file))?;
                let name = entry.name().to_owned();
                entry.take(MAX_HEADER).read_to_end(&mut head).map_err(LogError::damaged(file))?;
                Ok(name)
            })?;
            let name = name.strip_suffix(".npy").unwrap_or(&name);
            if let Some(header) = guarded(file, || npy::header(file, name, &head))? {
                npz.arrays.push(array(name, &header));
                npz.places.push(place);
            }
        }
        Ok(npz)
    }
}

impl Arrays for Npz {
    fn arrays(&self) -> &[Array] {
        &self.arrays
    }

    fn load(&self, wanted: &BTreeSet<usize>) -> Result<BTreeMap<usize, Vec<f64>>, LogError> {
        let file = &self.file;
        let mut archive = archive(file)?;
        let mut loaded = BTreeMap::new();
        for k in wanted {
            let (Some(array), Some(place)) = (self.arrays.get(*k), self.places.get(*k)) else {
                continue;
            };
            let values = guarded(file, || {
                let mut bytes = Vec::new();
                let entry = archive.by_index(*place).map_err(LogError::npz(file))?;
                entry.take(MAX_BYTES).read_to_end(&mut bytes).map_err(LogError::damaged(file))?;
                npy::values(file, &array.name, &bytes)
            })?;
            if Some(values.len()) != array.rows.checked_mul(array.columns) {
                return Err(LogError::Changed { file: file.clone() });
            }
            loaded.insert(*k, values);
        }
        Ok(loaded)
    }
}

fn archive(file: &Path) -> Result<ZipArchive<BufReader<File>>, LogError> {
    let input = File::open(file).map_err(LogError::read(file))?;
    if input.metadata().map_err(LogError::read(file))?.len() == 0 {
        return Err(LogError::Empty { file: file.into() });
    }
    guarded(file, || {
        ZipArchive::new(BufReader::new(input))
            .map_err(|source: ZipError| LogError::npz(file)(source))
    })
}

/// An array as its header describes it; a vector counts as one column.
fn array(name: &str, header: &Header) -> Array {
    let (rows, columns) = match header.shape.as_slice() {
        [rows] => (*rows, 1),
        [rows, columns] => (*rows, *columns),
        _ => (0, 0),
    };
    let order = if header.is_fortran { Order::ByColumn } else { Order::ByRow };
    Array { name: name.to_owned(), rows, columns, order }
}
