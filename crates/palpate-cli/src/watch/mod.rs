//! `palpate watch`: shape, pose and centre of mass while the samples come.

mod line;
mod serve;
mod strokes;
mod view;

use std::io::IsTerminal;
use std::net::SocketAddr;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use palpate::live::Live;
use palpate::reconstruct::{ReconstructOptions, Reconstructor};
use palpate::{Log, Sample};
use palpate_io::{Conventions, LogFile, RigFile, Summary};
use palpate_live::{Address, Batch, Head, Losses, Recorder, Rotation, SceneWriter, Stream};

use crate::reconstruct::{Job, solve, told};
use crate::record::metadata;
use crate::terminal::{Ending, Failure, Terminal, print};

use serve::Server;
use view::{Seen, View};

const AFTER_HELP: &str = "\
SOURCE is as for `palpate record`: FILE.csv (followed until Ctrl-C), - (CSV lines on standard input), serial:PORT, evdev:PADS, mcap:FILE, sim:PLAN.toml.

CSV lines may be strokes of a pivoting grasp (time_s, pivot_x_m, pivot_y_m, s_m): then --rig takes a file of that rig, and there is no --log, --scene or
--serve (docs/live.md).

At the end of the source, or at Ctrl-C, what was felt is reconstructed once more as `palpate reconstruct` does it, and told. Estimates before that
are of the same estimator: a search over the samples so far now and then, and a filter in between (docs/live.md).

Examples:
  palpate watch sim:plan.toml
  palpate watch sim:plan.toml --serve                       a page at http://127.0.0.1:8377/
  palpate watch serial:/dev/ttyUSB0 --serve 0.0.0.0:8377    the same for other machines; the address with its token is printed
  palpate watch serial:/dev/ttyUSB0 --rig rig.toml --log trial.csv -o trial
  palpate watch sim:plan.toml --scene trial.mcap            a scene for Foxglove or Rerun
  robot | palpate watch - --json | jq .psi_rad
  robot | tee strokes.csv | palpate watch - -o strokes      strokes over one pad, recorded and watched

Exit codes: 0 certified at the end;  3 not certified;  2 bad input or usage, or too few samples;  1 anything else.";

/// Time between two looks at the source where nothing comes, and between two views.
const TICK: Duration = Duration::from_millis(100);
/// Time between two lines where the view is no terminal.
const LINE: Duration = Duration::from_secs(1);

/// See shape, pose and centre of mass while the samples come
#[derive(clap::Args)]
#[command(after_help = AFTER_HELP)]
pub struct Arguments {
    /// Where the samples come from, see below
    #[arg(value_name = "SOURCE")]
    source: Address,
    /// What is known of the rig, a file as `palpate rig --template` prints it [default: what the source says, or else an ordinary rig that nobody
    /// calibrated]
    #[arg(long, value_name = "RIG.toml")]
    rig: Option<PathBuf>,
    /// Take readings as they are: the rig is exact
    #[arg(long, conflicts_with = "rig")]
    calibrated: bool,
    /// Print a line of JSON for each sample, and summary.json with "final": true at the end
    #[arg(long)]
    json: bool,
    /// Record the samples too, as `palpate record` does
    #[arg(long, value_name = "FILE.csv|FILE.mcap")]
    log: Option<PathBuf>,
    /// Write what is seen as a scene for Foxglove and Rerun: palms, contacts, boundary, pose, estimates, and the samples, so that it is a log as well
    #[arg(long, value_name = "FILE.mcap")]
    scene: Option<PathBuf>,
    /// Folder for the result at the end, as of `palpate reconstruct`
    #[arg(short, long = "out", value_name = "DIR")]
    out: Option<PathBuf>,
    /// Serve a page that shows it all to several viewers, until Ctrl-C. On another address than the loopback it asks for the token in the address that is
    /// printed; whoever has that may look, and nothing is encrypted
    #[arg(long, value_name = "ADDR", num_args = 0..=1, default_missing_value = serve::USUAL_ADDRESS)]
    serve: Option<SocketAddr>,
    /// Print nothing but errors
    #[arg(short, long, conflicts_with = "json")]
    quiet: bool,
}

