//! Strokes of a pivoting grasp as they come: CSV lines on standard input, or of a file that grows, read by a thread of its own.

use std::fs::File;
use std::io::{self, BufRead, Read, Seek, SeekFrom};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, TrySendError, sync_channel};
use std::time::Duration;

use palpate::pivot::PivotSample;
use palpate_io::{StrokesRowReader, is_strokes_log};

use crate::error::SourceError;
use crate::gate::Clock;
use crate::lines::{Line, Lines};
use crate::losses::Losses;
use crate::source::address::Address;
use crate::source::text::LONGEST_LINE;
use crate::stream::Batch;

/// Pause before a file that has not grown is looked at again.
const PAUSE: Duration = Duration::from_millis(20);
/// Bytes read at a time, and such parts that wait at most: what comes faster waits in the file or pipe.
const READ_BYTES: usize = 64 * 1024;
const MOST_WAITING: usize = 16;
/// Most bytes above the first row.
const LONGEST_HEAD: u64 = 64 * 1024;

/// What CSV lines begin with, up to their header: it tells which rig they are of. Waits until it is there.
#[derive(Clone, Debug, Default)]
pub struct Head {
    bytes: Vec<u8>,
}

impl Head {
    /// Of a source; empty where it is none of CSV lines, or cannot be opened. Takes it from standard input: hand it to
    /// [`Address::open_after`] or [`StrokesStream::start`].
    pub fn of(address: &Address) -> Self {
        match address {
            Address::StandardInput => Self::read(&mut io::stdin().lock(), || false),
            Address::File(path) => {
                let Ok(file) = File::open(path) else { return Self::default() };
                let grows = || {
                    std::thread::sleep(PAUSE);
                    true
                };
                Self::read(&mut io::BufReader::new(file), grows)
            }
            _ => Self::default(),
        }
    }

    /// Reads up to the first line that is no comment; `goes_on` says at an end whether more may come.
    fn read(input: &mut impl BufRead, goes_on: impl Fn() -> bool) -> Self {
        let mut bytes = Vec::new();
        let mut begins = 0;
        while (bytes.len() as u64) < LONGEST_HEAD {
            match input.take(LONGEST_HEAD - bytes.len() as u64).read_until(b'\n', &mut bytes) {
                Err(error) if error.kind() != io::ErrorKind::Interrupted => break,
                Ok(0) if !goes_on() => break,
                _ => {}
            }
            if !bytes.ends_with(b"\n") {
                continue;
            }
            let line = String::from_utf8_lossy(&bytes[begins..]);
            if !line.trim().is_empty() && !line.trim_start().starts_with('#') {
                break;
            }
            begins = bytes.len();
        }
        Self { bytes }
    }

    /// Whether the lines below it are of strokes and not of two palms.
    pub fn is_of_strokes(&self) -> bool {
        is_strokes_log(&self.bytes)
    }

    pub(crate) fn into_bytes(self) -> Vec<u8> {
        self.bytes
    }
}

/// What the thread hands on: samples, what was lost so far, and how it ended.
struct Part {
    samples: Vec<PivotSample>,
    losses: Losses,
    first_fault: Option<String>,
    ended: Option<Result<(), SourceError>>,
}

/// The samples of strokes in the order of time, as they come.
#[derive(Debug)]
pub struct StrokesStream {
    parts: Receiver<Part>,
    swing_period_s: Option<f64>,
    losses: Losses,
    first_fault: Option<String>,
    ended: Option<Result<(), SourceError>>,
}

impl StrokesStream {
    /// Begins to read below the head.
    ///
    /// # Errors
    /// The header cannot be used, the file cannot be read, the source is none of CSV lines, or the system gives no thread.
    pub fn start(address: &Address, head: Head) -> Result<Self, SourceError> {
        let name = match address {
            Address::File(path) => path.display().to_string(),
            _ => "standard input".to_owned(),
        };
        let rows = StrokesRowReader::new(&name, &String::from_utf8_lossy(&head.bytes))?;
        let input: Input = match address {
            Address::StandardInput => Input::Pipe(Box::new(io::stdin())),
            Address::File(path) => {
                let failed = |error| SourceError::io(&name, "it cannot be opened", &error);
                let mut file = File::open(path).map_err(failed)?;
                file.seek(SeekFrom::Start(head.bytes.len() as u64)).map_err(failed)?;
                Input::Grows(file)
            }
            other => {
                let problem = "strokes come as CSV lines: give - or a file that grows".to_owned();
                return Err(SourceError::Address { address: other.to_string(), problem });
            }
        };
        Self::of(name, rows, &head, input)
    }

