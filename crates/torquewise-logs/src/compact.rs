//! From bytes in Thrift's compact protocol to lists and whole numbers in them, nothing kept.
//!
//! Source: Apache Thrift, compact protocol encoding, as Parquet uses it for footers and pages.

/// Structures and lists within each other that are followed; Parquet itself needs ten.
const DEEPEST: usize = 32;

/// What stands in a structure, at a path of field numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Found {
    /// The next element of a list begins.
    Element,
    /// A whole number.
    Integer(i64),
}

/// Goes through one structure at the front of `bytes` and returns how many bytes it takes; `None`
/// where it is cut, nested too deeply, or claims more elements than bytes can hold.
pub(crate) fn walk(bytes: &[u8], found: &mut dyn FnMut(&[i16], Found)) -> Option<usize> {
    let mut walk = Walk { bytes, at: 0, path: Vec::new(), depth: 0, found };
    walk.structure()?;
    Some(walk.at)
}

struct Walk<'a> {
    bytes: &'a [u8],
    at: usize,
    /// Fields from the outermost structure to this place; lists add none.
    path: Vec<i16>,
    depth: usize,
    found: &'a mut dyn FnMut(&[i16], Found),
}

impl Walk<'_> {
    /// Works on what stands one level deeper.
    fn deeper(&mut self, work: impl FnOnce(&mut Self) -> Option<()>) -> Option<()> {
        if self.depth == DEEPEST {
            return None;
        }
        self.depth += 1;
        work(self)?;
        self.depth -= 1;
        Some(())
    }

    fn structure(&mut self) -> Option<()> {
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
                self.value(head & 0xf)?;
            }
            self.path.pop();
        }
    }

    fn value(&mut self, kind: u8) -> Option<()> {
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
            9 | 10 => self.deeper(Self::list),
            11 => self.deeper(Self::map),
            12 => self.deeper(Self::structure),
            13 => self.pass(16),
            _ => None,
        }
    }

    fn list(&mut self) -> Option<()> {
        let head = self.byte()?;
        let count = if head >> 4 == 15 { self.count()? } else { usize::from(head >> 4) };
        self.elements(count, &[head & 0xf])
    }

    fn map(&mut self) -> Option<()> {
        let count = self.count()?;
        if count == 0 {
            return Some(());
        }
        let kinds = self.byte()?;
        self.elements(count, &[kinds >> 4, kinds & 0xf])
    }

    /// Elements take a byte at least.
    fn elements(&mut self, count: usize, kinds: &[u8]) -> Option<()> {
        if count > self.bytes.len() - self.at {
            return None;
        }
        for _ in 0..count {
            (self.found)(&self.path, Found::Element);
            for kind in kinds {
                self.value(*kind)?;
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
    fn numbers_and_elements_are_found_at_their_paths() {
        // 1: i32 -2; 2: list of two structures {1: i64 300}; 3: text of two bytes; 18: true; end.
        let bytes =
            [0x15, 3, 0x19, 0x2c, 0x16, 0xd8, 4, 0, 0x16, 2, 0, 0x18, 2, 65, 66, 0xf1, 0, 9];
        let mut found = Vec::new();
        let length = walk(&bytes, &mut |path, what| found.push((path.to_vec(), what)));

        assert_eq!(length, Some(17));
        let number = |path: &[i16], number| (path.to_vec(), Found::Integer(number));
        let element = (vec![2], Found::Element);
        let expected =
            [number(&[1], -2), element.clone(), number(&[2, 1], 300), element, number(&[2, 1], 1)];
        assert_eq!(found, expected);
    }

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
