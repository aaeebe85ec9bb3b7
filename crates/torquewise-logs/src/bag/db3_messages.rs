//! SQLite bags (.db3): topics and messages, some thousand rows at a time.

use crate::bag::{MAX_BYTES, Message, Messages, Topic};
use crate::{Format, LogError, Result};
use rusqlite::limits::Limit;
use rusqlite::{Connection, OpenFlags, params};
use std::collections::VecDeque;
use std::ffi::OsString;
use std::fmt::Write;
use std::fs::{self, File};
use std::io::Read;
use std::path::{Path, PathBuf};

/// Messages asked for at once, and their bytes at most but for the last.
const PAGE: u32 = 1_024;
const PAGE_BYTES: usize = 16 << 20;

const MOST_TOPICS: usize = 10_000;

const MAGIC: &[u8] = b"SQLite format 3\0";

const TOPICS: &str = "SELECT t.name, t.type, t.serialization_format, COALESCE(m.n, 0) \
    FROM topics t LEFT JOIN (SELECT topic_id, COUNT(*) AS n FROM messages GROUP BY topic_id) m \
    ON m.topic_id = t.id ORDER BY t.id";

/// By the index on time that a recorder makes.
const BY_TIME: &str = "SELECT id, timestamp, data FROM messages \
    WHERE topic_id IN (SELECT id FROM topics WHERE name = ?1) AND (timestamp, id) > (?2, ?3) \
    ORDER BY timestamp, id LIMIT ?4";

/// Without, as they were recorded: each page would sort all messages.
const AS_RECORDED: &str = "SELECT rowid, timestamp, data FROM messages \
    WHERE topic_id IN (SELECT id FROM topics WHERE name = ?1) AND rowid > ?3 AND ?2 IS NOT NULL \
    ORDER BY rowid LIMIT ?4";

const INDICES: &str = "SELECT COUNT(*) FROM pragma_index_list('messages') AS list, \
    pragma_index_info(list.name) AS part WHERE part.seqno = 0 AND part.name = 'timestamp'";

/// A view or a virtual table under these names could do anything.
const TABLES: &str = "SELECT COUNT(*) FROM sqlite_master WHERE type = 'table' AND rootpage > 0 \
    AND name IN ('topics', 'messages')";

/// Columns whose values the file computes, which may be any number of bytes.
const GENERATED: &str = "SELECT (SELECT COUNT(*) FROM pragma_table_xinfo('messages') WHERE hidden) \
    + (SELECT COUNT(*) FROM pragma_table_xinfo('topics') WHERE hidden)";

pub(super) fn topics(file: &Path) -> Result<Vec<Topic>> {
    let refused = LogError::decode(file, Format::Db3);
    let connection = open(file)?;
    let mut statement = connection.0.prepare(TOPICS).map_err(&refused)?;
    let topics = statement.query_map([], |row| {
        Ok(Topic {
            name: row.get(0)?,
            kind: row.get(1)?,
            encoding: row.get(2)?,
            n_messages: u64::try_from(row.get::<_, i64>(3)?).unwrap_or(0),
        })
    });
    let topics = topics.map_err(&refused)?.take(MOST_TOPICS);
    topics.collect::<Result<_, _>>().map_err(&refused)
}

pub(super) struct Db3Messages {
    file: PathBuf,
    connection: Bag,
    topic: String,
    query: &'static str,
    page: VecDeque<Message>,
    last: (i64, i64),
}

impl Db3Messages {
    pub(super) fn open(file: &Path, topic: &str) -> Result<Self> {
        let connection = open(file)?;
        let is_indexed = count(&connection.0, file, INDICES)? > 0;
        Ok(Self {
            file: file.into(),
            connection,
            topic: topic.to_owned(),
            query: if is_indexed { BY_TIME } else { AS_RECORDED },
            page: VecDeque::new(),
            last: (i64::MIN, i64::MIN),
        })
    }

