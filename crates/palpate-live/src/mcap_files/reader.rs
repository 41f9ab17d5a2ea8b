//! The messages of an MCAP file, one after the other, from a file of any length.

use std::borrow::Cow;
use std::collections::{BTreeMap, HashMap};
use std::io::Read;

use mcap::McapError;
use mcap::records::Record;
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};

/// Longest record and chunk that is read, bytes. Chunks have a megabyte or so; a longer one would be for pictures, or is damage.
const LONGEST_RECORD: usize = 64 * 1024 * 1024;
/// Bytes read at a time.
const READ_BYTES: usize = 64 * 1024;
/// Schemas and channels at most: a robot has some hundred topics.
const MOST_CHANNELS: usize = 65_536;

/// A channel: its topic, and how its messages are written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Channel {
    pub(crate) topic: String,
    pub(crate) schema: String,
    pub(crate) encoding: String,
}

/// What comes out of a file.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Item {
    /// A message.
    Message {
        channel: u16,
        /// When it was recorded, nanoseconds since 1970.
        log_time_ns: u64,
        data: Vec<u8>,
    },
    /// A metadata record.
    Metadata { name: String, values: BTreeMap<String, String> },
}

/// Why there is no further message.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub(crate) enum McapProblem {
    /// It does not begin as MCAP does.
    #[error("this is no MCAP file")]
    NoMcap,
    /// The file ends before its end.
    #[error("the file was cut off; everything before that is read")]
    CutOff,
    /// Compressed, and this program cannot undo it.
    #[error(
        "its chunks are compressed by {0}, which this build does not read; write it anew without: mcap compress --compression none"
    )]
    Compressed(String),
    /// Anything else.
    #[error("it is damaged: {0}")]
    Damaged(String),
    /// The operating system refused.
    #[error("it cannot be read: {0}")]
    Io(String),
}

impl From<McapError> for McapProblem {
    fn from(error: McapError) -> Self {
        match error {
            McapError::BadMagic => Self::NoMcap,
            McapError::UnexpectedEof | McapError::UnexpectedEoc => Self::CutOff,
            McapError::UnsupportedCompression(name) => Self::Compressed(name),
            other => Self::Damaged(other.to_string()),
        }
    }
}

/// Reads a file from its beginning.
pub(crate) struct McapReader<R> {
    file: R,
    reader: LinearReader,
    schemas: HashMap<u16, String>,
    channels: HashMap<u16, Channel>,
}

impl<R: Read> McapReader<R> {
    pub(crate) fn new(file: R) -> Self {
        let options = LinearReaderOptions::default()
            .with_skip_end_magic(true)
            .with_prevalidate_chunk_crcs(true)
            .with_record_length_limit(LONGEST_RECORD);
        Self {
            file,
            reader: LinearReader::new_with_options(options),
            schemas: HashMap::new(),
            channels: HashMap::new(),
        }
    }

    /// A channel that a message named.
    pub(crate) fn channel(&self, id: u16) -> Option<&Channel> {
        self.channels.get(&id)
    }

    /// The next message or metadata; `None` at the end.
    pub(crate) fn next(&mut self) -> Result<Option<Item>, McapProblem> {
        loop {
            let Some(event) = self.reader.next_event() else { return Ok(None) };
            match event? {
                LinearReadEvent::ReadRequest(count) => {
                    // No more memory than what the file really holds.
                    let count = count.clamp(1, READ_BYTES);
                    let read = self.file.read(self.reader.insert(count));
                    self.reader.notify_read(read.map_err(|error| McapProblem::Io(error.to_string()))?);
                }
                LinearReadEvent::Record { data, opcode } => match mcap::parse_record(opcode, data)? {
                    Record::Schema { header, .. } if self.schemas.len() < MOST_CHANNELS => {
                        self.schemas.insert(header.id, header.name);
                    }
                    Record::Channel(channel) if self.channels.len() < MOST_CHANNELS => {
                        let schema = self.schemas.get(&channel.schema_id).cloned().unwrap_or_default();
                        let found = Channel { topic: channel.topic, schema, encoding: channel.message_encoding };
                        self.channels.insert(channel.id, found);
                    }
                    Record::Message { header, data } => {
                        let (channel, log_time_ns) = (header.channel_id, header.log_time);
                        return Ok(Some(Item::Message { channel, log_time_ns, data: Cow::into_owned(data) }));
                    }
                    Record::Metadata(metadata) => {
                        return Ok(Some(Item::Metadata { name: metadata.name, values: metadata.metadata }));
                    }
                    _ => {}
                },
            }
        }
    }
}
