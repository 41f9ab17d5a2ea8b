//! Recordings: files that can be read whenever the program or the machine stops.

mod csv;
mod mcap;

use std::io;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use palpate::Sample;

use crate::error::RecordError;
use crate::rigs::RigSample;

/// What was recorded is handed to the operating system at least this often, where it is safe from the end of this program.
const HAND_OVER: Duration = Duration::from_millis(250);
/// And brought to the disk this often, where it is safe from the end of the machine.
const BRING_TO_DISK: Duration = Duration::from_secs(1);
/// And however fast the samples come, so many bytes wait at most.
const HAND_OVER_BYTES: u64 = 16 * 1024;

/// When a recording goes on in another file. The default is never.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Rotation {
    /// When a file is larger than this, bytes.
    pub size_bytes: Option<u64>,
    /// When a file holds so many seconds, by the time of the samples.
    pub duration_s: Option<f64>,
}

/// What a recording came to.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Recorded {
    /// The files, in the order of time.
    pub files: Vec<PathBuf>,
    /// Samples in them.
    pub samples: u64,
    /// From the first sample to the last, seconds.
    pub duration_s: f64,
}

/// A file of a recording.
trait LogFileWriter {
    /// Hands what was taken in to the operating system, as something that can be read; bytes in the file.
    fn hand_over(&mut self) -> io::Result<u64>;

    /// Brings what was handed over to the disk.
    fn bring_to_disk(&mut self) -> io::Result<()>;

    /// Ends the file as its format has it.
    fn finish(&mut self) -> io::Result<()>;

    /// Shortens the file to what was last handed over, after a failure.
    fn undo(&mut self);
}

/// One that takes samples of a rig.
trait SampleWriter<S>: LogFileWriter {
    /// Takes a sample in; its bytes.
    fn push(&mut self, sample: &S) -> io::Result<usize>;
}

/// The formats of recordings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    Csv,
    Mcap,
}

/// Records samples to a file, or to several one after the other.
///
/// A recording in CSV grows line by line; one in MCAP by chunks that are whole. Neither needs an end to be read. After a failure, such as a full
/// disk, the file holds everything up to some moment before.
pub struct Recorder<S: RigSample = Sample> {
    path: PathBuf,
    format: Format,
    rotation: Rotation,
    metadata: Vec<(String, String)>,
    writer: Box<dyn SampleWriter<S>>,
    /// Of the samples in the current file.
    first_s: Option<f64>,
    /// Time of the first sample of all and of the newest.
    span_s: Option<(f64, f64)>,
    /// Samples handed over, and those that are not yet.
    safe: u64,
    pending: u64,
    /// Bytes of each.
    size_bytes: u64,
    pending_bytes: u64,
    handed_over: Instant,
    on_disk: Instant,
    files: Vec<PathBuf>,
}

impl<S: RigSample> std::fmt::Debug for Recorder<S> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Recorder").field("files", &self.files).field("samples", &self.safe).finish_non_exhaustive()
    }
}

impl<S: RigSample> Recorder<S> {
    /// Begins a recording; its format goes by the name, `.csv` or `.mcap`. The metadata are what stands in the comments of a log. With a rotation, the
    /// files are `NAME.0001.csv` and so on.
    ///
    /// # Errors
    /// There is such a file, or it cannot be written.
    pub fn create(path: &Path, rotation: Rotation, metadata: &[(String, String)]) -> Result<Self, RecordError> {
        let format = match path.extension().and_then(|extension| extension.to_str()) {
            Some("csv") => Format::Csv,
            Some("mcap") => Format::Mcap,
            // A device, such as /dev/full.
            None if path.exists() && !path.is_file() && !path.is_dir() => Format::Csv,
            _ => return Err(RecordError::Format { file: path.display().to_string() }),
        };
        let first = if rotation == Rotation::default() { path.to_owned() } else { numbered(path, 1) };
        let writer = open(&first, format, metadata)?;
        let now = Instant::now();
        Ok(Self {
            path: path.to_owned(),
            format,
            rotation,
            metadata: metadata.to_vec(),
            writer,
            first_s: None,
            span_s: None,
            safe: 0,
            pending: 0,
            size_bytes: 0,
            pending_bytes: 0,
            handed_over: now,
            on_disk: now,
            files: vec![first],
        })
    }

