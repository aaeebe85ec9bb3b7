//! Claims of a Parquet file checked against its bytes, before its decoder allocates or recurses.
//!
//! Source: Apache Parquet format, parquet.thrift, 2.11; Apache Thrift, compact protocol encoding.

use crate::log_input::Opened;
use crate::{Format, LogError, Result};
use std::io::{self, Read, Seek, SeekFrom};
use std::path::Path;

const MAGIC: &[u8] = b"PAR1";

/// Bytes of the metadata, columns, and column chunks of all row groups at most.
const LONGEST_FOOTER: u64 = 64 << 20;
const MOST_COLUMNS: usize = 10_000;
const MOST_CHUNKS: usize = 500_000;
/// Groups of columns within each other at most.
const DEEPEST_SCHEMA: usize = 64;

/// Bytes of the header of a page that are looked at.
const LONGEST_HEADER: u64 = 1 << 16;
/// Bytes of the largest pages of all columns that are read at most, which are held at once.
pub(crate) const MOST_PAGE_BYTES: u64 = 512 << 20;

/// Fields of the metadata: elements of the schema, and in these the number of children; row groups,
/// and in these chunks.
const SCHEMA: &[i16] = &[2];
const CHILDREN: &[i16] = &[2, 5];
const CHUNKS: &[i16] = &[4, 1];

/// Fields of the header of a page: bytes before and after compression; encoding of values, in both
/// versions; values of a dictionary.
const PLAIN_BYTES: &[i16] = &[2];
const STORED_BYTES: &[i16] = &[3];
const ENCODING: [&[i16]; 2] = [&[5, 2], &[8, 4]];
const DICTIONARY_VALUES: &[i16] = &[7, 1];

/// Encodings of texts whose decoders take the number of lengths on trust.
const OF_TEXTS: [i64; 2] = [6, 7];

/// Makes sure that the metadata at the end of a file can be decoded.
pub(crate) fn check_footer(file: &Path, input: &mut Opened) -> Result<()> {
    let footer = footer(input).map_err(LogError::decode(file, Format::Parquet))?;
    // The decoder says what is wrong with a file that ends otherwise.
    let is_sound = footer.is_none_or(|footer| footer_is_sound(&footer));
    if is_sound { Ok(()) } else { Err(LogError::Damaged { file: file.into() }) }
}

fn footer(input: &mut Opened) -> io::Result<Option<Vec<u8>>> {
    let length = input.seek(SeekFrom::End(0))?;
    let mut end = [0; 8];
    let Some(start_of_end) = length.checked_sub(8) else { return Ok(None) };
    input.seek(SeekFrom::Start(start_of_end))?;
    input.read_exact(&mut end)?;
    let (size, magic) = end.split_at(4);
    let size = size.try_into().map_or(u64::MAX, |size| u64::from(u32::from_le_bytes(size)));
    if magic != MAGIC {
        return Ok(None);
    }
    let start = start_of_end.checked_sub(size).filter(|_| size <= LONGEST_FOOTER);
    let Some(start) = start else { return Ok(Some(Vec::new())) };
    input.seek(SeekFrom::Start(start))?;
    let mut footer = Vec::new();
    input.take(size).read_to_end(&mut footer)?;
    Ok(Some(footer))
}

fn footer_is_sound(footer: &[u8]) -> bool {
    let (mut children, mut n_chunks) = (Vec::new(), 0);
    let whole = walk(footer, &mut |path, found| match (path, found) {
        (SCHEMA, Found::Element) => children.push(0),
        (CHILDREN, Found::Integer(number)) => {
            if let Some(last) = children.last_mut() {
                *last = number;
            }
        }
        (CHUNKS, Found::Element) => n_chunks += 1,
        _ => {}
    });
    whole.is_some() && n_chunks <= MOST_CHUNKS && is_tree(&children)
}

/// Whether numbers of children, each element before its own, make one tree that is not too deep.
fn is_tree(children: &[i64]) -> bool {
    let mut open: Vec<i64> = vec![1];
    for number in children {
        while open.last() == Some(&0) {
            open.pop();
        }
        let Some(left) = open.last_mut() else { return false };
        *left -= 1;
        if !usize::try_from(*number).is_ok_and(|n| n <= MOST_COLUMNS) || open.len() > DEEPEST_SCHEMA
        {
            return false;
        }
        open.push(*number);
    }
    children.len() <= 2 * MOST_COLUMNS && open.iter().all(|left| *left == 0)
}

/// Bytes that the largest page of a column chunk and its dictionary take, from the headers of its
/// pages; none where these cannot be right.
pub(crate) fn page_bytes(input: &mut Opened, start: u64, length: u64) -> io::Result<Option<u64>> {
    let (mut at, end) = (start, start.saturating_add(length));
    let (mut largest, mut dictionary) = (0, 0);
    while at < end {
        let Some(page) = page(input, at, end - at)? else { return Ok(None) };
        if page.is_dictionary {
            dictionary = page.bytes;
        } else {
            largest = largest.max(page.bytes);
        }
        at += page.length;
    }
    Ok(Some(largest + dictionary))
}

struct Page {
    bytes: u64,
    is_dictionary: bool,
    /// With its header, in the file.
    length: u64,
}

