//! Elements of a MAT file: tag, body and padding, read without going back.
//!
//! Source: MathWorks, MAT-File Format, R2024b, chapter 1 (level 5).

use crate::arrays::numbers::{Element, Kind};
use std::io::{self, Read};

pub(super) const MATRIX: u32 = 14;
pub(super) const COMPRESSED: u32 = 15;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Tag {
    pub(super) kind: u32,
    pub(super) length: u64,
    /// Where its body begins, in bytes from the start of what is read.
    pub(super) start: u64,
    small: Option<[u8; 4]>,
}

/// Elements that follow each other in `left` bytes.
pub(super) struct Elements<'a> {
    input: &'a mut dyn Read,
    at: u64,
    left: u64,
}

impl<'a> Elements<'a> {
    pub(super) fn new(input: &'a mut dyn Read, at: u64) -> Self {
        Self { input, at, left: u64::MAX }
    }

    /// The next tag; `None` where the bytes end before it.
    pub(super) fn next(&mut self) -> io::Result<Option<Tag>> {
        let mut head = Vec::new();
        self.by_ref().take(8).read_to_end(&mut head)?;
        if head.is_empty() {
            return Ok(None);
        }
        let (first, second) = head.split_at_checked(4).ok_or(io::ErrorKind::UnexpectedEof)?;
        let kind = word(first).ok_or(io::ErrorKind::UnexpectedEof)?;
        if kind >> 16 != 0 {
            let length = u64::from(kind >> 16);
            let small = second.try_into().ok().filter(|_| length <= 4);
            let small = small.ok_or_else(|| wrong("a small element is over 4 bytes long"))?;
            let start = self.at - 4;
            return Ok(Some(Tag { kind: kind & 0xffff, length, start, small: Some(small) }));
        }
        let length = u64::from(word(second).ok_or(io::ErrorKind::UnexpectedEof)?);
        Ok(Some(Tag { kind, length, start: self.at, small: None }))
    }

    /// The next tag, where there must be one.
    pub(super) fn require(&mut self) -> io::Result<Tag> {
        self.next()?.ok_or_else(|| io::ErrorKind::UnexpectedEof.into())
    }

    /// The body of the element whose tag was read last, of at most `longest` bytes.
    pub(super) fn body(&mut self, tag: Tag, longest: u64) -> io::Result<Vec<u8>> {
        if tag.length > longest {
            return Err(wrong("an element is longer than it can be"));
        }
        if let Some(small) = tag.small {
            let within = (0..tag.length).zip(small);
            return Ok(within.map(|(_, byte)| byte).collect());
        }
        let mut body = Vec::new();
        // Grows as bytes come, whatever the tag claims.
        self.by_ref().take(tag.length).read_to_end(&mut body)?;
        if (body.len() as u64) < tag.length {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        self.pad(tag)?;
        Ok(body)
    }

    /// The body of the next element, where there must be one.
    pub(super) fn next_body(&mut self, longest: u64) -> io::Result<Vec<u8>> {
        let tag = self.require()?;
        self.body(tag, longest)
    }

    pub(super) fn skip(&mut self, tag: Tag) -> io::Result<()> {
        if tag.small.is_some() { Ok(()) } else { self.within(tag, |_| Ok(())) }
    }

    /// Works on the elements within the one whose tag was read last, and passes over the rest.
    pub(super) fn within(
        &mut self,
        tag: Tag,
        work: impl FnOnce(&mut Elements<'_>) -> io::Result<()>,
    ) -> io::Result<()> {
        if tag.small.is_some() || tag.length > self.left {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        let mut inner = Elements { at: self.at, left: tag.length, input: &mut *self };
        work(&mut inner)?;
        io::copy(&mut inner, &mut io::sink())?;
        if inner.left > 0 {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        self.pad(tag)
    }

    /// Elements that are not compressed begin at multiples of eight bytes; the last may lack its
    /// padding.
    fn pad(&mut self, tag: Tag) -> io::Result<()> {
        let padding = tag.length.next_multiple_of(8) - tag.length;
        let padding = if tag.kind == COMPRESSED { 0 } else { padding };
        io::copy(&mut self.take(padding), &mut io::sink()).map(drop)
    }
}

impl Read for Elements<'_> {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        let n_read = (&mut self.input).take(self.left).read(into)?;
        self.at += n_read as u64;
        self.left -= n_read as u64;
        Ok(n_read)
    }
}

fn word(bytes: &[u8]) -> Option<u32> {
    Some(u32::from_le_bytes(bytes.try_into().ok()?))
}

pub(super) fn wrong(what: &'static str) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, what)
}

/// What an element of this kind holds; `None` for one that holds no numbers.
pub(super) fn held_by(kind: u32) -> Option<Element> {
    let (kind, size) = match kind {
        7 | 9 => (Kind::Float, if kind == 7 { 4 } else { 8 }),
        1 | 3 | 5 => (Kind::Signed, 1 << (kind / 2)),
        2 | 4 | 6 => (Kind::Unsigned, 1 << (kind / 2 - 1)),
        12 => (Kind::Signed, 8),
        13 => (Kind::Unsigned, 8),
        _ => return None,
    };
    Some(Element { kind, size, is_big_endian: false })
}

/// The 32-bit whole numbers in a body; one that is negative counts as 0.
pub(super) fn sizes(body: &[u8]) -> Vec<usize> {
    let (items, _) = body.as_chunks::<4>();
    items.iter().map(|item| usize::try_from(i32::from_le_bytes(*item)).unwrap_or(0)).collect()
}
