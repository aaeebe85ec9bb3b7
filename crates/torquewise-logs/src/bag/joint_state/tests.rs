//! Messages written byte by byte, whole and cut short.

use super::{JointState, SHORT};

/// A message of joints a and bc at 2 s and 3 ns; the numbers stand as `put` writes them.
fn message(kind: u8, put: impl Fn(u64, usize) -> Vec<u8>, align_to: usize) -> Vec<u8> {
    let mut body: Vec<u8> = Vec::new();
    let align = |body: &mut Vec<u8>, to: usize| body.resize(body.len().next_multiple_of(to), 0xaa);
    let texts = |body: &mut Vec<u8>, text: &[u8]| {
        align(body, 4);
        body.extend(put(text.len() as u64 + 1, 4));
        body.extend(text);
        body.push(0);
    };
    body.extend(put(2, 4));
    body.extend(put(3, 4));
    texts(&mut body, b"base");
    align(&mut body, 4);
    body.extend(put(2, 4));
    texts(&mut body, b"a");
    texts(&mut body, b"bc");
    for values in [&[1.5, -2.5][..], &[], &[0.25, f64::NAN]] {
        align(&mut body, 4);
        body.extend(put(values.len() as u64, 4));
        for value in values {
            align(&mut body, align_to);
            body.extend(put(value.to_bits(), 8));
        }
    }
    [vec![0, kind, 0, 0], body].concat()
}

fn little(number: u64, bytes: usize) -> Vec<u8> {
    number.to_le_bytes()[..bytes].to_vec()
}

fn big(number: u64, bytes: usize) -> Vec<u8> {
    number.to_be_bytes()[8 - bytes..].to_vec()
}

#[test]
fn either_byte_order_and_either_alignment_is_read() {
    for bytes in
        [message(0, big, 8), message(1, little, 8), message(6, big, 4), message(7, little, 4)]
    {
        let state = JointState::decode(&bytes).unwrap();

        assert_eq!((state.stamp, state.names), (2_000_000_003, vec!["a".into(), "bc".into()]));
        assert_eq!((state.position, state.velocity), (vec![1.5, -2.5], vec![]));
        assert_eq!(
            (state.effort[0].to_bits(), state.effort[1].is_nan()),
            (0.25_f64.to_bits(), true)
        );
    }
}

#[test]
fn a_message_cut_short_anywhere_is_refused_and_a_length_beyond_it_before_it_is_allocated() {
    let whole = message(1, little, 8);
    for end in 0..whole.len() {
        assert_eq!(JointState::decode(&whole[..end]), Err(SHORT), "{end}");
    }
    let mut bytes = message(1, little, 8);
    bytes[12..16].copy_from_slice(&u32::MAX.to_le_bytes());

    assert_eq!(JointState::decode(&bytes), Err(SHORT));
    assert_eq!(JointState::decode(&message(3, little, 8)), Err("it is not encoded in plain CDR"));
}
