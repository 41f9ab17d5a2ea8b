//! A log from an MCAP file as a whole.

use std::io::Read;
use std::path::Path;

use palpate::pivot::{PivotLog, PivotSample};
use palpate::{Log, Sample};
use palpate_io::{Conventions, LogFile, MIN_SAMPLES, RigFile, StrokesComments, StrokesFile, parse_rig_comment};

use crate::error::SourceError;
use crate::gate::Gate;
use crate::losses::Losses;
use crate::rigs::{RigKind, RigSample};
use crate::ros::topics::Topics;
use crate::source::mcap::McapSource;
use crate::source::{Arrival, Source};

/// Reads a palm log from an MCAP file: a recording of palpate, or with `map`, a TOML file that says which topics hold what, a ROS 2 bag. The log is as
/// palpate has it: the conventions are those given, or else those that the recording states, with what it says of its rig.
///
/// # Errors
/// The file cannot be read, does not hold what is looked for, or has fewer than [`MIN_SAMPLES`] samples with a contact on both palms.
pub fn read_mcap_log(
    path: &Path,
    map: Option<&Path>,
    conventions: Option<Conventions>,
) -> Result<(LogFile, Option<RigFile>), SourceError> {
    log_of(&path.display().to_string(), McapSource::open(path, map)?, conventions)
}

/// The same from memory, with the text of the map; `name` stands for both in messages.
///
/// # Errors
/// As of [`read_mcap_log`].
pub fn parse_mcap_log(name: &str, bytes: &[u8], map: Option<&str>) -> Result<(LogFile, Option<RigFile>), SourceError> {
    let topics = map.map(|text| Topics::parse(name.as_ref(), text)).transpose()?;
    log_of(name, McapSource::new(name.to_owned(), bytes, topics.as_ref()), None)
}

fn log_of<R: Read + Send>(
    name: &str,
    mut source: McapSource<Sample, R>,
    conventions: Option<Conventions>,
) -> Result<(LogFile, Option<RigFile>), SourceError> {
    let raw = all(&mut source)?;
    let metadata = source.metadata().to_vec();
    let said = match conventions {
        Some(_) => None,
        None => metadata.iter().find(|(key, _)| key == "rig").map(|(_, value)| parse_rig_comment(name, value)),
    };
    let said =
        said.transpose().map_err(|error| SourceError::content(name, format!("what it says of its rig: {error}")))?;
    let conventions = conventions.or(said.as_ref().map(|rig| rig.conventions)).unwrap_or_default();
    let mut gate = Gate::new(conventions);
    let samples = raw.into_iter().filter_map(|sample| gate.admit(sample)).collect();
    let log = conventions.apply(&Log { samples });
    let (losses, notes) = lost(&source, &gate);
    let both = log.samples.iter().filter(|sample| sample.s1_m.is_some() && sample.s2_m.is_some()).count();
    if both < MIN_SAMPLES {
        let first = source.first_fault().map_or_else(String::new, |fault| format!("; the first fault: {fault}"));
        let problem =
            format!("{both} samples have a contact on both palms, and {MIN_SAMPLES} are needed; lost: {losses}{first}");
        return Err(SourceError::content(name, problem));
    }
    Ok((LogFile { log, metadata, notes }, said))
}

/// Which rig an MCAP file is of: by the map of its topics, or else by what was recorded. One that cannot be read is of palms, whose reader says why.
pub fn mcap_rig_kind(path: &Path, map: Option<&Path>) -> RigKind {
    if let Some(map) = map {
        return Topics::read(map).map(|topics| topics.rig_kind()).unwrap_or_default();
    }
    let is_of_strokes = McapSource::<PivotSample>::open(path, None).is_ok_and(|mut source| source.holds_recording());
    if is_of_strokes { RigKind::Pivot } else { RigKind::Palms }
}

/// Reads a log of strokes from an MCAP file: a recording of palpate, or with `map` a ROS 2 bag, as [`read_mcap_log`] does.
///
/// # Errors
/// The file cannot be read, or does not hold what is looked for.
pub fn read_mcap_strokes(path: &Path, map: Option<&Path>) -> Result<StrokesFile, SourceError> {
    let name = path.display().to_string();
    let mut source = McapSource::<PivotSample>::open(path, map)?;
    let raw = all(&mut source)?;
    let metadata = source.metadata().to_vec();
    let mut comments = StrokesComments::default();
    let take = |(key, value): &(String, String)| comments.take(&name, key, value);
    metadata.iter().try_for_each(take)?;
    let mut gate = Gate::new(());
    let samples = raw.into_iter().filter_map(|sample| gate.admit(sample)).collect();
    let (_, notes) = lost(&source, &gate);
    let StrokesComments { rig, swing_period_s } = comments;
    Ok(StrokesFile { log: PivotLog { samples, swing_period_s }, metadata, rig, notes })
}

/// Everything that a source has.
fn all<S: RigSample>(source: &mut impl Source<S>) -> Result<Vec<S>, SourceError> {
    let mut samples = Vec::new();
    loop {
        match source.next()? {
            Arrival::Sample(sample) => samples.push(sample),
            Arrival::Nothing => {}
            Arrival::End => return Ok(samples),
        }
    }
}

/// What was lost, and what there is to say about it.
fn lost<S: RigSample>(source: &impl Source<S>, gate: &Gate<S>) -> (Losses, Vec<String>) {
    let mut losses = source.losses();
    losses += gate.losses();
    let mut notes: Vec<String> = source.first_fault().into_iter().collect();
    if !losses.is_none() {
        notes.push(format!("left out or noticed: {losses}"));
    }
    (losses, notes)
}