fn page(input: &mut Opened, at: u64, left: u64) -> io::Result<Option<Page>> {
    input.seek(SeekFrom::Start(at))?;
    let mut head = Vec::new();
    input.take(LONGEST_HEADER.min(left)).read_to_end(&mut head)?;
    let (mut plain, mut stored, mut values, mut is_text) = (-1, -1, None, false);
    let header = walk(&head, &mut |path, found| {
        let Found::Integer(number) = found else { return };
        match path {
            PLAIN_BYTES => plain = number,
            STORED_BYTES => stored = number,
            DICTIONARY_VALUES => values = Some(number),
            path if ENCODING.contains(&path) => is_text |= OF_TEXTS.contains(&number),
            _ => {}
        }
    });
    let sizes = (header, u64::try_from(plain), u64::try_from(stored));
    let (Some(header), Ok(bytes), Ok(stored)) = sizes else { return Ok(None) };
    // A value of a dictionary takes four bytes at least.
    let fits = values.is_none_or(|values| (0..=plain / 4).contains(&values));
    let length = header as u64 + stored;
    let page = Page { bytes, is_dictionary: values.is_some(), length };
    Ok((fits && !is_text && length <= left).then_some(page))
}

/// Structures and lists within each other that are followed; Parquet itself needs ten.
const DEEPEST: usize = 32;

/// What stands in a structure, at a path of field numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Found {
    /// The next element of a list begins.
    Element,
    Integer(i64),
}

/// Goes through one structure at the front of `bytes` and returns how many bytes it takes; `None`
/// where it is cut, nested too deeply, or claims more elements than bytes can hold.
fn walk(bytes: &[u8], found: &mut dyn FnMut(&[i16], Found)) -> Option<usize> {
    let mut walk = Walk { bytes, at: 0, path: Vec::new(), found };
    walk.structure(DEEPEST)?;
    Some(walk.at)
}

struct Walk<'a> {
    bytes: &'a [u8],
    at: usize,
    /// Fields from the outermost structure to this place; lists add none.
    path: Vec<i16>,
    found: &'a mut dyn FnMut(&[i16], Found),
}

impl Walk<'_> {
    /// - `depth`: how much deeper structures and lists may be nested
    fn structure(&mut self, depth: usize) -> Option<()> {
        let mut field = 0_i16;
        loop {
            let head = self.byte()?;
            if head == 0 {
                return Some(());
            }
            field = match head >> 4 {
                0 => i16::try_from(self.integer()?).ok()?,
                step => field.checked_add(step.into())?,
            };
            self.path.push(field);
            // The kind of a truth in a field is the truth itself.
            if !matches!(head & 0xf, 1 | 2) {
                self.value(head & 0xf, depth)?;
            }
            self.path.pop();
        }
    }

    fn value(&mut self, kind: u8, depth: usize) -> Option<()> {
        let deeper = depth.checked_sub(1);
        match kind {
            1..=3 => self.pass(1),
            4..=6 => {
                let number = self.integer()?;
                (self.found)(&self.path, Found::Integer(number));
                Some(())
            }
            7 => self.pass(8),
            8 => {
                let length = self.count()?;
                self.pass(length)
            }
            9 | 10 => {
                let head = self.byte()?;
                let count = if head >> 4 == 15 { self.count()? } else { usize::from(head >> 4) };
                self.elements(count, &[head & 0xf], deeper?)
            }
            11 => {
                let count = self.count()?;
                let kinds = if count == 0 { 0 } else { self.byte()? };
                self.elements(count, &[kinds >> 4, kinds & 0xf], deeper?)
            }
            12 => self.structure(deeper?),
            13 => self.pass(16),
            _ => None,
        }
    }

    /// Elements take a byte at least.
    fn elements(&mut self, count: usize, kinds: &[u8], depth: usize) -> Option<()> {
        if count > self.bytes.len() - self.at {
            return None;
        }
        for _ in 0..count {
            (self.found)(&self.path, Found::Element);
            for kind in kinds {
                self.value(*kind, depth)?;
            }
        }
        Some(())
    }

    fn byte(&mut self) -> Option<u8> {
        let byte = self.bytes.get(self.at)?;
        self.at += 1;
        Some(*byte)
    }

    fn pass(&mut self, length: usize) -> Option<()> {
        self.at = self.at.checked_add(length).filter(|end| *end <= self.bytes.len())?;
        Some(())
    }

    /// Seven bits a byte, the lowest first.
    fn varint(&mut self) -> Option<u64> {
        let mut number = 0;
        for shift in (0..64).step_by(7) {
            let byte = self.byte()?;
            number |= u64::from(byte & 0x7f) << shift;
            if byte < 0x80 {
                return Some(number);
            }
        }
        None
    }

    fn count(&mut self) -> Option<usize> {
        usize::try_from(self.varint()?).ok()
    }

    /// With the sign in the lowest bit.
    fn integer(&mut self) -> Option<i64> {
        let number = self.varint()?;
        Some((number >> 1).cast_signed() ^ -(number & 1).cast_signed())
    }
}

#[cfg(test)]
mod tests {
    use super::{Found, walk};

    #[test]
    fn claims_beyond_the_bytes_and_depth_are_refused() {
        let mut ignored = |_: &[i16], _: Found| {};
        for bytes in [
            &[][..],
            // A list of 2³¹ − 1 structures, a text of as many bytes, a structure without an end.
            &[0x19, 0xfc, 0xff, 0xff, 0xff, 0xff, 7],
            &[0x18, 0xff, 0xff, 0xff, 0xff, 7],
            &[0x15, 2],
            // A number without an end.
            &[0x15, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 1, 0],
            // An unknown kind.
            &[0x1e, 0],
            &[0x1c; 10_000],
            &[0x19; 10_000],
        ] {
            assert_eq!(walk(bytes, &mut ignored), None, "{bytes:?}");
        }
    }
}
