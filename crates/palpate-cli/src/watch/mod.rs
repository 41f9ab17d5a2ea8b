//! `palpate watch`: shape, pose and centre of mass while the samples come.

mod kept;
mod line;
mod palms;
mod serve;
mod strokes;
mod view;

use std::io::IsTerminal;
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use palpate_live::{Address, Batch, Head, Losses, RigKind, RigSample, Stream};

use crate::live_rig::LiveRig;
use crate::terminal::{Ending, Failure, Terminal, print};

use kept::Kept;
use palms::WatchedPalms;
use serve::Server;
use strokes::WatchedStrokes;
use view::{Seen, View};

const AFTER_HELP: &str = "\
SOURCE is as for `palpate record`: FILE.csv (followed until Ctrl-C), - (CSV lines on standard input), serial:PORT, evdev:PADS, mcap:FILE, sim:PLAN.toml.

The samples may be those of two palms, or strokes of a pivoting grasp: CSV lines with time_s, pivot_x_m, pivot_y_m and s_m, serial:PORT?rig=pivot, a
recording or a bag of strokes, a plan with motion = \"strokes\". Then --rig takes a file of that rig (docs/formats.md).

At the end of the source, or at Ctrl-C, what was felt is reconstructed once more as `palpate reconstruct` does it, and told. Estimates before that
are of the same estimator: a search over the samples so far now and then, and a filter in between (docs/live.md).

Examples:
  palpate watch sim:plan.toml
  palpate watch sim:plan.toml --serve                       a page at http://127.0.0.1:8377/
  palpate watch serial:/dev/ttyUSB0 --serve 0.0.0.0:8377    the same for other machines; the address with its token is printed
  palpate watch serial:/dev/ttyUSB0 --rig rig.toml --log trial.csv -o trial
  palpate watch sim:plan.toml --scene trial.mcap            a scene for Foxglove or Rerun
  robot | palpate watch - --json | jq .psi_rad
  robot | palpate watch - --log strokes.csv --serve         strokes over one pad, recorded and shown

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
    /// Write what is seen as a scene for Foxglove and Rerun: palms or pad, contacts, boundary, pose, estimates, and the samples, so that it is a log
    /// as well
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

/// What of watching is a rig's own.
trait Watched: Sized {
    /// What comes.
    type Sample: LiveRig;

    /// Refuses a place where no result may be written.
    fn check_target(out: &Path) -> Result<(), Failure>;

    /// From the first sample on, by what is known of the rig; else by an ordinary one.
    fn new(known: Option<<Self::Sample as RigSample>::Rig>) -> Self;

    /// Takes a sample in, and adds what is seen then to the scene that is kept.
    fn push(&mut self, sample: &Self::Sample, kept: &mut Kept<Self::Sample>) -> Result<(), Failure>;

    /// What is known now, as a line of JSON.
    fn line(&self) -> String;

    /// What is known now, to look at.
    fn seen(&self) -> Seen<'_>;

    /// Shows what is known now on the page.
    fn show(&self, server: &Server, losses: Losses, rate_hz: f64);

    /// Reconstructs what was felt as `palpate reconstruct` does it, and tells it; whether it is certified.
    fn finish(self, arguments: &Arguments, terminal: &Terminal) -> Result<bool, Failure>;
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
    match arguments.source.rig_kind(&head) {
        RigKind::Palms => of_rig::<WatchedPalms>(arguments, head, server.as_ref(), terminal),
        RigKind::Pivot => of_rig::<WatchedStrokes>(arguments, head, server.as_ref(), terminal),
    }
}

fn of_rig<W: Watched>(
    arguments: &Arguments,
    head: Head,
    server: Option<&Server>,
    terminal: Terminal,
) -> Result<Ending, Failure> {
    if let Some(out) = &arguments.out {
        W::check_target(out)?;
    }
    let stated = match &arguments.rig {
        Some(path) => Some(W::Sample::read(path)?),
        None => arguments.calibrated.then(W::Sample::exact),
    };
    let conventions = stated.as_ref().map(W::Sample::conventions);
    let stopped = interruption()?;
    let source = arguments.source.open_after::<W::Sample>(head, conventions)?;
    let stream = Stream::start(source, conventions)?;
    let mut watch = Watch::<W> { arguments, stream, stated, terminal, server, watched: None };
    let ended = watch.follow(&stopped);
    let ended = watch.finish(ended);
    if let Some(server) = server {
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

/// A stream that is watched.
struct Watch<'a, W: Watched> {
    arguments: &'a Arguments,
    stream: Stream<W::Sample>,
    /// The rig, where it was stated.
    stated: Option<<W::Sample as RigSample>::Rig>,
    terminal: Terminal,
    server: Option<&'a Server>,
    /// From the first sample on, with what is written meanwhile.
    watched: Option<(W, Kept<W::Sample>)>,
}

impl<W: Watched> Watch<'_, W> {
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
            let (watched, kept) = match &mut self.watched {
                Some(watched) => watched,
                None => {
                    let known = W::Sample::known(self.stated, self.stream.rig());
                    let kept = Kept::create(self.arguments, known.as_ref())?;
                    self.watched.insert((W::new(known), kept))
                }
            };
            kept.record(&samples)?;
            for sample in &samples {
                watched.push(sample, kept)?;
                if self.arguments.json {
                    print(&watched.line())?;
                }
                let (time_s, psi_rad) = watched.seen().time_and_psi();
                view.take(time_s, psi_rad);
                if stopped.load(Ordering::SeqCst) {
                    break;
                }
            }
            if shown.elapsed() >= if view.is_redrawn() { TICK } else { LINE } {
                shown = Instant::now();
                view.show(|| watched.seen(), self.stream.losses())?;
            }
            if published.elapsed() >= TICK {
                published = Instant::now();
                if let Some(server) = self.server {
                    watched.show(server, self.stream.losses(), view.rate_hz());
                }
            }
        }
        if let Some((watched, _)) = &self.watched {
            view.show(|| watched.seen(), self.stream.losses())?;
            if let Some(server) = self.server {
                watched.show(server, self.stream.losses(), view.rate_hz());
            }
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
        let Some((watched, kept)) = watched else {
            ended?;
            return Err(Failure::Input(format!("{}: no sample came", arguments.source)));
        };
        kept.finish()?;
        let is_certified = watched.finish(arguments, &terminal)?;
        ended?;
        Ok(if is_certified { Ending::Success } else { Ending::NotCertified })
    }
}
