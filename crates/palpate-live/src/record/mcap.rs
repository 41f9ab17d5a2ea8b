//! A recording in MCAP: chunks of JSON messages, each chunk whole.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufWriter};
use std::path::Path;

use mcap::Writer;
use mcap::records::MessageHeader;

use super::{LogFileWriter, SampleWriter};
use crate::mcap_files::sample_message::{TOPIC, metadata_record};
use crate::mcap_files::writing::{Clock, io_error, options};
use crate::rigs::RigSample;

/// A file of the format.
pub(super) struct McapWriter {
    /// `None` after a failure.
    writer: Option<Writer<BufWriter<File>>>,
    file: File,
    channel: u16,
    sequence: u32,
    clock: Clock,
    /// Bytes of the file that are whole.
    whole: u64,
}

impl McapWriter {
    pub(super) fn create<S: RigSample>(path: &Path, metadata: &[(String, String)]) -> io::Result<Self> {
        let file = super::create(path)?;
        let mut writer = options().create(BufWriter::new(file.try_clone()?)).map_err(io_error)?;
        let schema_id = writer.add_schema(S::SCHEMA, "jsonschema", S::schema().as_bytes()).map_err(io_error)?;
        let channel = writer.add_channel(schema_id, TOPIC, "json", &BTreeMap::new()).map_err(io_error)?;
        writer.write_metadata(&metadata_record(metadata)).map_err(io_error)?;
        let mut writer = Self { writer: Some(writer), file, channel, sequence: 0, clock: Clock::new(), whole: 0 };
        writer.hand_over().inspect_err(|_| writer.undo())?;
        Ok(writer)
    }

    fn writer(&mut self) -> io::Result<&mut Writer<BufWriter<File>>> {
        self.writer.as_mut().ok_or_else(|| io::Error::other("the recording has failed before"))
    }
}

impl<S: RigSample> SampleWriter<S> for McapWriter {
    fn push(&mut self, sample: &S) -> io::Result<usize> {
        let data = serde_json::to_vec(&S::Message::from(sample))?;
        let log_time = self.clock.ns(sample.time_s());
        let header =
            MessageHeader { channel_id: self.channel, sequence: self.sequence, log_time, publish_time: log_time };
        self.sequence = self.sequence.wrapping_add(1);
        self.writer()?.write_to_known_channel(&header, &data).map_err(io_error)?;
        Ok(data.len())
    }
}

impl LogFileWriter for McapWriter {
    fn hand_over(&mut self) -> io::Result<u64> {
        self.writer()?.flush().map_err(io_error)?;
        let length = self.file.metadata()?.len();
        self.whole = length;
        Ok(length)
    }

    fn bring_to_disk(&mut self) -> io::Result<()> {
        if self.file.metadata()?.is_file() { self.file.sync_data() } else { Ok(()) }
    }

    fn finish(&mut self) -> io::Result<()> {
        self.writer()?.finish().map_err(io_error)?;
        let Some(writer) = self.writer.take() else { return Ok(()) };
        writer.into_inner().into_inner().map_err(io::IntoInnerError::into_error)?;
        Ok(())
    }

    fn undo(&mut self) {
        if let Some(writer) = self.writer.take() {
            // It would try to end the file, and to write what it holds.
            let (unwritten, _) = writer.into_inner().into_parts();
            drop(unwritten);
        }
        // A last chunk that is not whole is left out by readers, if this fails too.
        let _ = self.file.set_len(self.whole);
    }
}