    fn of(name: String, rows: StrokesRowReader, head: &Head, input: Input) -> Result<Self, SourceError> {
        let (sender, parts) = sync_channel(MOST_WAITING);
        let swing_period_s = rows.swing_period_s();
        let line_number = head.bytes.iter().filter(|byte| **byte == b'\n').count();
        let decoder =
            Decoder { name, rows, line_number, clock: Clock::default(), losses: Losses::default(), first_fault: None };
        let thread = std::thread::Builder::new().name("source".to_owned()).spawn(move || read(decoder, input, &sender));
        thread.map_err(|error| SourceError::io("source", "no thread can be started", &error))?;
        Ok(Self { parts, swing_period_s, losses: Losses::default(), first_fault: None, ended: None })
    }

    /// What has come, waiting for it no longer than `patience`.
    ///
    /// # Errors
    /// The source failed; what came before that has been handed on.
    pub fn next(&mut self, patience: Duration) -> Result<Batch<PivotSample>, SourceError> {
        if let Some(ended) = &self.ended {
            return ended.clone().map(|()| Batch::End);
        }
        match self.parts.recv_timeout(patience) {
            Ok(part) => {
                (self.losses, self.first_fault, self.ended) = (part.losses, part.first_fault, part.ended);
                Ok(Batch::Samples(part.samples))
            }
            Err(RecvTimeoutError::Timeout) => Ok(Batch::Samples(Vec::new())),
            Err(RecvTimeoutError::Disconnected) => Ok(Batch::End),
        }
    }

    /// Period of small swings of the lifted object, seconds, where the comments above the header state it.
    pub fn swing_period_s(&self) -> Option<f64> {
        self.swing_period_s
    }

    /// What was lost so far.
    pub fn losses(&self) -> Losses {
        self.losses
    }

    /// What was wrong with the first line that was left out.
    pub fn first_fault(&self) -> Option<String> {
        self.first_fault.clone()
    }
}

/// Where the bytes come from.
enum Input {
    /// To an end.
    Pipe(Box<dyn Read + Send>),
    /// A file that is followed.
    Grows(File),
}

impl Input {
    /// Bytes into the buffer; `None` at the end.
    fn read(&mut self, name: &str, buffer: &mut [u8]) -> Result<Option<usize>, SourceError> {
        let failed = |error: io::Error| SourceError::io(name, "it cannot be read", &error);
        match self {
            Self::Pipe(input) => loop {
                match input.read(buffer) {
                    Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                    Err(error) => return Err(failed(error)),
                    Ok(count) => return Ok((count > 0).then_some(count)),
                }
            },
            Self::Grows(file) => {
                let position = file.stream_position().map_err(failed)?;
                if file.metadata().map_err(failed)?.len() < position {
                    let problem = "the file has become shorter: it has begun anew; watch it again";
                    return Err(SourceError::content(name, problem));
                }
                let count = file.read(buffer).map_err(failed)?;
                if count == 0 {
                    std::thread::sleep(PAUSE);
                }
                Ok(Some(count))
            }
        }
    }
}

/// Lines to samples.
struct Decoder {
    name: String,
    rows: StrokesRowReader,
    line_number: usize,
    clock: Clock,
    losses: Losses,
    first_fault: Option<String>,
}

impl Decoder {
    fn take(&mut self, line: Line, samples: &mut Vec<PivotSample>) {
        self.line_number += 1;
        let Line::Whole(bytes) = line else {
            self.losses.too_long += 1;
            let fault = || format!("{}, line {}: it is longer than {LONGEST_LINE} bytes", self.name, self.line_number);
            self.first_fault.get_or_insert_with(fault);
            return;
        };
        match self.rows.sample(&String::from_utf8_lossy(bytes), self.line_number) {
            Ok(Some(sample)) => {
                let time_s = self.clock.admit(sample.time_s, &mut self.losses);
                samples.extend(time_s.map(|time_s| PivotSample { time_s, ..sample }));
            }
            Ok(None) => {}
            Err(error) => {
                self.losses.faulty += 1;
                self.first_fault.get_or_insert_with(|| error.to_string());
            }
        }
    }

    fn part(&self, samples: Vec<PivotSample>, ended: Option<Result<(), SourceError>>) -> Part {
        Part { samples, losses: self.losses, first_fault: self.first_fault.clone(), ended }
    }
}

