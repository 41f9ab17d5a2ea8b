//! An MCAP file: a recording of palpate, or a ROS 2 bag whose topics a small TOML file names.

use std::collections::{HashMap, VecDeque};
use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;

use palpate::Sample;

use crate::error::SourceError;
use crate::join::{Join, Touch};
use crate::losses::Losses;
use crate::mcap_files::reader::{Channel, Item, McapProblem, McapReader};
use crate::mcap_files::sample_message::{METADATA, TOPIC};
use crate::rigs::RigSample;
use crate::ros::message::{Encoding, MessageKind};
use crate::ros::topics::{Quantity, Topics, Wanted};
use crate::source::{Arrival, Overflow, Source};

/// Longest message, bytes: a thousand joints take less.
const LONGEST_MESSAGE: usize = 256 * 1024;

/// An MCAP file from its beginning to its end.
pub(crate) struct McapSource<S: RigSample = Sample, R = BufReader<File>> {
    name: String,
    reader: McapReader<R>,
    content: Content<S>,
    /// What is looked for in the messages of each channel.
    wanted: HashMap<u16, Vec<(MessageKind, Encoding, Wanted)>>,
    samples: VecDeque<S>,
    /// `# key: value` of the log.
    metadata: Vec<(String, String)>,
    /// Seconds since 1970 at the first message: samples count from there.
    start_s: Option<f64>,
    /// Whether there was a channel that holds what is looked for.
    found: Vec<bool>,
    losses: Losses,
    first_fault: Option<String>,
    ended: bool,
}

/// What the file holds.
enum Content<S> {
    /// Samples that palpate recorded.
    Recording,
    /// Messages of a robot.
    Bag { wanted: Vec<Wanted>, join: Box<Join<S>> },
}

impl<S: RigSample> McapSource<S> {
    pub(crate) fn open(path: &Path, map: Option<&Path>) -> Result<Self, SourceError> {
        let topics = map.map(Topics::read).transpose()?;
        let name = path.display().to_string();
        let file = File::open(path).map_err(|error| SourceError::io(&name, "it cannot be opened", &error))?;
        Ok(Self::new(name, BufReader::new(file), topics.as_ref()))
    }
}

impl<S: RigSample, R: Read> McapSource<S, R> {
    pub(crate) fn new(name: String, file: R, topics: Option<&Topics>) -> Self {
        let content = topics.map_or(Content::Recording, |topics| Content::Bag {
            wanted: topics.wanted(),
            join: Box::new(Join::new(topics.join())),
        });
        let found = vec![false; if let Content::Bag { wanted, .. } = &content { wanted.len() } else { 1 }];
        Self {
            name,
            reader: McapReader::new(file),
            content,
            wanted: HashMap::new(),
            samples: VecDeque::new(),
            metadata: Vec::new(),
            start_s: None,
            found,
            losses: Losses::default(),
            first_fault: None,
            ended: false,
        }
    }

    /// Whether it is a recording of samples of this rig; reads up to the first of any.
    pub(crate) fn holds_recording(&mut self) -> bool {
        while let Ok(Some(item)) = self.reader.next() {
            let Item::Message { channel, .. } = item else { continue };
            if let Some(channel) = self.reader.channel(channel).filter(|channel| channel.topic == TOPIC) {
                return is_recording::<S>(channel);
            }
        }
        false
    }

    /// What the recording says of itself, as far as it was read.
    pub(crate) fn metadata(&self) -> &[(String, String)] {
        &self.metadata
    }

    fn take(&mut self, channel: u16, log_time_ns: u64, data: &[u8]) -> Result<(), SourceError> {
        if !self.wanted.contains_key(&channel) {
            let wanted = match self.reader.channel(channel).cloned() {
                Some(found) => self.wanted_in(&found)?,
                None => Vec::new(),
            };
            self.wanted.insert(channel, wanted);
        }
        let Some(wanted) = self.wanted.get(&channel) else { return Ok(()) };
        let of_recording =
            matches!(self.content, Content::Recording) && self.reader.channel(channel).is_some_and(is_recording::<S>);
        if wanted.is_empty() && !of_recording {
            return Ok(());
        }
        if data.len() > LONGEST_MESSAGE {
            self.losses.too_long += 1;
            return Ok(());
        }
        match &mut self.content {
            Content::Recording => {
                self.found = vec![true];
                match serde_json::from_slice::<S::Message>(data) {
                    Ok(message) => self.samples.push_back(message.into()),
                    Err(error) => self.fault(TOPIC, &error.to_string()),
                }
            }
            Content::Bag { join, .. } => {
                let Some((kind, encoding, first)) = wanted.first() else { return Ok(()) };
                let message = match kind.decode(*encoding, data) {
                    Ok(message) => message,
                    Err(error) => {
                        let topic = first.topic.clone();
                        self.fault(&topic, &error.to_string());
                        return Ok(());
                    }
                };
                let stamp_s = message.stamp_s().unwrap_or(log_time_ns as f64 / 1e9);
                let time_s = stamp_s - *self.start_s.get_or_insert(stamp_s);
                for (_, _, wanted) in wanted {
                    let value = wanted.field.of(&message).map(|value| wanted.to_si(value));
                    match (wanted.quantity, value) {
                        (Quantity::Angle(coordinate) | Quantity::Pivot(coordinate), Some(value)) => {
                            join.place(coordinate, time_s, value);
                        }
                        (Quantity::Position(palm), position_m) => join.touch(palm, time_s, Touch::Position(position_m)),
                        (Quantity::Force(palm), Some(force_n)) => join.touch(palm, time_s, Touch::Force(force_n)),
                        (Quantity::Angle(_) | Quantity::Pivot(_) | Quantity::Force(_), None) => {}
                    }
                }
                join.take(&mut self.samples);
            }
        }
        Ok(())
    }