    fn next_page(&mut self) -> Result<()> {
        let refused = LogError::decode(&self.file, Format::Db3);
        let mut statement = self.connection.0.prepare_cached(self.query).map_err(&refused)?;
        let (received, id) = self.last;
        let mut rows =
            statement.query(params![self.topic, received, id, PAGE]).map_err(&refused)?;
        let mut bytes_held = 0;
        while bytes_held < PAGE_BYTES
            && let Some(row) = rows.next().map_err(&refused)?
        {
            let id = row.get(0).map_err(&refused)?;
            let received = row.get(1).map_err(&refused)?;
            let bytes: Vec<u8> = row.get(2).map_err(&refused)?;
            bytes_held += bytes.len();
            self.last = (received, id);
            self.page.push_back(Message { received, bytes });
        }
        Ok(())
    }
}

impl Messages for Db3Messages {
    fn next(&mut self) -> Result<Option<Message>> {
        if self.page.is_empty() {
            self.next_page()?;
        }
        Ok(self.page.pop_front())
    }
}

/// A bag opened to be read, and the file that SQLite makes beside one that was not closed.
struct Bag(Connection, #[expect(dead_code, reason = "removes on drop")] Option<SharedMemory>);

struct SharedMemory(PathBuf);

impl Drop for SharedMemory {
    fn drop(&mut self) {
        // Where it was not made there is nothing to remove.
        let _ = fs::remove_file(&self.0);
    }
}

fn open(file: &Path) -> Result<Bag> {
    // SQLite takes an empty or missing file for a new database.
    let mut head = Vec::new();
    let input = File::open(file).map_err(LogError::read(file))?;
    input.take(MAGIC.len() as u64).read_to_end(&mut head).map_err(LogError::read(file))?;
    match head.as_slice() {
        [] => return Err(LogError::Empty { file: file.into() }),
        MAGIC => {}
        _ => return Err(LogError::NoBag { file: file.into() }),
    }
    let mut shared = OsString::from(file);
    shared.push("-shm");
    let shared = Some(PathBuf::from(shared)).filter(|path| !path.exists()).map(SharedMemory);
    let refused = LogError::decode(file, Format::Db3);
    let flags = OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_NO_MUTEX;
    let connection = match unchanging(file) {
        Some(address) => Connection::open_with_flags(address, flags | OpenFlags::SQLITE_OPEN_URI),
        None => Connection::open_with_flags(file, flags),
    };
    let connection = connection.map_err(&refused)?;
    let longest = i32::try_from(MAX_BYTES).unwrap_or(i32::MAX);
    connection.set_limit(Limit::SQLITE_LIMIT_LENGTH, longest).map_err(&refused)?;
    connection.pragma_update(None, "trusted_schema", false).map_err(&refused)?;
    if count(&connection, file, TABLES)? != 2 || count(&connection, file, GENERATED)? != 0 {
        return Err(LogError::NoBag { file: file.into() });
    }
    Ok(Bag(connection, shared))
}

fn count(connection: &Connection, file: &Path, query: &str) -> Result<i64> {
    connection.query_row(query, [], |row| row.get(0)).map_err(LogError::decode(file, Format::Db3))
}

/// The address under which SQLite writes nothing beside the file, unless a recording left parts of
/// it in files of their own.
fn unchanging(file: &Path) -> Option<String> {
    let is_whole = ["-wal", "-journal"].iter().all(|end| {
        let mut beside = OsString::from(file);
        beside.push(end);
        !Path::new(&beside).exists()
    });
    let path = std::path::absolute(file).ok().filter(|_| is_whole && cfg!(unix))?;
    let mut address = String::from("file://");
    for byte in path.to_str()?.bytes() {
        match byte {
            b'/' | b'.' | b'-' | b'_' => address.push(char::from(byte)),
            _ if byte.is_ascii_alphanumeric() => address.push(char::from(byte)),
            _ => write!(address, "%{byte:02x}").ok()?,
        }
    }
    Some(address + "?immutable=1")
}
