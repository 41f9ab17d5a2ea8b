//! The messages of an MCAP file, one after the other, from a file of any length.

use std::collections::{BTreeMap, HashMap, VecDeque};
use std::io::Read;

use crc::{CRC_32_ISO_HDLC, Crc};
use mcap::McapError;
use mcap::read::ChunkReader;
use mcap::records::{Record, op};
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

/// The check of a chunk.
const CHUNK_CHECK: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// Reads a file from its beginning.
pub(crate) struct McapReader<R> {
    file: R,
    reader: LinearReader,
    schemas: HashMap<u16, String>,
    channels: HashMap<u16, Channel>,
    /// Of the chunk that was read last.
    items: VecDeque<Item>,
}

impl<R: Read> McapReader<R> {
    pub(crate) fn new(file: R) -> Self {
        let options = LinearReaderOptions::default()
            .with_skip_end_magic(true)
            .with_emit_chunks(true)
            .with_record_length_limit(LONGEST_RECORD);
        let reader = LinearReader::new_with_options(options);
        Self { file, reader, schemas: HashMap::new(), channels: HashMap::new(), items: VecDeque::new() }
    }

    /// A channel that a message named.
    pub(crate) fn channel(&self, id: u16) -> Option<&Channel> {
        self.channels.get(&id)
    }

    /// The next message or metadata; `None` at the end.
    pub(crate) fn next(&mut self) -> Result<Option<Item>, McapProblem> {
        loop {
            if let Some(item) = self.items.pop_front() {
                return Ok(Some(item));
            }
            let Some(event) = self.reader.next_event() else { return Ok(None) };
            match event? {
                LinearReadEvent::ReadRequest(count) => {
                    // No more memory than what the file really holds.
                    let count = count.clamp(1, READ_BYTES);
                    let read = self.file.read(self.reader.insert(count));
                    self.reader.notify_read(read.map_err(|error| McapProblem::Io(error.to_string()))?);
                }
                LinearReadEvent::Record { data, opcode } => {
                    let record = parse(opcode, data)?.map(Record::into_owned);
                    record.map_or(Ok(()), |record| self.take(record))?;
                }
            }
        }
    }

    fn take(&mut self, record: Record<'_>) -> Result<(), McapProblem> {
        match record {
            Record::Chunk { header, data } if header.compression.is_empty() => {
                let check = header.uncompressed_crc;
                if check != 0 && check != CHUNK_CHECK.checksum(&data) {
                    return Err(McapProblem::Damaged("the check of a chunk fails".to_owned()));
                }
                let mut rest: &[u8] = &data;
                while !rest.is_empty() {
                    let (record, behind) = first_record(rest)?;
                    if let Some(record) = record {
                        self.take_inside(record);
                    }
                    rest = behind;
                }
            }
            Record::Chunk { header, data } => {
                if header.uncompressed_size > LONGEST_RECORD as u64 {
                    return Err(McapProblem::Damaged("a chunk is longer than any that is read".to_owned()));
                }
                for record in ChunkReader::new(header, &data)? {
                    self.take_inside(record?);
                }
            }
            other => self.take_inside(other),
        }
        Ok(())
    }

    /// A record that may stand in a chunk.
    fn take_inside(&mut self, record: Record<'_>) {
        match record {
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
                self.items.push_back(Item::Message { channel, log_time_ns, data: data.into_owned() });
            }
            Record::Metadata(metadata) => {
                self.items.push_back(Item::Metadata { name: metadata.name, values: metadata.metadata });
            }
            _ => {}
        }
    }
}

/// The first record of a chunk, and what is behind it: a byte that says its kind, its length, and as many bytes.
fn first_record(chunk: &[u8]) -> Result<(Option<Record<'_>>, &[u8]), McapProblem> {
    let damaged = || McapProblem::Damaged("a record is longer than its chunk".to_owned());
    let (&opcode, rest) = chunk.split_first().ok_or_else(damaged)?;
    let (length, rest) = rest.split_first_chunk().ok_or_else(damaged)?;
    let length = usize::try_from(u64::from_le_bytes(*length)).map_err(|_| damaged())?;
    let (body, rest) = rest.split_at_checked(length).ok_or_else(damaged)?;
    Ok((parse(opcode, body)?, rest))
}

/// A record of a kind that says something about samples; the others are not looked into.
fn parse(opcode: u8, body: &[u8]) -> Result<Option<Record<'_>>, McapProblem> {
    match opcode {
        op::SCHEMA | op::CHANNEL | op::MESSAGE | op::CHUNK | op::METADATA => {
            Ok(Some(mcap::parse_record(opcode, body)?))
        }
        _ => Ok(None),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_record_that_is_longer_than_its_chunk_is_damage() {
        let metadata = |length: u64| [vec![0x0c], length.to_le_bytes().to_vec(), vec![0; 8]].concat();
        let (record, rest) = first_record(&metadata(8))
            .map(|(record, rest)| (record.map(|record| record.opcode()), rest.len()))
            .expect("a record");
        assert_eq!((record, rest), (Some(op::METADATA), 0));
        for length in [9, u64::MAX, u64::MAX - 8] {
            assert!(matches!(first_record(&metadata(length)), Err(McapProblem::Damaged(_))), "{length}");
        }
        assert!(first_record(&metadata(8)[..5]).is_err());
    }

    #[test]
    fn records_of_no_concern_are_not_looked_into() {
        // An attachment whose fields end within its last four bytes.
        assert!(matches!(parse(op::ATTACHMENT, &[0; 32]), Ok(None)));
    }
}
