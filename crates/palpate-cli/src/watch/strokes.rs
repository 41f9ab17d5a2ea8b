//! `palpate watch` on strokes of a pivoting grasp.

use std::path::Path;

use palpate::pivot::{LiveStrokes, PadPose, PivotOptions, PivotRig, PivotSample};
use palpate_io::StrokesComments;
use palpate_live::{Losses, Moment};

use super::kept::Kept;
use super::serve::Server;
use super::view::Seen;
use super::{Arguments, Watched, line};
use crate::strokes::{Reconstruct, told};
use crate::terminal::{Failure, Terminal, print};

/// A stream from its first sample.
pub struct WatchedStrokes {
    rig: PivotRig,
    live: LiveStrokes,
    newest: Option<PivotSample>,
}

impl Watched for WatchedStrokes {
    type Sample = PivotSample;

    fn check_target(out: &Path) -> Result<(), Failure> {
        Ok(palpate_io::check_strokes_target(out)?)
    }

    fn new(known: Option<StrokesComments>) -> Self {
        let StrokesComments { rig, swing_period_s } = known.unwrap_or_default();
        let rig = rig.unwrap_or_else(|| PivotRig::uncalibrated(PadPose::default()));
        let live = LiveStrokes::new(PivotOptions::new(rig)).swing_period_s(swing_period_s);
        Self { rig, live, newest: None }
    }

    fn push(&mut self, sample: &PivotSample, kept: &mut Kept<PivotSample>) -> Result<(), Failure> {
        let estimate = self.live.push(sample);
        self.newest = Some(*sample);
        let moment = || Moment::of_strokes(sample, estimate, &self.rig.pad);
        kept.show(sample, moment, || line::of_strokes(estimate))
    }

    fn line(&self) -> String {
        line::of_strokes(self.live.estimate())
    }

    fn seen(&self) -> Seen<'_> {
        Seen::from(self.live.estimate())
    }

    fn show(&self, server: &Server, losses: Losses, rate_hz: f64) {
        if let Some(newest) = &self.newest {
            server.show_strokes(newest, &self.rig.pad, self.live.estimate(), losses, rate_hz);
        }
    }

    fn finish(self, arguments: &Arguments, terminal: &Terminal) -> Result<bool, Failure> {
        let Self { rig, live, .. } = self;
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
            terminal.say(&told(&summary, arguments.out.as_deref()))?;
        }
        Ok(summary.certified)
    }
}
