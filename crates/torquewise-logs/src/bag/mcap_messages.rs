//! From MCAP bag (.mcap) to topics and messages, one chunk at a time.

use crate::bag::messages::{MAX_BYTES, Message, Messages, Topic};
use crate::error::LogError;
use crate::guarded::guarded;
use mcap::io::MessageReader;
use mcap::sans_io::LinearReaderOptions;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};

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
    reader: MessageReader<BufReader<File>>,
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
        let reader = MessageReader::new_with_options(BufReader::new(input), options);
        Ok(Self { file: file.into(), topic: topic.map(str::to_owned), reader })
    }

    fn next_of_any(&mut self) -> Result<Option<mcap::Message<'static>>, LogError> {
        let next = guarded(&self.file, || Ok(self.reader.next()))?;
        let refused = |source| LogError::Mcap { file: self.file.clone(), source: Box::new(source) };
        next.transpose().map_err(refused)
    }
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
