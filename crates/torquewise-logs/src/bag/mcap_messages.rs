//! MCAP bags (.mcap): topics and messages, one chunk at a time.

use crate::bag::{MAX_BYTES, Message, Messages, Topic};
use crate::log_input::Opened;
use crate::{Format, LogError, LogInput, Result, guarded};
use mcap::read::ChannelAccumulator;
use mcap::records::{Record, op};
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use mcap::{McapError, McapResult, parse_record};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::{BufReader, Cursor, Read};
use std::path::PathBuf;
use std::sync::Arc;

/// A message, and the channel that it came by.
type Received = (Arc<mcap::Channel<'static>>, Message);

/// Bytes of a chunk before the name of its compression.
const BEFORE_COMPRESSION: usize = 28;

/// All topics of a bag that have messages, with the number of these.
pub(super) fn topics(file: &LogInput) -> Result<Vec<Topic>> {
    let mut topics: BTreeMap<String, Topic> = BTreeMap::new();
    let mut messages = McapMessages::open(file, None)?;
    while let Some((channel, _)) = messages.next_of_any()? {
        let topic = topics.entry(channel.topic.clone()).or_insert_with(|| Topic {
            name: channel.topic.clone(),
            kind: channel.schema.as_ref().map(|schema| schema.name.clone()).unwrap_or_default(),
            encoding: channel.message_encoding.clone(),
            n_messages: 0,
        });
        topic.n_messages += 1;
    }
    Ok(topics.into_values().collect())
}

pub(super) struct McapMessages {
    file: PathBuf,
    topic: Option<String>,
    input: BufReader<Opened>,
    reader: LinearReader,
    /// The records that are left of the chunk that is being read.
    chunk: Cursor<Vec<u8>>,
    channels: ChannelAccumulator<'static>,
}

impl McapMessages {
    pub(super) fn open(file: &LogInput, topic: Option<&str>) -> Result<Self> {
        let options = LinearReaderOptions::default()
            .with_record_length_limit(MAX_BYTES)
            .with_emit_chunks(true);
        Ok(Self {
            file: file.into(),
            topic: topic.map(str::to_owned),
            input: BufReader::new(file.open_whole()?),
            reader: LinearReader::new_with_options(options),
            chunk: Cursor::default(),
            channels: ChannelAccumulator::default(),
        })
    }

    fn next_of_any(&mut self) -> Result<Option<Received>> {
        let file = self.file.clone();
        let refused = |source| {
            // What the parser says is drawn for a terminal and speaks of its own code.
            let is_parse = matches!(source, McapError::Parse(_));
            let source = if is_parse { McapError::UnexpectedEof } else { source };
            LogError::decode(&file, Format::Mcap)(source)
        };
        guarded(&file, || Ok(self.next_message()))?.map_err(refused)
    }

    fn next_message(&mut self) -> McapResult<Option<Received>> {
        loop {
            while let Some((opcode, data)) = next_record(&mut self.chunk)? {
                if let Some(message) = read_record(&mut self.channels, opcode, data)? {
                    return Ok(Some(message));
                }
            }
            let Some(event) = self.reader.next_event() else { return Ok(None) };
            match event? {
                LinearReadEvent::ReadRequest(wanted) => {
                    let read = self.input.read(self.reader.insert(wanted))?;
                    self.reader.notify_read(read);
                }
                LinearReadEvent::Record { opcode: op::CHUNK, data } => {
                    self.chunk = Cursor::new(decompressed(data)?);
                }
                LinearReadEvent::Record { opcode, data } => {
                    if let Some(message) = read_record(&mut self.channels, opcode, data)? {
                        return Ok(Some(message));
                    }
                }
            }
        }
    }
}

fn next_record(chunk: &mut Cursor<Vec<u8>>) -> McapResult<Option<(u8, &[u8])>> {
    let at = usize::try_from(chunk.position()).unwrap_or(usize::MAX);
    let record = chunk.get_ref().get(at..).and_then(<[u8]>::split_first);
    let Some((opcode, rest)) = record else { return Ok(None) };
    let (length, rest) = rest.split_first_chunk::<8>().ok_or(McapError::UnexpectedEof)?;
    let end = usize::try_from(u64::from_le_bytes(*length)).ok();
    let end = end.filter(|&end| end <= rest.len()).ok_or(McapError::UnexpectedEof)?;
    let (opcode, from) = (*opcode, at + 9);
    chunk.set_position((from + end) as u64);
    Ok(Some((opcode, &chunk.get_ref()[from..from + end])))
}

/// Remembers a schema or a channel; returns a message; passes over what else a record may be.
fn read_record(
    channels: &mut ChannelAccumulator<'static>,
    opcode: u8,
    data: &[u8],
) -> McapResult<Option<Received>> {
    if !matches!(opcode, op::SCHEMA | op::CHANNEL | op::MESSAGE) {
        return Ok(None);
    }
    match whole_record(opcode, data)? {
        Record::Schema { header, data } => {
            channels.add_schema(header, Cow::Owned(data.into_owned()))?;
        }
        Record::Channel(channel) => channels.add_channel(channel)?,
        Record::Message { header, data } => {
            let unknown = McapError::UnknownChannel(header.sequence, header.channel_id);
            let channel = channels.get(header.channel_id).ok_or(unknown)?;
            let received = i64::try_from(header.log_time).unwrap_or(i64::MAX);
            return Ok(Some((channel, Message { received, bytes: data.into_owned() })));
        }
        _ => {}
    }
    Ok(None)
}

/// The records of a chunk: 128 MB at most, and such as its checksum says.
fn decompressed(data: &[u8]) -> McapResult<Vec<u8>> {
    let Record::Chunk { header, data } = whole_record(op::CHUNK, data)? else {
        return Err(McapError::UnexpectedEof);
    };
    let mut input: Box<dyn Read + '_> = match header.compression.as_str() {
        "" => Box::new(&*data),
        "lz4" => Box::new(lz4_flex::frame::FrameDecoder::new(&*data)),
        "zstd" => Box::new(zstd::Decoder::with_buffer(&*data)?),
        other => return Err(McapError::UnsupportedCompression(other.to_owned())),
    };
    let mut records = Vec::new();
    input.by_ref().take(MAX_BYTES as u64 + 1).read_to_end(&mut records)?;
    if records.len() > MAX_BYTES {
        return Err(McapError::ChunkTooLarge(header.uncompressed_size));
    }
    let calculated = crc32fast::hash(&records);
    match header.uncompressed_crc {
        0 => Ok(records),
        saved if saved == calculated => Ok(records),
        saved => Err(McapError::BadChunkCrc { saved, calculated }),
    }
}