    /// Takes samples in, and cares for those taken in before. To be called several times a second, also without samples.
    ///
    /// # Errors
    /// The file cannot be written. It holds what [`recorded`](Self::recorded) says.
    pub fn push(&mut self, samples: &[S]) -> Result<(), RecordError> {
        for sample in samples {
            if self.is_full(sample.time_s()) {
                self.go_on_in_another()?;
            }
            self.pending_bytes += self.attempt("writing failed", |writer| writer.push(sample))? as u64;
            self.pending += 1;
            self.first_s.get_or_insert(sample.time_s());
            self.span_s.get_or_insert((sample.time_s(), sample.time_s())).1 = sample.time_s();
            if self.pending_bytes >= HAND_OVER_BYTES {
                self.hand_over()?;
            }
        }
        if self.handed_over.elapsed() >= HAND_OVER {
            self.hand_over()?;
        }
        if self.on_disk.elapsed() >= BRING_TO_DISK {
            self.hand_over()?;
            self.attempt("it cannot be brought to the disk", |writer| writer.bring_to_disk())?;
            self.on_disk = Instant::now();
        }
        Ok(())
    }

    /// Ends the recording.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn finish(mut self) -> Result<Recorded, RecordError> {
        self.end_file()?;
        Ok(self.recorded())
    }

    /// What is in the files by now.
    pub fn recorded(&self) -> Recorded {
        let duration_s = self.span_s.map_or(0.0, |(first_s, newest_s)| newest_s - first_s);
        Recorded { files: self.files.clone(), samples: self.safe, duration_s }
    }

    fn is_full(&self, time_s: f64) -> bool {
        let Some(first_s) = self.first_s else { return false };
        self.rotation.size_bytes.is_some_and(|limit| self.size_bytes + self.pending_bytes >= limit)
            || self.rotation.duration_s.is_some_and(|limit| time_s - first_s >= limit)
    }

    fn go_on_in_another(&mut self) -> Result<(), RecordError> {
        self.end_file()?;
        let next = numbered(&self.path, self.files.len() + 1);
        self.writer = open(&next, self.format, &self.metadata)?;
        self.files.push(next);
        self.first_s = None;
        self.size_bytes = 0;
        Ok(())
    }

    fn end_file(&mut self) -> Result<(), RecordError> {
        self.hand_over()?;
        self.attempt("it cannot be ended", |writer| writer.finish().and_then(|()| writer.bring_to_disk()))
    }

    /// Hands everything that was taken in to the operating system. [`push`](Self::push) does so several times a second.
    ///
    /// # Errors
    /// As of [`push`](Self::push).
    pub fn hand_over(&mut self) -> Result<(), RecordError> {
        self.size_bytes = self.attempt("writing failed", |writer| writer.hand_over())?;
        self.safe += std::mem::take(&mut self.pending);
        self.pending_bytes = 0;
        self.handed_over = Instant::now();
        Ok(())
    }

    /// Does something with the file; after a failure it is as it was handed over.
    fn attempt<T>(
        &mut self,
        action: &'static str,
        attempt: impl FnOnce(&mut dyn SampleWriter<S>) -> io::Result<T>,
    ) -> Result<T, RecordError> {
        attempt(self.writer.as_mut()).map_err(|error| {
            self.writer.undo();
            let file = self.files.last().unwrap_or(&self.path);
            RecordError::io(file, action, &error)
        })
    }
}

fn open<S: RigSample>(
    path: &Path,
    format: Format,
    metadata: &[(String, String)],
) -> Result<Box<dyn SampleWriter<S>>, RecordError> {
    require_new(path)?;
    let failed = |error| RecordError::io(path, "it cannot be made", &error);
    Ok(match format {
        Format::Csv => Box::new(csv::CsvWriter::create::<S>(path, metadata).map_err(failed)?),
        Format::Mcap => Box::new(mcap::McapWriter::create::<S>(path, metadata).map_err(failed)?),
    })
}

/// Refuses the place of a file.
pub(crate) fn require_new(path: &Path) -> Result<(), RecordError> {
    if path.is_file() { Err(RecordError::Exists { file: path.display().to_string() }) } else { Ok(()) }
}

/// `NAME.0001.csv` for `NAME.csv`.
fn numbered(path: &Path, number: usize) -> PathBuf {
    let extension = path.extension().unwrap_or_default().to_string_lossy();
    path.with_extension(format!("{number:04}.{extension}"))
}

/// A file made anew, or a device.
pub(crate) fn create(path: &Path) -> io::Result<std::fs::File> {
    if let Some(folder) = path.parent().filter(|folder| !folder.as_os_str().is_empty()) {
        std::fs::create_dir_all(folder)?;
    }
    std::fs::OpenOptions::new().write(true).create(true).truncate(false).open(path)
}
