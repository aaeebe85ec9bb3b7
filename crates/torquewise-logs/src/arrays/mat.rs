//! From MATLAB file (.mat, version 5) to arrays; fields of structures are joined to names by dots.

use crate::arrays::array::{Array, Arrays, MAX_BYTES, Order};
use crate::arrays::mat_elements::{COMPRESSED, Elements, MATRIX, Tag, numbers, sizes, wrong};
use crate::error::LogError;
use flate2::read::ZlibDecoder;
use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::{self, BufReader, Read};
use std::path::{Path, PathBuf};

/// Structures within structures that are followed.
const DEEPEST: usize = 16;

/// Bytes of a name, and of the names of all fields, at most.
const LONGEST_NAME: u64 = 4_096;
const LONGEST_NAMES: u64 = 1 << 20;

/// Arrays of a file at most.
const MOST_ARRAYS: usize = 100_000;

/// A file and the shapes of its arrays.
pub(super) struct Mat {
    file: PathBuf,
    arrays: Vec<Array>,
}

impl Mat {
    /// Goes through the file for names and shapes.
    pub(super) fn open(file: &Path) -> Result<Self, LogError> {
        let none = BTreeSet::new();
        let arrays = Walk::through(file, &none)?.arrays;
        Ok(Self { file: file.into(), arrays })
    }
}

impl Arrays for Mat {
    fn arrays(&self) -> &[Array] {
        &self.arrays
    }

    fn load(&self, wanted: &BTreeSet<usize>) -> Result<BTreeMap<usize, Vec<f64>>, LogError> {
        let found = Walk::through(&self.file, wanted)?;
        if found.arrays != self.arrays {
            return Err(LogError::Changed { file: self.file.clone() });
        }
        Ok(found.loaded)
    }
}

/// What was found so far.
struct Walk<'a> {
    wanted: &'a BTreeSet<usize>,
    arrays: Vec<Array>,
    loaded: BTreeMap<usize, Vec<f64>>,
}

impl<'a> Walk<'a> {
    fn through(file: &Path, wanted: &'a BTreeSet<usize>) -> Result<Self, LogError> {
        let input = File::open(file).map_err(LogError::read(file))?;
        if input.metadata().map_err(LogError::read(file))?.len() == 0 {
            return Err(LogError::Empty { file: file.into() });
        }
        let mut walk = Self { wanted, arrays: Vec::new(), loaded: BTreeMap::new() };
        let walked = walk.file(&mut BufReader::new(input));
        walked.map_err(|source| LogError::Mat { file: file.into(), source })?;
        Ok(walk)
    }

    fn file(&mut self, input: &mut dyn Read) -> io::Result<()> {
        let mut header = [0; 128];
        input.read_exact(&mut header)?;
        let is_big_endian = match &header[124..] {
            [0, 1, b'I', b'M'] => false,
            [1, 0, b'M', b'I'] => true,
            [0, 2, b'I', b'M'] => {
                return Err(wrong("it is of version 7.3: save it with the option -v7"));
            }
            _ => return Err(wrong("it does not begin as a MAT file of version 5 does")),
        };
        let mut elements = Elements::new(input, u64::MAX, is_big_endian);
        while let Some(tag) = elements.next()? {
            match tag.kind {
                MATRIX => elements.within(tag, |inner| self.matrix(inner, None, 0))?,
                COMPRESSED => {
                    elements.bytes_within(tag, |bytes| self.compressed(bytes, is_big_endian))?;
                }
                _ => elements.skip(tag)?,
            }
        }
        Ok(())
    }

    fn compressed(&mut self, bytes: &mut dyn Read, is_big_endian: bool) -> io::Result<()> {
        let mut plain = ZlibDecoder::new(bytes);
        let mut elements = Elements::new(&mut plain, u64::MAX, is_big_endian);
        let tag = elements.require()?;
        if tag.kind == MATRIX {
            elements.within(tag, |inner| self.matrix(inner, None, 0))?;
        }
        // The checksum stands at the end.
        io::copy(&mut plain, &mut io::sink())?;
        Ok(())
    }

