//! A sensor_msgs/msg/JointState decoded from CDR.
//!
//! Source: OMG CORBA 3.4, part 2, chapter 9.3 (CDR); OMG DDS-RTPS 2.5, chapter 10 (encapsulation);
//! OMG DDS-XTypes 1.3, chapter 7.4 (alignment of version 2).

pub(crate) const MOST_JOINTS: usize = 1_000;

/// One message: a time stamp, and what is known of each joint.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct JointState {
    /// Time of the state as its sender stamped it \[ns\].
    pub(crate) stamp: i64,
    pub(crate) names: Vec<String>,
    pub(crate) position: Vec<f64>,
    pub(crate) velocity: Vec<f64>,
    pub(crate) effort: Vec<f64>,
}

/// Why a message is none.
type Decoded<T> = Result<T, &'static str>;

const SHORT: &str = "it ends before its last value";

impl JointState {
    /// Decodes a message; its own lengths are held against the bytes there are.
    pub(crate) fn decode(bytes: &[u8]) -> Decoded<Self> {
        let mut cdr = Cdr::new(bytes)?;
        let seconds = i64::from(cdr.u32()?.cast_signed());
        let nanoseconds = i64::from(cdr.u32()?);
        // header.frame_id means nothing here.
        cdr.text()?;
        let n = cdr.count(4)?;
        if n > MOST_JOINTS {
            return Err("it names over 1000 joints");
        }
        let names = (0..n).map(|_| Ok(cdr.text()?.to_owned())).collect::<Result<_, _>>()?;
        Ok(Self {
            stamp: seconds * 1_000_000_000 + nanoseconds,
            names,
            position: cdr.numbers(n)?,
            velocity: cdr.numbers(n)?,
            effort: cdr.numbers(n)?,
        })
    }
}

/// Bytes after the encapsulation header, read from the front.
struct Cdr<'a> {
    bytes: &'a [u8],
    at: usize,
    big_endian: bool,
    /// Numbers of eight bytes are aligned to this.
    widest: usize,
}

impl<'a> Cdr<'a> {
    fn new(bytes: &'a [u8]) -> Decoded<Self> {
        let (header, body) = bytes.split_at_checked(4).ok_or(SHORT)?;
        let (big_endian, widest) = match header[..2] {
            [0, 0] => (true, 8),
            [0, 1] => (false, 8),
            [0, 6] => (true, 4),
            [0, 7] => (false, 4),
            _ => return Err("it is not encoded in plain CDR"),
        };
        Ok(Self { bytes: body, at: 0, big_endian, widest })
    }

    fn take(&mut self, length: usize) -> Decoded<&'a [u8]> {
        let end = self.at.checked_add(length).ok_or(SHORT)?;
        let taken = self.bytes.get(self.at..end).ok_or(SHORT)?;
        self.at = end;
        Ok(taken)
    }

    /// The next `N` bytes from a multiple of `align` on, least significant first.
    fn little_endian<const N: usize>(&mut self, align: usize) -> Decoded<[u8; N]> {
        self.at = self.at.next_multiple_of(align);
        let mut number: [u8; N] = self.take(N)?.try_into().map_err(|_| SHORT)?;
        if self.big_endian {
            number.reverse();
        }
        Ok(number)
    }

    fn u32(&mut self) -> Decoded<u32> {
        Ok(u32::from_le_bytes(self.little_endian(4)?))
    }

    /// A number of items that take at least `size` bytes each.
    fn count(&mut self, size: usize) -> Decoded<usize> {
        let count = usize::try_from(self.u32()?).map_err(|_| SHORT)?;
        let left = self.bytes.len().saturating_sub(self.at);
        if count <= left / size { Ok(count) } else { Err(SHORT) }
    }

    fn text(&mut self) -> Decoded<&'a str> {
        let length = self.count(1)?;
        let text = self.take(length)?;
        let text = text.strip_suffix(&[0]).unwrap_or(text);
        std::str::from_utf8(text).map_err(|_| "a joint name is not UTF-8 text")
    }

    /// One for each of `n` joints, or none.
    fn numbers(&mut self, n: usize) -> Decoded<Vec<f64>> {
        let count = self.count(8)?;
        if count != 0 && count != n {
            return Err("it has not one position, velocity and effort for each name");
        }
        let widest = self.widest;
        (0..count).map(|_| Ok(f64::from_le_bytes(self.little_endian(widest)?))).collect()
    }
}

#[cfg(test)]
mod tests;
