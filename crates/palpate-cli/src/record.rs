//! `palpate record`: the samples of a sensor into a file, as they come.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use palpate::Sample;
use palpate::pivot::PivotSample;
use palpate_live::{
    Address, Batch, Head, Losses, RecordError, Recorded, Recorder, RigKind, Rotation, SourceError, Stream,
};

use crate::live_rig::{LiveRig, metadata};
use crate::terminal::{Ending, Failure, Terminal};
use crate::values;

const AFTER_HELP: &str = "\
SOURCE is one of
  FILE.csv                                       a log that grows, of palms or of strokes; it is followed until Ctrl-C
  -                                              CSV lines on standard input, a header first
  serial:/dev/ttyUSB0?baud=115200                a board that speaks the line protocol (docs/formats.md); &rig=pivot for strokes
  evdev:/dev/input/event5,/dev/input/event6?angles=/dev/input/event7
                                                 touchpads of palm 1 and 2, and a device with both angles (or ?phi1_deg=60&phi2_deg=74)
  mcap:FILE.mcap?map=topics.toml                 a ROS 2 bag; without ?map a recording of palpate
  sim:PLAN.toml                                  a simulated rig in real time; of strokes with motion = \"strokes\"

The file can be read whenever the recording ends, also by a kill, a full disk or a power cut: at most the last second is lost. A sensor
that is unplugged is waited for. What is lost is counted by cause and told. Ctrl-C ends the recording.

Examples:
  palpate record serial:/dev/ttyUSB0 -o trial.csv
  palpate record serial:/dev/ttyUSB0 --rig rig.toml -o day.mcap --rotate-s 600
  robot | palpate record - -o trial.mcap
  palpate record trial.csv -o copy.csv --seconds 60
  palpate reconstruct trial.mcap

Exit codes: 0 recorded;  2 bad input or usage;  1 anything else, such as a full disk.";

/// Time between two looks at the source where nothing comes.
const TICK: Duration = Duration::from_millis(100);
/// Time between two notes about losses.
const NOTE: Duration = Duration::from_secs(1);

/// Record the samples of a sensor to a file
#[derive(clap::Args)]
#[command(after_help = AFTER_HELP)]
pub struct Arguments {
    /// Where the samples come from, see below
    #[arg(value_name = "SOURCE")]
    source: Address,
    /// The file to write, a log in CSV or an MCAP file by the end of its name; it must not be there yet
    #[arg(short, long = "out", value_name = "FILE.csv|FILE.mcap")]
    out: PathBuf,
    /// What is known of the rig, a file as `palpate rig --template` prints it (of strokes: docs/formats.md): it says which samples are plausible, and is
    /// noted in the recording. Samples are recorded as the rig gives them
    #[arg(long, value_name = "RIG.toml")]
    rig: Option<PathBuf>,
    /// Stop after this time, s [default: when the source ends, or at Ctrl-C]
    #[arg(long, value_name = "S", value_parser = values::positive)]
    seconds: Option<f64>,
    /// Go on in another file (FILE.0002.csv and so on) when one is larger than this, megabytes
    #[arg(long, value_name = "MB", value_parser = values::positive)]
    rotate_mb: Option<f64>,
    /// Go on in another file when one holds samples of so much time, s
    #[arg(long, value_name = "S", value_parser = values::positive)]
    rotate_s: Option<f64>,
    /// Print nothing but errors
    #[arg(short, long)]
    quiet: bool,
}

/// Records until there is an end.
pub fn run(arguments: &Arguments) -> Result<Ending, Failure> {
    let head = Head::of(&arguments.source);
    match arguments.source.rig_kind(&head) {
        RigKind::Palms => of_rig::<Sample>(arguments, head),
        RigKind::Pivot => of_rig::<PivotSample>(arguments, head),
    }
}

