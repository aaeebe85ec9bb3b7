//! Bags made for tests: messages byte by byte, files by the libraries that define the formats.
#![expect(clippy::unwrap_used, reason = "a test stops where its ground gives way")]

use mcap::WriteOptions;
use mcap::records::MessageHeader;
use rusqlite::Connection;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufWriter;
use std::path::Path;

pub(crate) const KIND: &str = "sensor_msgs/msg/JointState";

#[derive(Clone, Debug, Default)]
pub(crate) struct Made {
    pub(crate) topic: &'static str,
    /// When the bag received it \[ns\].
    pub(crate) received: i64,
    pub(crate) bytes: Vec<u8>,
}

/// A joint state in little-endian CDR; the stamp is in nanoseconds.
pub(crate) fn joint_state(stamp: i64, names: &[&str], signals: [&[f64]; 3]) -> Vec<u8> {
    let mut body = Vec::new();
    let align = |body: &mut Vec<u8>, to: usize| body.resize(body.len().next_multiple_of(to), 0);
    let word = |body: &mut Vec<u8>, number: usize| {
        align(body, 4);
        body.extend(u32::try_from(number).unwrap().to_le_bytes());
    };
    let text = |body: &mut Vec<u8>, text: &str| {
        word(body, text.len() + 1);
        body.extend(text.bytes().chain([0]));
    };
    word(&mut body, usize::try_from(stamp / 1_000_000_000).unwrap());
    word(&mut body, usize::try_from(stamp % 1_000_000_000).unwrap());
    text(&mut body, "");
    word(&mut body, names.len());
    for name in names {
        text(&mut body, name);
    }
    for values in signals {
        word(&mut body, values.len());
        for value in values {
            align(&mut body, 8);
            body.extend(value.to_le_bytes());
        }
    }
    [vec![0, 1, 0, 0], body].concat()
}

/// Writes a bag in the format that the extension names; topics with their types.
pub(crate) fn write(file: &Path, topics: &[(&str, &str)], messages: &[Made]) {
    match file.extension().and_then(|extension| extension.to_str()) {
        Some("db3") => write_db3(file, topics, messages),
        _ => write_mcap(file, topics, messages, WriteOptions::default()),
    }
}

fn write_db3(file: &Path, topics: &[(&str, &str)], messages: &[Made]) {
    let bag = Connection::open(file).unwrap();
    bag.execute_batch(include_str!("bag.sql")).unwrap();
    for (name, kind) in topics {
        let insert = "INSERT INTO topics(name, type, serialization_format, offered_qos_profiles)
            VALUES (?1, ?2, 'cdr', '')";
        bag.execute(insert, [name, kind]).unwrap();
    }
    for made in messages {
        let insert = "INSERT INTO messages(topic_id, timestamp, data)
            VALUES ((SELECT id FROM topics WHERE name = ?1), ?2, ?3)";
        bag.execute(insert, (made.topic, made.received, &made.bytes)).unwrap();
    }
    bag.execute_batch("COMMIT").unwrap();
}

/// Writes an MCAP file with the compression and the chunks of `options`.
pub(crate) fn write_mcap(
    file: &Path,
    topics: &[(&str, &str)],
    messages: &[Made],
    options: WriteOptions,
) {
    let output = BufWriter::new(File::create(file).unwrap());
    let mut bag = options.profile("ros2").create(output).unwrap();
    let mut channels = BTreeMap::new();
    for (name, kind) in topics {
        let schema = bag.add_schema(kind, "ros2msg", b"").unwrap();
        let channel = bag.add_channel(schema, name, "cdr", &BTreeMap::new()).unwrap();
        channels.insert(*name, channel);
    }
    for (made, sequence) in messages.iter().zip(0..) {
        let (channel_id, log_time) = (channels[made.topic], made.received.try_into().unwrap());
        let header = MessageHeader { channel_id, sequence, log_time, publish_time: log_time };
        bag.write_to_known_channel(&header, &made.bytes).unwrap();
    }
    bag.finish().unwrap();
}
