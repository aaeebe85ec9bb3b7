//! MATLAB files (.mat, version 5); fields of structures are joined to names by dots.

use crate::arrays::array::{Array, LONGEST_NAME, MAX_COLUMNS, Packing};
use crate::arrays::mat_elements::{COMPRESSED, Elements, MATRIX, Tag, held_by, sizes, wrong};
use crate::arrays::numbers::Element;
use crate::{Format, LogError, LogInput, Result};
use flate2::read::ZlibDecoder;
use std::io::{self, BufReader, Read};

/// Structures within structures that are followed.
const DEEPEST: usize = 16;

const CELLS: u8 = 1;

/// Bytes of the names of all fields of a structure at most.
const LONGEST_NAMES: u64 = 1 << 20;

const MOST_PARTS: usize = 1_000_000;

pub(super) fn arrays(file: &LogInput) -> Result<Vec<Array>> {
    let mut walk = Walk::default();
    let walked = walk.file(&mut BufReader::new(file.open_whole()?));
    walked.map_err(LogError::decode(file, Format::Mat))?;
    Ok(walk.arrays)
}

#[derive(Default)]
struct Walk {
    arrays: Vec<Array>,
    n_parts: usize,
    /// Where the element that is inflated begins, within one.
    compressed: Option<u64>,
}

impl Walk {
    fn file(&mut self, input: &mut dyn Read) -> io::Result<()> {
        let mut header = [0; 128];
        input.read_exact(&mut header)?;
        match &header[124..] {
            [0, 1, b'I', b'M'] => {}
            [1, 0, b'M', b'I'] => {
                return Err(wrong("its numbers are big-endian, an encoding that is not read"));
            }
            [0, 2, b'I', b'M'] => {
                return Err(wrong("it is of version 7.3: save it with the option -v7"));
            }
            _ => return Err(wrong("it does not begin as a MAT file of version 5 does")),
        }
        let mut elements = Elements::new(input, 128);
        while let Some(tag) = elements.next()? {
            match tag.kind {
                MATRIX => elements.within(tag, |inner| self.matrix(inner, None, 0))?,
                COMPRESSED => {
                    self.compressed = Some(tag.start);
                    elements.within(tag, |inner| self.inflated(inner))?;
                    self.compressed = None;
                }
                _ => elements.skip(tag)?,
            }
        }
        Ok(())
    }

    fn inflated(&mut self, bytes: &mut dyn Read) -> io::Result<()> {
        let mut plain = ZlibDecoder::new(bytes);
        let mut elements = Elements::new(&mut plain, 0);
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
        self.n_parts += 1;
        if self.n_parts > MOST_PARTS {
            return Err(wrong("it has over 1000000 variables and fields"));
        }
        let Some(tag) = elements.next()? else {
            // An empty part has no body at all.
            return Ok(());
        };
        let flags = elements.body(tag, 16)?;
        let class = *flags.first().ok_or(io::ErrorKind::UnexpectedEof)?;
        let dimensions = sizes(&elements.next_body(LONGEST_NAME as u64)?);
        let own_name = text(elements)?;
        let name = name.unwrap_or(own_name);
        match class {
            2 if depth < DEEPEST => self.structures(elements, &name, &dimensions, depth),
            3 if depth < DEEPEST => {
                text(elements)?;
                self.structures(elements, &name, &dimensions, depth)
            }
            CELLS | 6..=15 => self.numbers(elements, name, &dimensions, class),
            _ => Ok(()),
        }
    }

    fn structures(
        &mut self,
        elements: &mut Elements<'_>,
        name: &str,
        dimensions: &[usize],
        depth: usize,
    ) -> io::Result<()> {
        let length = sizes(&elements.next_body(8)?).first().copied().unwrap_or(0);
        let names = elements.next_body(LONGEST_NAMES)?;
        let fields: Vec<String> = names.chunks(length.max(1)).map(up_to_zero).collect();
        let count = dimensions.iter().fold(1_usize, |count, n| count.saturating_mul(*n));
        let n = if fields.is_empty() { 0 } else { count };
        for k in 1..=n {
            for field in &fields {
                let tag = elements.require()?;
                let place = if n > 1 { format!("({k})") } else { String::new() };
                let name = format!("{name}{place}.{field}");
                if tag.kind != MATRIX {
                    return Err(wrong("a part of a structure is no matrix"));
                }
                elements.within(tag, |inner| self.matrix(inner, Some(name), depth + 1))?;
            }
        }
        Ok(())
    }

    fn numbers(
        &mut self,
        elements: &mut Elements<'_>,
        name: String,
        dimensions: &[usize],
        class: u8,
    ) -> io::Result<()> {
        let (rows, columns) = match dimensions {
            // The workspace of functions has no name.
            [rows, columns] if !name.is_empty() => (*rows, *columns),
            _ => return Ok(()),
        };
        // What it holds is known once its size is found to be that of a signal.
        let mut array = Array {
            name,
            rows,
            columns,
            is_by_column: true,
            start: self.compressed.unwrap_or_default(),
            stored: u64::MAX,
            packing: Packing::Zlib,
            before: 0,
            checksum: None,
            element: Err("an array holds cells, an encoding that is not read"),
        };
        if !array.is_signal() {
            return Ok(());
        }
        if self.arrays.len() >= MAX_COLUMNS {
            return Err(wrong("it has over 10000 arrays of several numbers"));
        }
        let tag = elements.require()?;
        if self.compressed.is_some() {
            array.before = tag.start;
        } else {
            (array.start, array.packing) = (tag.start, Packing::Plain);
        }
        if class != CELLS {
            array.element = element(tag, &array);
        }
        self.arrays.push(array);
        Ok(())
    }
}

/// What the element with this tag holds, as the body of an array.
fn element(tag: Tag, array: &Array) -> Result<Element, &'static str> {
    let element = held_by(tag.kind).ok_or("an array of numbers holds something else")?;
    if array.n_bytes(element) == Some(tag.length) {
        Ok(element)
    } else {
        Err("an array has not as many numbers as its size says")
    }
}

fn text(elements: &mut Elements<'_>) -> io::Result<String> {
    Ok(up_to_zero(&elements.next_body(LONGEST_NAME as u64)?))
}

fn up_to_zero(bytes: &[u8]) -> String {
    let end = bytes.iter().position(|byte| *byte == 0).unwrap_or(bytes.len());
    String::from_utf8_lossy(&bytes[..end]).into_owned()
}