/// Watches until there is an end, and tells what came of it.
pub fn run(arguments: &Arguments) -> Result<Ending, Failure> {
    let terminal = Terminal::new(arguments.quiet);
    // The page is there before the first line comes.
    let server = arguments.serve.map(|address| Server::start(address, &arguments.source.to_string())).transpose()?;
    if let Some(server) = &server {
        terminal.note(&format!("the page is at {}", server.url()));
    }
    let head = Head::of(&arguments.source);
    if head.is_of_strokes() {
        return strokes::run(arguments, head);
    }
    if let Some(out) = &arguments.out {
        palpate_io::check_result_target(out)?;
    }
    let stated = match &arguments.rig {
        Some(path) => Some(palpate_io::read_rig(path)?),
        None => arguments.calibrated.then(RigFile::exact),
    };
    let conventions = stated.as_ref().map(|rig| rig.conventions);
    let stopped = interruption()?;
    let source = arguments.source.open_after(head, conventions)?;
    let stream = Stream::start(source, conventions)?;
    let mut watch = Watch { arguments, stream, stated, terminal, server: server.as_ref(), watched: None };
    let ended = watch.follow(&stopped);
    let ended = watch.finish(ended);
    if let Some(server) = &server {
        server.end(match &ended {
            Ok(Ending::Success) => "certified",
            Ok(_) => "not certified",
            Err(Failure::Input(message) | Failure::Other(message)) => message,
        });
        // Whoever looks may look on.
        while !stopped.load(Ordering::SeqCst) {
            std::thread::sleep(TICK);
        }
    }
    ended
}

/// Becomes true at Ctrl-C.
fn interruption() -> Result<Arc<AtomicBool>, Failure> {
    let stopped = Arc::new(AtomicBool::new(false));
    let stop = Arc::clone(&stopped);
    ctrlc::set_handler(move || stop.store(true, Ordering::SeqCst))
        .map_err(|error| Failure::Other(format!("Ctrl-C cannot be caught: {error}")))?;
    Ok(stopped)
}

struct Watch<'a> {
    arguments: &'a Arguments,
    stream: Stream,
    stated: Option<RigFile>,
    terminal: Terminal,
    server: Option<&'a Server>,
    watched: Option<Watched>,
}

/// A stream from its first sample.
struct Watched {
    rig: RigFile,
    live: Live,
    newest: Option<Sample>,
    recorder: Option<Recorder>,
    scene: Option<SceneWriter>,
}

impl Watch<'_> {
    /// Takes in samples until the source ends, fails, or is no longer wanted.
    fn follow(&mut self, stopped: &AtomicBool) -> Result<(), Failure> {
        let mut view = View::new(!self.arguments.json && !self.arguments.quiet, std::io::stdout().is_terminal());
        let (mut shown, mut published) = (Instant::now(), Instant::now());
        while !stopped.load(Ordering::SeqCst) {
            let samples = match self.stream.next(TICK)? {
                Batch::Samples(samples) => samples,
                Batch::End => break,
            };
            if samples.is_empty() && self.watched.is_none() {
                continue;
            }
            let watched = match &mut self.watched {
                Some(watched) => watched,
                None => {
                    let said = self.stream.rig();
                    let known = self.stated.as_ref().or(said.as_ref());
                    self.watched.insert(Watched::new(self.arguments, known)?)
                }
            };
            if let Some(recorder) = &mut watched.recorder {
                recorder.push(&samples)?;
            }
            for sample in &samples {
                watched.push(sample)?;
                if self.arguments.json {
                    print(&line::of(watched.live.estimate()))?;
                }
                let estimate = watched.live.estimate();
                view.take(estimate.time_s, estimate.pose.as_ref().map(|pose| pose.psi_rad));
                if stopped.load(Ordering::SeqCst) {
                    break;
                }
            }
            if shown.elapsed() >= if view.is_redrawn() { TICK } else { LINE } {
                shown = Instant::now();
                view.show(|| Seen::from(watched.live.estimate()), self.stream.losses())?;
            }
            if published.elapsed() >= TICK {
                published = Instant::now();
                publish(self.server, watched, self.stream.losses(), view.rate_hz());
            }
        }
        if let Some(watched) = &self.watched {
            view.show(|| Seen::from(watched.live.estimate()), self.stream.losses())?;
            publish(self.server, watched, self.stream.losses(), view.rate_hz());
        }
        Ok(())
    }

    /// Reconstructs what was felt, and tells it.
    fn finish(self, ended: Result<(), Failure>) -> Result<Ending, Failure> {
        let Self { arguments, stream, terminal, watched, .. } = self;
        if let Some(fault) = stream.first_fault() {
            terminal.note(&format!("the first fault: {fault}"));
        }
        let losses = stream.losses();
        if !losses.is_none() {
            terminal.note(&format!("lost: {losses}"));
        }
        let Some(Watched { rig, live, recorder, scene, .. }) = watched else {
            ended?;
            return Err(Failure::Input(format!("{}: no sample came", arguments.source)));
        };
        if let Some(recorder) = recorder {
            recorder.finish()?;
        }
        if let Some(scene) = scene {
            scene.finish()?;
        }
        if live.kept_every() > 1 {
            terminal.note(&format!("the result is of one sample in {}", live.kept_every()));
        }
        let log = live.log().clone();
        drop(live);
        let summary = result(arguments, &rig, log, &terminal)?;
        if arguments.json {
            print(&line::last(summary.to_json())?)?;
        } else {
            let shown = arguments.out.clone().unwrap_or_default();
            let text = told(&summary, &shown);
            // Without a folder there is no report to open.
            let lines = text.lines().filter(|line| arguments.out.is_some() || !line.starts_with("  report"));
            terminal.say(&lines.collect::<Vec<_>>().join("\n"))?;
        }
        ended?;
        Ok(if summary.certified { Ending::Success } else { Ending::NotCertified })
    }
}