fn of_rig<S: LiveRig>(arguments: &Arguments, head: Head) -> Result<Ending, Failure> {
    let terminal = Terminal::new(arguments.quiet);
    let stated = arguments.rig.as_deref().map(S::read).transpose()?;
    let conventions = stated.as_ref().map(S::conventions);
    let of_head = head.rig::<S>();
    let source = arguments.source.open_after::<S>(head, conventions)?;
    let known = S::known(stated, source.rig().or(of_head));
    let rotation = Rotation {
        size_bytes: arguments.rotate_mb.map(|megabytes| (1e6 * megabytes) as u64),
        duration_s: arguments.rotate_s,
    };
    let noted = metadata::<S>(&arguments.source, known.as_ref());
    let recorder = Recorder::create(&arguments.out, rotation, &noted)?;
    let stopped = Arc::new(AtomicBool::new(false));
    let stop = Arc::clone(&stopped);
    ctrlc::set_handler(move || stop.store(true, Ordering::SeqCst))
        .map_err(|error| Failure::Other(format!("Ctrl-C cannot be caught: {error}")))?;
    let stream = Stream::start(source, known.as_ref().map(S::conventions))?;
    record(arguments, recorder, &stream, &stopped, &terminal)
}

fn record<S: LiveRig>(
    arguments: &Arguments,
    mut recorder: Recorder<S>,
    stream: &Stream<S>,
    stopped: &AtomicBool,
    terminal: &Terminal,
) -> Result<Ending, Failure> {
    let begun = Instant::now();
    let is_over = || {
        stopped.load(Ordering::SeqCst) || arguments.seconds.is_some_and(|limit| begun.elapsed().as_secs_f64() >= limit)
    };
    let mut told = (begun, Losses::default());
    let mut ended = Ok(());
    while !is_over() {
        let samples = match stream.next(TICK) {
            Ok(Batch::Samples(samples)) => samples,
            Ok(Batch::End) => break,
            Err(error) => {
                ended = Err(error);
                break;
            }
        };
        recorder.push(&samples).map_err(|error| failed(&error, &recorder.recorded()))?;
        let losses = stream.losses();
        if losses != told.1 && told.0.elapsed() >= NOTE {
            terminal.note(&format!("lost so far: {losses}"));
            told = (Instant::now(), losses);
        }
    }
    let before = recorder.recorded();
    let recorded = recorder.finish().map_err(|error| failed(&error, &before))?;
    if let Some(fault) = stream.first_fault() {
        terminal.note(&format!("the first fault: {fault}"));
    }
    if let Err(error) = ended {
        if recorded.samples == 0 {
            // Nothing was written but a head. If it cannot be removed, it does no harm.
            recorded.files.iter().filter(|file| file.is_file()).for_each(|file| drop(std::fs::remove_file(file)));
        } else {
            terminal.say(&summary(&recorded, stream.losses()))?;
        }
        return Err(error.into());
    }
    terminal.say(&summary(&recorded, stream.losses()))?;
    Ok(Ending::Success)
}

/// What was recorded and what was not, in two lines.
fn summary(recorded: &Recorded, losses: Losses) -> String {
    let first = recorded.files.first().map_or_else(String::new, |file| file.display().to_string());
    let files = match recorded.files.len() {
        0 | 1 => first,
        count => format!("{first} and {} more", count - 1),
    };
    format!("{files}: {} samples, {:.1} s\nlost: {losses}", recorded.samples, recorded.duration_s)
}

/// The failure of a recording, with what is safe.
fn failed(error: &RecordError, recorded: &Recorded) -> Failure {
    Failure::Other(format!("{error}; the {} samples before that are kept", recorded.samples))
}

impl From<SourceError> for Failure {
    fn from(error: SourceError) -> Self {
        match error {
            SourceError::Io { .. } => Self::Other(error.to_string()),
            _ => Self::Input(error.to_string()),
        }
    }
}

impl From<RecordError> for Failure {
    fn from(error: RecordError) -> Self {
        match error {
            RecordError::Io { .. } => Self::Other(error.to_string()),
            _ => Self::Input(error.to_string()),
        }
    }
}
