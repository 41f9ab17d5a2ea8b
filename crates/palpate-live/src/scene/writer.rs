//! The file of a scene, written as the estimates come: chunks that are whole, so that it can be read whenever the program stops.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufWriter};
use std::marker::PhantomData;
use std::path::{Path, PathBuf};

use foxglove::Encode;
use foxglove::messages::{FrameTransform, PointCloud, PoseInFrame, SceneUpdate, Timestamp};
use mcap::Writer;
use mcap::records::MessageHeader;
use palpate::Sample;

use super::drawing;
use super::moment::Moment;
use crate::error::RecordError;
use crate::mcap_files::sample_message::{TOPIC, metadata_record};
use crate::mcap_files::writing::{Clock, io_error, options};
use crate::record::{create, require_new};
use crate::rigs::RigSample;

/// Time between two pictures, seconds: as often as an eye sees.
const PICTURE_S: f64 = 0.04;

/// Time between two pictures of the boundary, which changes slowly and has many points, seconds.
const BOUNDARY_S: f64 = 0.5;

/// Time between two moments from which the file can be read, seconds.
const WHOLE_S: f64 = 1.0;

/// Name of the schema of an estimate.
const ESTIMATE: &str = "palpate.Estimate";

/// Writes samples and what was estimated behind them as a scene.
///
/// Topics: `/palpate/scene` (`foxglove.SceneUpdate`), `/palpate/pose` (`foxglove.PoseInFrame`), `/tf` (`foxglove.FrameTransform`),
/// `/palpate/boundary` (`foxglove.PointCloud`), `/palpate/estimate` (JSON) and `/palpate/sample` (JSON, every sample, so that the file is a log as
/// well). Times are those of the samples, from the moment at which the file was begun.
pub struct SceneWriter<S: RigSample = Sample> {
    path: PathBuf,
    writer: Writer<BufWriter<File>>,
    scene: u16,
    pose: u16,
    transform: u16,
    boundary: u16,
    estimate: u16,
    sample: u16,
    sequence: u32,
    clock: Clock,
    of: PhantomData<S>,
    /// When each was last done, seconds since the first sample.
    drawn_s: f64,
    boundary_s: f64,
    whole_s: f64,
}

impl<S: RigSample> SceneWriter<S> {
    /// Begins a file. The metadata are what stands in the comments of a log.
    ///
    /// # Errors
    /// There is such a file, or it cannot be written.
    pub fn create(path: &Path, metadata: &[(String, String)]) -> Result<Self, RecordError> {
        require_new(path)?;
        Self::begin(path, metadata).map_err(|error| RecordError::io(path, "it cannot be made", &error))
    }

    fn begin(path: &Path, metadata: &[(String, String)]) -> io::Result<Self> {
        let mut writer = options().create(BufWriter::new(create(path)?)).map_err(io_error)?;
        let [scene, pose, transform, boundary] = [
            channel::<SceneUpdate>(&mut writer, "/palpate/scene")?,
            channel::<PoseInFrame>(&mut writer, "/palpate/pose")?,
            channel::<FrameTransform>(&mut writer, "/tf")?,
            channel::<PointCloud>(&mut writer, "/palpate/boundary")?,
        ];
        let mut json = |topic: &str, name: &str, schema: &str| {
            let schema = writer.add_schema(name, "jsonschema", schema.as_bytes())?;
            writer.add_channel(schema, topic, "json", &BTreeMap::new())
        };
        let sample = json(TOPIC, S::SCHEMA, &S::schema()).map_err(io_error)?;
        let any = format!(r#"{{"title":"{ESTIMATE}","type":"object"}}"#);
        let estimate = json("/palpate/estimate", ESTIMATE, &any).map_err(io_error)?;
        writer.write_metadata(&metadata_record(metadata)).map_err(io_error)?;
        Ok(Self {
            path: path.to_owned(),
            writer,
            scene,
            pose,
            transform,
            boundary,
            estimate,
            sample,
            sequence: 0,
            clock: Clock::new(),
            of: PhantomData,
            drawn_s: f64::NEG_INFINITY,
            boundary_s: f64::NEG_INFINITY,
            whole_s: f64::NEG_INFINITY,
        })
    }

    /// Takes in a sample and what is seen behind it, which is drawn 25 times a second at most; `json` is asked for the estimate as an object in JSON then.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn push(&mut self, sample: &S, moment: &Moment, json: impl FnOnce() -> String) -> Result<(), RecordError> {
        self.try_push(sample, moment, json).map_err(|error| self.failed(&error))
    }

