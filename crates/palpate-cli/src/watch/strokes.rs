//! `palpate watch` on strokes of a pivoting grasp: CSV lines of a pipe, or of a file that grows.

use std::io::IsTerminal;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use palpate::pivot::{LiveStrokes, PivotOptions};
use palpate_live::{Batch, Head, StrokesStream};

use super::view::{Seen, View};
use super::{Arguments, LINE, TICK, interruption, line};
use crate::strokes::{self, Reconstruct};
use crate::terminal::{Ending, Failure, Terminal, print};

/// Watches until there is an end, and tells what came of it.
pub fn run(arguments: &Arguments, head: Head) -> Result<Ending, Failure> {
    refuse(arguments)?;
    if let Some(out) = &arguments.out {
        palpate_io::check_strokes_target(out)?;
    }
    let terminal = Terminal::new(arguments.quiet);
    let rig = strokes::rig(arguments.rig.as_deref(), arguments.calibrated)?;
    let stopped = interruption()?;
    let mut stream = StrokesStream::start(&arguments.source, head)?;
    let mut live = LiveStrokes::new(PivotOptions::new(rig)).swing_period_s(stream.swing_period_s());
    let ended = follow(arguments, &mut stream, &mut live, &stopped);
    if let Some(fault) = stream.first_fault() {
        terminal.note(&format!("the first fault: {fault}"));
    }
    if !stream.losses().is_none() {
        terminal.note(&format!("lost: {}", stream.losses()));
    }
    if live.estimate().samples == 0 {
        ended?;
        return Err(Failure::Input(format!("{}: no sample came", arguments.source)));
    }
    if live.kept_every() > 1 {
        terminal.note(&format!("the result is of one sample in {}", live.kept_every()));
    }
    let asked = Reconstruct {
        log: live.log(),
        title: &arguments.source.to_string(),
        out: arguments.out.as_deref(),
        rig,
        truth: None,
        harmonics: None,
    };
    let summary = asked.run()?;
    if arguments.json {
        print(&line::last(summary.to_json())?)?;
    } else {
        terminal.say(&strokes::told(&summary, arguments.out.as_deref()))?;
    }
    ended?;
    Ok(if summary.certified { Ending::Success } else { Ending::NotCertified })
}

/// What there is for palms alone.
fn refuse(arguments: &Arguments) -> Result<(), Failure> {
    let of_palms = [
        (arguments.log.is_some(), "--log", "record the lines beside it, as by tee"),
        (arguments.scene.is_some(), "--scene", "leave it out, or use --json"),
        (arguments.serve.is_some(), "--serve", "leave it out, or use --json"),
    ];
    match of_palms.iter().find(|(given, ..)| *given) {
        Some((_, option, remedy)) => {
            let source = &arguments.source;
            Err(Failure::Input(format!(
                "{source} has strokes of a pivoting grasp, for which there is no {option}; {remedy}"
            )))
        }
        None => Ok(()),
    }
}

/// Takes in samples until the source ends, fails, or is no longer wanted.
fn follow(
    arguments: &Arguments,
    stream: &mut StrokesStream,
    live: &mut LiveStrokes,
    stopped: &AtomicBool,
) -> Result<(), Failure> {
    let mut view = View::new(!arguments.json && !arguments.quiet, std::io::stdout().is_terminal());
    let mut shown = Instant::now();
    while !stopped.load(Ordering::SeqCst) {
        let samples = match stream.next(TICK)? {
            Batch::Samples(samples) => samples,
            Batch::End => break,
        };
        for sample in &samples {
            let estimate = live.push(sample);
            if arguments.json {
                print(&line::of_strokes(estimate))?;
            }
            view.take(estimate.time_s, estimate.psi_rad);
            if stopped.load(Ordering::SeqCst) {
                break;
            }
        }
        if live.estimate().samples > 0 && shown.elapsed() >= if view.is_redrawn() { TICK } else { LINE } {
            shown = Instant::now();
            view.show(|| Seen::from(live.estimate()), stream.losses())?;
        }
    }
    if live.estimate().samples > 0 {
        view.show(|| Seen::from(live.estimate()), stream.losses())?;
    }
    Ok(())
}
