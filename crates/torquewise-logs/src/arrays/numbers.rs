//! Numbers of stored elements, some at a time.

use std::io::{self, BufReader, Read};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    F4,
    F8,
    I1,
    I2,
    I4,
    I8,
    U1,
    U2,
    U4,
    U8,
}

/// The same with its byte order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Element {
    pub(super) kind: Kind,
    pub(super) is_big_endian: bool,
}

impl Element {
    pub(super) fn size(self) -> usize {
        match self.kind {
            Kind::I1 | Kind::U1 => 1,
            Kind::I2 | Kind::U2 => 2,
            Kind::F4 | Kind::I4 | Kind::U4 => 4,
            Kind::F8 | Kind::I8 | Kind::U8 => 8,
        }
    }

    fn number(self, stored: &[u8]) -> f64 {
        let mut bytes = [0; 8];
        for (k, byte) in stored.iter().enumerate() {
            bytes[if self.is_big_endian { stored.len() - 1 - k } else { k }] = *byte;
        }
        let [a, b, c, d, ..] = bytes;
        match self.kind {
            Kind::F4 => f64::from(f32::from_le_bytes([a, b, c, d])),
            Kind::F8 => f64::from_le_bytes(bytes),
            Kind::I1 => f64::from(a.cast_signed()),
            Kind::I2 => f64::from(i16::from_le_bytes([a, b])),
            Kind::I4 => f64::from(i32::from_le_bytes([a, b, c, d])),
            Kind::I8 => i64::from_le_bytes(bytes) as f64,
            // Without a sign, the bytes beyond are zero.
            Kind::U1 | Kind::U2 | Kind::U4 | Kind::U8 => u64::from_le_bytes(bytes) as f64,
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
        let size = self.element.size();
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
            (Kind::F8, false, 2.5_f64.to_le_bytes().to_vec(), 2.5),
            (Kind::F8, true, 2.5_f64.to_be_bytes().to_vec(), 2.5),
            (Kind::F4, true, (-1.5_f32).to_be_bytes().to_vec(), -1.5),
            (Kind::I1, false, vec![0xfe], -2.0),
            (Kind::I2, true, vec![0xff, 0xfe], -2.0),
            (Kind::I4, false, (-7_i32).to_le_bytes().to_vec(), -7.0),
            (Kind::I8, true, (-7_i64).to_be_bytes().to_vec(), -7.0),
            (Kind::U1, false, vec![0xfe], 254.0),
            (Kind::U2, true, vec![1, 2], 258.0),
            (Kind::U4, false, u32::MAX.to_le_bytes().to_vec(), 4_294_967_295.0),
            (Kind::U8, true, 9_u64.to_be_bytes().to_vec(), 9.0),
        ] {
            let twice = [stored.clone(), stored].concat();
            let element = Element { kind, is_big_endian };
            let mut numbers = Numbers::new(Box::new(std::io::Cursor::new(twice)), element);
            let mut read = [0.0; 2];

            numbers.read(&mut read).expect("two elements");

            assert!(
                read.iter().all(|number| number.to_bits() == f64::to_bits(expected)),
                "{kind:?}"
            );
            assert!(numbers.read(&mut read).is_err());
        }
    }
}