    /// A variable, or a part of one, which is called `name`.
    fn matrix(
        &mut self,
        elements: &mut Elements<'_>,
        name: Option<String>,
        depth: usize,
    ) -> io::Result<()> {
        let Some(tag) = elements.next()? else {
            // An empty part has no body at all.
            return Ok(());
        };
        let flags = elements.body(tag, 16)?;
        let is_big_endian = elements.is_big_endian();
        let class = if is_big_endian { flags.get(3) } else { flags.first() };
        let class = *class.ok_or(io::ErrorKind::UnexpectedEof)?;
        let tag = elements.require()?;
        let dimensions = elements.body(tag, LONGEST_NAME)?;
        let dimensions = sizes(&dimensions, is_big_endian);
        let own_name = text(elements, LONGEST_NAME)?;
        let name = name.unwrap_or(own_name);
        match class {
            1 if depth < DEEPEST => self.cells(elements, &name, &dimensions, depth),
            2 if depth < DEEPEST => self.structures(elements, &name, &dimensions, depth),
            3 if depth < DEEPEST => {
                text(elements, LONGEST_NAME)?;
                self.structures(elements, &name, &dimensions, depth)
            }
            6..=15 => self.numbers(elements, name, &dimensions),
            _ => Ok(()),
        }
    }

    fn cells(
        &mut self,
        elements: &mut Elements<'_>,
        name: &str,
        dimensions: &[usize],
        depth: usize,
    ) -> io::Result<()> {
        for k in 1..=count(dimensions) {
            let tag = elements.require()?;
            self.part(elements, tag, format!("{name}{{{k}}}"), depth)?;
        }
        Ok(())
    }

    fn structures(
        &mut self,
        elements: &mut Elements<'_>,
        name: &str,
        dimensions: &[usize],
        depth: usize,
    ) -> io::Result<()> {
        let tag = elements.require()?;
        let length = elements.body(tag, 8)?;
        let length = sizes(&length, elements.is_big_endian()).first().copied().unwrap_or(0);
        let tag = elements.require()?;
        let names = elements.body(tag, LONGEST_NAMES)?;
        let fields: Vec<String> = names.chunks(length.max(1)).map(up_to_zero).collect();
        let n = if fields.is_empty() { 0 } else { count(dimensions) };
        for k in 1..=n {
            for field in &fields {
                let tag = elements.require()?;
                let place = if n > 1 { format!("({k})") } else { String::new() };
                self.part(elements, tag, format!("{name}{place}.{field}"), depth)?;
            }
        }
        Ok(())
    }

    fn part(
        &mut self,
        elements: &mut Elements<'_>,
        tag: Tag,
        name: String,
        depth: usize,
    ) -> io::Result<()> {
        if tag.kind != MATRIX {
            return Err(wrong("a part of a structure is no matrix"));
        }
        elements.within(tag, |inner| self.matrix(inner, Some(name), depth + 1))
    }

    fn numbers(
        &mut self,
        elements: &mut Elements<'_>,
        name: String,
        dimensions: &[usize],
    ) -> io::Result<()> {
        if self.arrays.len() >= MOST_ARRAYS {
            return Err(wrong("it has over 100000 arrays"));
        }
        let (rows, columns) = match dimensions {
            // The workspace of functions has no name.
            [rows, columns] if !name.is_empty() => (*rows, *columns),
            _ => (0, 0),
        };
        let place = self.arrays.len();
        self.arrays.push(Array { name, rows, columns, order: Order::ByColumn });
        if !self.wanted.contains(&place) {
            return Ok(());
        }
        let tag = elements.require()?;
        let body = elements.body(tag, MAX_BYTES)?;
        let values = numbers(tag.kind, &body, elements.is_big_endian())
            .ok_or_else(|| wrong("an array of numbers holds something else"))?;
        if Some(values.len()) != rows.checked_mul(columns) {
            return Err(wrong("an array has not as many numbers as its size says"));
        }
        self.loaded.insert(place, values);
        Ok(())
    }
}

/// Elements of an array with these dimensions.
fn count(dimensions: &[usize]) -> usize {
    dimensions.iter().fold(1, |count, n| count.saturating_mul(*n))
}

fn text(elements: &mut Elements<'_>, longest: u64) -> io::Result<String> {
    let tag = elements.require()?;
    Ok(up_to_zero(&elements.body(tag, longest)?))
}

fn up_to_zero(bytes: &[u8]) -> String {
    let end = bytes.iter().position(|byte| *byte == 0).unwrap_or(bytes.len());
    String::from_utf8_lossy(&bytes[..end]).into_owned()
}