    fn try_push(&mut self, sample: &S, moment: &Moment, json: impl FnOnce() -> String) -> io::Result<()> {
        let (since_first_s, time_ns) = (self.clock.since_first_s(sample.time_s()), self.clock.ns(sample.time_s()));
        self.write(self.sample, time_ns, &serde_json::to_vec(&S::Message::from(sample))?)?;
        let is_due = |last_s: f64, every_s: f64| since_first_s >= last_s + every_s;
        if is_due(self.drawn_s, PICTURE_S) {
            self.drawn_s = since_first_s;
            self.draw(moment, time_ns)?;
            self.write(self.estimate, time_ns, json().as_bytes())?;
        }
        if !moment.outline.is_empty() && is_due(self.boundary_s, BOUNDARY_S) {
            self.boundary_s = since_first_s;
            let time = timestamp(time_ns);
            self.message(self.scene, time_ns, &drawing::object(moment, time))?;
            self.message(self.boundary, time_ns, &drawing::boundary(moment, time))?;
        }
        if is_due(self.whole_s, WHOLE_S) {
            self.whole_s = since_first_s;
            self.writer.flush().map_err(io_error)?;
        }
        Ok(())
    }

    fn draw(&mut self, moment: &Moment, time_ns: u64) -> io::Result<()> {
        let time = timestamp(time_ns);
        self.message(self.scene, time_ns, &drawing::surfaces(moment, time))?;
        if let Some((pose, transform)) = drawing::pose_of(moment, time) {
            self.message(self.transform, time_ns, &transform)?;
            self.message(self.pose, time_ns, &pose)?;
        }
        Ok(())
    }

    fn message<M: Encode>(&mut self, channel: u16, time_ns: u64, message: &M) -> io::Result<()> {
        let mut data = Vec::with_capacity(message.encoded_len().unwrap_or(0));
        message.encode(&mut data).map_err(|error| io::Error::other(error.to_string()))?;
        self.write(channel, time_ns, &data)
    }

    fn write(&mut self, channel_id: u16, time_ns: u64, data: &[u8]) -> io::Result<()> {
        let header = MessageHeader { channel_id, sequence: self.sequence, log_time: time_ns, publish_time: time_ns };
        self.sequence = self.sequence.wrapping_add(1);
        self.writer.write_to_known_channel(&header, data).map_err(io_error)
    }

    /// Ends the file.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn finish(mut self) -> Result<(), RecordError> {
        self.writer.finish().map(|_| ()).map_err(|error| self.failed(&io_error(error)))
    }

    fn failed(&self, error: &io::Error) -> RecordError {
        RecordError::io(&self.path, "it cannot be written", error)
    }
}

/// A channel of messages of Foxglove.
fn channel<M: Encode>(writer: &mut Writer<BufWriter<File>>, topic: &str) -> io::Result<u16> {
    let schema =
        M::get_schema().map_or(Ok(0), |schema| writer.add_schema(&schema.name, &schema.encoding, &schema.data));
    let schema = schema.map_err(io_error)?;
    writer.add_channel(schema, topic, &M::get_message_encoding(), &BTreeMap::new()).map_err(io_error)
}

fn timestamp(time_ns: u64) -> Timestamp {
    const NS_PER_S: u64 = 1_000_000_000;
    let seconds = u32::try_from(time_ns / NS_PER_S).unwrap_or(u32::MAX);
    Timestamp::new(seconds, (time_ns % NS_PER_S) as u32)
}
