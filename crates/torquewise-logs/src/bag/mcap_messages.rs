//! From MCAP bag (.mcap) to topics and messages, one chunk at a time.

use crate::bag::messages::{MAX_BYTES, Message, Messages, Topic};
use crate::error::LogError;
use crate::guarded::guarded;
use mcap::read::ChannelAccumulator;
use mcap::records::{Record, op};
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use mcap::{McapError, McapResult, parse_record};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

/// Bytes before the records of a file.
const MAGIC_BYTES: u64 = 8;
/// Bytes of a chunk before the name of its compression, and of that name at most.
const BEFORE_COMPRESSION: usize = 28;
const LONGEST_COMPRESSION: u32 = 64;

/// All topics of a bag that have messages, with the number of these.
pub(super) fn topics(file: &Path) -> Result<Vec<Topic>, LogError> {
    let mut topics: BTreeMap<String, Topic> = BTreeMap::new();
    let mut messages = McapMessages::open(file, None)?;
    while let Some(message) = messages.next_of_any()? {
        let channel = &message.channel;
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

/// The messages of a topic in the order of the file.
pub(super) struct McapMessages {
    file: PathBuf,
    topic: Option<String>,
    input: BufReader<File>,
    reader: LinearReader,
    channels: ChannelAccumulator<'static>,
    /// Behind the data, where records repeat what was there.
    in_summary: bool,
}

impl McapMessages {
    pub(super) fn open(file: &Path, topic: Option<&str>) -> Result<Self, LogError> {
        let input = File::open(file).map_err(LogError::read(file))?;
        if input.metadata().map_err(LogError::read(file))?.len() == 0 {
            return Err(LogError::Empty { file: file.into() });
        }
        let options = LinearReaderOptions::default()
            .with_record_length_limit(MAX_BYTES)
            .with_validate_chunk_crcs(true);
        let mut input = BufReader::new(input);
        if has_bad_chunk(&mut input).map_err(LogError::read(file))? {
            return Err(LogError::Mcap { file: file.into(), source: Box::new(cut_short()) });
        }
        Ok(Self {
            file: file.into(),
            topic: topic.map(str::to_owned),
            input,
            reader: LinearReader::new_with_options(options.with_emit_chunks(false)),
            channels: ChannelAccumulator::default(),
            in_summary: false,
        })
    }

    fn next_of_any(&mut self) -> Result<Option<mcap::Message<'static>>, LogError> {
        let file = self.file.clone();
        let refused = |source| {
            // What the parser says is drawn for a terminal and speaks of its own code.
            let source = if matches!(source, McapError::Parse(_)) { cut_short() } else { source };
            LogError::Mcap { file: file.clone(), source: Box::new(source) }
        };
        guarded(&file, || Ok(self.next_message()))?.map_err(refused)
    }

    fn next_message(&mut self) -> McapResult<Option<mcap::Message<'static>>> {
        while let Some(event) = self.reader.next_event() {
            let (opcode, data) = match event? {
                LinearReadEvent::ReadRequest(wanted) => {
                    let read = self.input.read(self.reader.insert(wanted))?;
                    self.reader.notify_read(read);
                    continue;
                }
                LinearReadEvent::Record { opcode, data } => (opcode, data),
            };
            let is_known = matches!(opcode, op::SCHEMA | op::CHANNEL | op::MESSAGE);
            if self.in_summary || (!is_known && opcode != op::DATA_END) {
                continue;
            }
            if !has_whole_texts(opcode, data) {
                return Err(cut_short());
            }
            match parse_record(opcode, data)? {
                Record::Schema { header, data } => {
                    self.channels.add_schema(header, Cow::Owned(data.into_owned()))?;
                }
                Record::Channel(channel) => self.channels.add_channel(channel)?,
                Record::Message { header, data } => {
                    let unknown = McapError::UnknownChannel(header.sequence, header.channel_id);
                    let channel = self.channels.get(header.channel_id).ok_or(unknown)?;
                    return Ok(Some(mcap::Message {
                        channel,
                        sequence: header.sequence,
                        log_time: header.log_time,
                        publish_time: header.publish_time,
                        data: Cow::Owned(data.into_owned()),
                    }));
                }
                _ => self.in_summary = true,
            }
        }
        Ok(None)
    }
}

fn cut_short() -> McapError {
    McapError::UnexpectedEof
}

/// Whether the texts of a schema or a channel lie within it: a parser takes the memory that a text
/// claims before it looks for it.
fn has_whole_texts(opcode: u8, data: &[u8]) -> bool {
    let whole = |data: &[u8]| -> Option<()> {
        match opcode {
            op::SCHEMA => {
                let rest = after_text(after_text(data.get(2..)?)?)?;
                after_text(rest).map(drop)
            }
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
        }
    };
    whole(data).is_some()
}

/// What follows a text: four bytes with its length, and so many more.
fn after_text(data: &[u8]) -> Option<&[u8]> {
    let (length, rest) = data.split_first_chunk::<4>()?;
    rest.get(u32::from_le_bytes(*length) as usize..)
}

/// Whether the name of the compression of a chunk claims more than such a name has; from the first
/// byte of the file, to which it returns.
fn has_bad_chunk(input: &mut BufReader<File>) -> io::Result<bool> {
    let size = input.get_ref().metadata()?.len();
    let mut at = MAGIC_BYTES;
    input.seek(SeekFrom::Start(at))?;
    let mut is_bad = false;
    while at + 9 <= size && !is_bad {
        let mut head = [0; 9];
        input.read_exact(&mut head)?;
        let [opcode, length @ ..] = head;
        let end = at.saturating_add(9).saturating_add(u64::from_le_bytes(length));
        // The reader itself tells a record that is cut short.
        if opcode == op::DATA_END || end > size {
            break;
        }
        if opcode == op::CHUNK {
            let mut head = Vec::new();
            input.by_ref().take(BEFORE_COMPRESSION as u64 + 4).read_to_end(&mut head)?;
            let name = head.get(BEFORE_COMPRESSION..).and_then(|name| name.try_into().ok());
            is_bad = name.is_some_and(|name| u32::from_le_bytes(name) > LONGEST_COMPRESSION);
        }
        // Within what is buffered, nothing is read again.
        let here = input.stream_position()?;
        input.seek_relative(end.saturating_sub(here).try_into().unwrap_or(i64::MAX))?;
        at = end;
    }
    input.rewind()?;
    Ok(is_bad)
}

impl Messages for McapMessages {
    fn next(&mut self) -> Result<Option<Message>, LogError> {
        while let Some(message) = self.next_of_any()? {
            if Some(&message.channel.topic) == self.topic.as_ref() {
                let received = i64::try_from(message.log_time).unwrap_or(i64::MAX);
                return Ok(Some(Message { received, bytes: message.data.into_owned() }));
            }
        }
        Ok(None)
    }
}
