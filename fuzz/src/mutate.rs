//! From seed to something like it: bits, bytes, numbers that tip scales, pieces moved and left out.

use crate::seeds::Seed;
use rand::{Rng, RngExt};

/// Numbers at which readers go wrong.
const TIPPING: [u64; 16] = [
    0,
    1,
    0x7f,
    0x80,
    0xff,
    0x7fff,
    0x8000,
    0xffff,
    0x00ff_ffff,
    0x7fff_ffff,
    0x8000_0000,
    0xffff_ffff,
    0x7fff_ffff_ffff_ffff,
    0x8000_0000_0000_0000,
    0xffff_ffff_ffff_ffff,
    0x7ff0_0000_0000_0000,
];

/// Words of the text formats.
const WORDS: [&[u8]; 20] = [
    b"-1",
    b"1e308",
    b"-1e309",
    b"nan",
    b"inf",
    b"255",
    b"18446744073709551616",
    b"null",
    b"[]",
    b"{}",
    b"\"\"",
    b"[[",
    b"]]",
    b"=",
    b",",
    b"\n",
    b"<link>",
    b"&lt;",
    b"\xff\xfe",
    b"\x1b[31m",
];

/// A file that differs from a seed in one to eight places.
pub fn mutated(seed: &Seed, random: &mut impl Rng) -> Vec<u8> {
    let mut own = seed.clone();
    for _ in 0..random.random_range(1..=8) {
        match &mut own {
            Seed::Whole(bytes) => change(bytes, random),
            Seed::Zip(members) => {
                let place = random.random_range(0..members.len());
                change(&mut members[place].1, random);
            }
            Seed::Framed(bytes) => {
                let mut body = bytes.split_off(bytes.len().min(24));
                change(&mut body, random);
                bytes.extend(body);
            }
            Seed::Mat(_, elements) => {
                let place = random.random_range(0..elements.len());
                change(&mut elements[place], random);
            }
        }
    }
    let mut bytes = own.bytes();
    if random.random_range(0..20) == 0 {
        bytes.truncate(random.random_range(0..=bytes.len()));
    }
    bytes
}

fn change(bytes: &mut Vec<u8>, random: &mut impl Rng) {
    if bytes.is_empty() {
        bytes.push(random.random());
        return;
    }
    let at = random.random_range(0..bytes.len());
    let piece = |random: &mut dyn Rng| at..(at + random.random_range(1..=64)).min(bytes.len());
    match random.random_range(0..8) {
        0 => bytes[at] ^= 1 << random.random_range(0..8),
        1 => bytes[at] = random.random(),
        2 | 3 => {
            let number = TIPPING[random.random_range(0..TIPPING.len())].to_le_bytes();
            let width = [1, 2, 4, 8][random.random_range(0..4)].min(bytes.len() - at);
            bytes[at..at + width].copy_from_slice(&number[..width]);
        }
        4 => {
            let range = piece(random);
            bytes.drain(range);
        }
        5 => {
            let copied = bytes[piece(random)].to_vec();
            let to = random.random_range(0..=bytes.len());
            bytes.splice(to..to, copied);
        }
        6 => {
            let word = WORDS[random.random_range(0..WORDS.len())];
            let end = (at + random.random_range(0..=word.len())).min(bytes.len());
            bytes.splice(at..end, word.iter().copied());
        }
        // As long as files get in a few doublings.
        _ if bytes.len() < 1 << 16 => {
            let copied = bytes[piece(random)].repeat(random.random_range(1..=32));
            bytes.splice(at..at, copied);
        }
        _ => bytes[at] = 0,
    }
}