/// Shows the newest estimate on the page.
fn publish(server: Option<&Server>, watched: &Watched, losses: Losses, rate_hz: f64) {
    if let (Some(server), Some(newest)) = (server, &watched.newest) {
        server.show(newest, watched.live.estimate(), losses, rate_hz);
    }
}

/// What `palpate reconstruct` makes of the samples, written where a folder is given.
fn result(arguments: &Arguments, rig: &RigFile, log: Log, terminal: &Terminal) -> Result<Summary, Failure> {
    let name = arguments.source.to_string();
    let file = LogFile { log, metadata: Vec::new(), notes: Vec::new() };
    let reconstructor = Reconstructor::from(options(rig));
    let Some(out) = &arguments.out else {
        let started = Instant::now();
        let found = reconstructor.run_or_name_mistake(&file.log)?;
        return Ok(Summary::new(&found, started.elapsed().as_secs_f64()));
    };
    let job = Job {
        file: &file,
        name: Some(&name),
        title: &name,
        truth: None,
        reconstructor,
        min_touches: 1,
        diagnostics: false,
        animation: None,
        out,
    };
    solve(&job, terminal)
}

/// As of `palpate reconstruct`.
fn options(rig: &RigFile) -> ReconstructOptions {
    ReconstructOptions::default().with_rig(rig.rig).with_sensor_sd_m(rig.reading_sd_m())
}

impl Watched {
    /// By a rig that was stated or that the source says, or by an ordinary one.
    fn new(arguments: &Arguments, known: Option<&RigFile>) -> Result<Self, Failure> {
        let rig = known.copied().unwrap_or_default();
        let metadata = metadata(&arguments.source, known);
        let record = |path| Recorder::create(path, Rotation::default(), &metadata);
        let recorder = arguments.log.as_deref().map(record).transpose()?;
        let scene = arguments.scene.as_deref().map(|path| SceneWriter::create(path, &metadata)).transpose()?;
        Ok(Self { live: Live::new(options(&rig)), newest: None, recorder, scene, rig })
    }

    /// Takes a sample in, as the rig has it.
    fn push(&mut self, sample: &Sample) -> Result<(), Failure> {
        let conventions: &Conventions = &self.rig.conventions;
        for sample in &conventions.apply(&Log { samples: vec![*sample] }).samples {
            let estimate = self.live.push(sample);
            self.newest = Some(*sample);
            if let Some(scene) = &mut self.scene {
                scene.push(sample, estimate, || line::of(estimate))?;
            }
        }
        Ok(())
    }
}
