//! Numbers of stored elements, some at a time.

use std::io::{self, BufReader, Read};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Float,
    Signed,
    Unsigned,
}

/// Of so many bytes: 4 or 8 of a float, 1, 2, 4 or 8 of a whole number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Element {
    pub(super) kind: Kind,
    pub(super) size: usize,
    pub(super) is_big_endian: bool,
}

impl Element {
    fn number(self, stored: &[u8]) -> f64 {
        let highest = if self.is_big_endian { stored.first() } else { stored.last() };
        let is_negative = self.kind == Kind::Signed && highest.is_some_and(|byte| *byte >= 0x80);
        let mut bytes = [if is_negative { 0xff } else { 0 }; 8];
        for (k, byte) in stored.iter().enumerate() {
            bytes[if self.is_big_endian { stored.len() - 1 - k } else { k }] = *byte;
        }
        let [a, b, c, d, ..] = bytes;
        match self.kind {
            Kind::Float if self.size == 4 => f64::from(f32::from_le_bytes([a, b, c, d])),
            Kind::Float => f64::from_le_bytes(bytes),
            Kind::Signed => i64::from_le_bytes(bytes) as f64,
            Kind::Unsigned => u64::from_le_bytes(bytes) as f64,
        }
    }
}

pub(super) struct Numbers {
    input: BufReader<Box<dyn Read + Send>>,
    element: Element,
    stored: Vec<u8>,
}

impl Numbers {
    /// `input` begins at the first element that is wanted.
    pub(super) fn new(input: Box<dyn Read + Send>, element: Element) -> Self {
        Self { input: BufReader::new(input), element, stored: Vec::new() }
    }

    pub(super) fn read(&mut self, into: &mut [f64]) -> io::Result<()> {
        let size = self.element.size;
        self.stored.resize(into.len() * size, 0);
        self.input.read_exact(&mut self.stored)?;
        for (number, stored) in into.iter_mut().zip(self.stored.chunks_exact(size)) {
            *number = self.element.number(stored);
        }
        Ok(())
    }

    /// Goes to the end, where a checksum may be held against what was read.
    pub(super) fn finish(&mut self) -> io::Result<()> {
        io::copy(&mut self.input, &mut io::sink()).map(drop)
    }
}

#[cfg(test)]
mod tests {
    use super::{Element, Kind, Numbers};

    #[test]
    fn numbers_of_any_kind_and_order_are_read() {
        for (kind, is_big_endian, stored, expected) in [
            (Kind::Float, false, 2.5_f64.to_le_bytes().to_vec(), 2.5),
            (Kind::Float, true, 2.5_f64.to_be_bytes().to_vec(), 2.5),
            (Kind::Float, true, (-1.5_f32).to_be_bytes().to_vec(), -1.5),
            (Kind::Signed, false, vec![0xfe], -2.0),
            (Kind::Signed, true, vec![0xff, 0xfe], -2.0),
            (Kind::Signed, false, (-7_i32).to_le_bytes().to_vec(), -7.0),
            (Kind::Signed, true, (-7_i64).to_be_bytes().to_vec(), -7.0),
            (Kind::Unsigned, false, vec![0xfe], 254.0),
            (Kind::Unsigned, true, vec![1, 2], 258.0),
            (Kind::Unsigned, false, u32::MAX.to_le_bytes().to_vec(), 4_294_967_295.0),
            (Kind::Unsigned, true, 9_u64.to_be_bytes().to_vec(), 9.0),
        ] {
            let element = Element { kind, size: stored.len(), is_big_endian };
            let twice = [stored.clone(), stored].concat();
            let mut numbers = Numbers::new(Box::new(std::io::Cursor::new(twice)), element);
            let mut read = [0.0; 2];

            numbers.read(&mut read).expect("two elements");

            assert_eq!(read.map(f64::to_bits), [f64::to_bits(expected); 2], "{kind:?}");
            assert!(numbers.read(&mut read).is_err());
        }
    }
}