/// Reads until the source ends or nobody takes what it gives.
fn read(mut decoder: Decoder, mut input: Input, sender: &SyncSender<Part>) {
    let mut lines = Lines::new(LONGEST_LINE);
    let mut buffer = vec![0; READ_BYTES];
    loop {
        let mut samples = Vec::new();
        let count = input.read(&decoder.name, &mut buffer);
        match &count {
            Ok(Some(count)) => lines.push(&buffer[..*count], |line| decoder.take(line, &mut samples)),
            Ok(None) => lines.finish(|line| decoder.take(line, &mut samples)),
            Err(_) => {}
        }
        let ended = match count {
            Ok(Some(_)) => None,
            Ok(None) => Some(Ok(())),
            Err(error) => Some(Err(error)),
        };
        let is_last = ended.is_some();
        let part = decoder.part(samples, ended);
        let is_taken = if part.samples.is_empty() && !is_last {
            // Only to see whether somebody is there.
            !matches!(sender.try_send(part), Err(TrySendError::Disconnected(_)))
        } else {
            sender.send(part).is_ok()
        };
        if is_last || !is_taken {
            return;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    const HEADER: &str = "# swing_period_s: 0.4\ntime_s,pivot_x_m,pivot_y_m,s_m\n";
    /// Longer than any machine takes.
    const FOREVER: Duration = Duration::from_secs(600);

    fn piped(text: &str) -> (Vec<f64>, StrokesStream) {
        let mut input = text.as_bytes();
        let head = Head::read(&mut input, || false);
        assert!(head.is_of_strokes());
        let rows = StrokesRowReader::new("pipe", &String::from_utf8_lossy(&head.bytes)).expect("a header");
        let rest = Input::Pipe(Box::new(io::Cursor::new(input.to_vec())));
        let mut stream = StrokesStream::of("pipe".to_owned(), rows, &head, rest).expect("a thread");
        let mut times = Vec::new();
        while let Batch::Samples(samples) = stream.next(FOREVER).expect("no fault") {
            times.extend(samples.iter().map(|sample| sample.time_s));
        }
        (times, stream)
    }

    #[test]
    fn lines_become_samples_and_what_is_lost_is_counted() {
        let long = "9".repeat(LONGEST_LINE + 1);
        let rows = format!("1,0.5,0.03,0.5\n2,x,0.03,\n{long}\n1,0.5,0.03,\n1.5,0.5,0.03,\n3,0.5,0.03,0.5");
        let (times, stream) = piped(&format!("{HEADER}{rows}"));
        assert_eq!((times, stream.swing_period_s()), (vec![1.0, 1.5, 3.0], Some(0.4)));
        assert_eq!(stream.losses(), Losses { faulty: 1, too_long: 1, doubled: 1, ..Losses::default() });
        let fault = stream.first_fault().expect("a fault");
        assert!(fault.starts_with("pipe, line 4, column pivot_x_m: "), "{fault}");
    }

    #[test]
    fn a_file_is_followed_until_it_becomes_shorter() {
        let dir = tempfile::tempdir().expect("a folder");
        let path = dir.path().join("strokes.csv");
        let mut file = File::create(&path).expect("a file");
        let address = Address::File(path.clone());
        file.write_all(HEADER.as_bytes()).expect("a header");
        let head = Head::of(&address);
        assert!(head.is_of_strokes());
        let mut stream = StrokesStream::start(&address, head).expect("the file");
        file.write_all(b"1,0.5,0.03,0.5\n2,0.5,").expect("a line");
        let next = |stream: &mut StrokesStream| loop {
            match stream.next(FOREVER) {
                Ok(Batch::Samples(samples)) if samples.is_empty() => {}
                other => break other,
            }
        };
        let Ok(Batch::Samples(samples)) = next(&mut stream) else { panic!("a sample") };
        assert_eq!(samples.len(), 1);
        std::fs::write(&path, HEADER).expect("a shorter file");
        let error = next(&mut stream).expect_err("it has begun anew");
        assert!(error.to_string().contains("watch it again"), "{error}");
    }

    #[test]
    fn other_sources_have_no_head_and_no_strokes() {
        let address: Address = "serial:/dev/null".parse().expect("an address");
        assert!(!Head::of(&address).is_of_strokes());
        assert!(!Head::of(&Address::File("missing.csv".into())).is_of_strokes());
        let head = Head { bytes: HEADER.as_bytes().to_vec() };
        let error = StrokesStream::start(&address, head).expect_err("no strokes");
        assert!(error.to_string().contains("CSV lines"), "{error}");
        let palms = Head::read(&mut &b"# a\ntime_s,phi1_rad,phi2_rad,s1_m,s2_m\n1,"[..], || false);
        assert!(!palms.is_of_strokes() && palms.bytes.ends_with(b"s2_m\n"));
    }
}