    /// What is looked for in a channel.
    fn wanted_in(&mut self, channel: &Channel) -> Result<Vec<(MessageKind, Encoding, Wanted)>, SourceError> {
        let Content::Bag { wanted, .. } = &self.content else { return Ok(Vec::new()) };
        let mut found = Vec::new();
        for (index, wanted) in wanted.iter().enumerate().filter(|(_, wanted)| wanted.topic == channel.topic) {
            let refuse =
                |problem: String| SourceError::content(&self.name, format!("topic {}: {problem}", channel.topic));
            let encoding = match channel.encoding.as_str() {
                "cdr" => Encoding::Cdr,
                "json" => Encoding::Json,
                other => {
                    return Err(refuse(format!("its messages are encoded as {other:?}; only cdr and json are read")));
                }
            };
            let kind = wanted.field.kind();
            if MessageKind::of_schema(&channel.schema) != Some(kind) {
                return Err(refuse(format!(
                    "its messages are {:?}, and the field is one of {}",
                    channel.schema,
                    kind.name()
                )));
            }
            if let Some(seen) = self.found.get_mut(index) {
                *seen = true;
            }
            found.push((kind, encoding, wanted.clone()));
        }
        Ok(found)
    }

    fn fault(&mut self, topic: &str, problem: &str) {
        self.losses.faulty += 1;
        self.first_fault.get_or_insert_with(|| format!("{}, topic {topic}: {problem}", self.name));
    }

    /// The file is at its end: what is left, and whether it held what was looked for.
    fn finish(&mut self) -> Result<(), SourceError> {
        self.ended = true;
        if let Content::Bag { join, .. } = &mut self.content {
            join.finish(&mut self.samples);
        }
        let missing = match &self.content {
            Content::Bag { wanted, .. } => {
                let missing = wanted.iter().zip(&self.found).filter(|(_, found)| !**found);
                missing.map(|(wanted, _)| wanted.topic.clone()).next()
            }
            Content::Recording if self.found == [false] => {
                let problem = "it holds no samples that palpate recorded; say which topics hold what by ?map=topics.toml (or --map)";
                return Err(SourceError::content(&self.name, problem));
            }
            Content::Recording => None,
        };
        missing.map_or(Ok(()), |topic| {
            Err(SourceError::content(
                &self.name,
                format!("there is no message of the topic {topic}; correct the map of topics"),
            ))
        })
    }
}

fn is_recording<S: RigSample>(channel: &Channel) -> bool {
    channel.topic == TOPIC && channel.schema == S::SCHEMA && channel.encoding == "json"
}

impl<S: RigSample, R: Read + Send> Source<S> for McapSource<S, R> {
    fn next(&mut self) -> Result<Arrival<S>, SourceError> {
        if let Some(sample) = self.samples.pop_front() {
            return Ok(Arrival::Sample(sample));
        }
        if self.ended {
            return Ok(Arrival::End);
        }
        match self.reader.next() {
            Ok(Some(Item::Message { channel, log_time_ns, data })) => self.take(channel, log_time_ns, &data)?,
            Ok(Some(Item::Metadata { name, values })) if name == METADATA => self.metadata.extend(values),
            Ok(Some(Item::Metadata { .. })) => {}
            Ok(None) => self.finish()?,
            Err(McapProblem::CutOff) => {
                self.losses.gaps += 1;
                self.first_fault.get_or_insert_with(|| format!("{}: {}", self.name, McapProblem::CutOff));
                self.finish()?;
            }
            Err(problem) => return Err(SourceError::content(&self.name, problem.to_string())),
        }
        Ok(self.samples.pop_front().map_or(Arrival::Nothing, Arrival::Sample))
    }

    fn losses(&self) -> Losses {
        let mut losses = self.losses;
        if let Content::Bag { join, .. } = &self.content {
            losses += join.losses();
        }
        losses
    }

    fn first_fault(&self) -> Option<String> {
        self.first_fault.clone()
    }

    fn overflow(&self) -> Overflow {
        Overflow::Waits
    }
}