/// A record of which the texts of a chunk, a schema or a channel lie within it: a parser takes the
/// memory that a text claims before it looks for it.
fn whole_record(opcode: u8, data: &[u8]) -> McapResult<Record<'_>> {
    let within = || match opcode {
        op::CHUNK => after_text(data.get(BEFORE_COMPRESSION..)?).map(drop),
        op::SCHEMA => after_text(after_text(after_text(data.get(2..)?)?)?).map(drop),
        op::CHANNEL => {
            let rest = after_text(after_text(data.get(4..)?)?)?;
            let (length, rest) = rest.split_first_chunk::<4>()?;
            let mut pairs = rest.get(..u32::from_le_bytes(*length) as usize)?;
            while !pairs.is_empty() {
                pairs = after_text(pairs)?;
            }
            Some(())
        }
        _ => Some(()),
    };
    within().ok_or(McapError::UnexpectedEof)?;
    parse_record(opcode, data)
}

/// What follows a text: four bytes with its length, and so many more.
fn after_text(data: &[u8]) -> Option<&[u8]> {
    let (length, rest) = data.split_first_chunk::<4>()?;
    rest.get(u32::from_le_bytes(*length) as usize..)
}

impl Messages for McapMessages {
    fn next(&mut self) -> Result<Option<Message>> {
        while let Some((channel, message)) = self.next_of_any()? {
            if Some(&channel.topic) == self.topic.as_ref() {
                return Ok(Some(message));
            }
        }
        Ok(None)
    }
}
