//! `palpate watch` on strokes of a pivoting grasp.

use std::path::Path;

use palpate::pivot::{LiveStrokes, PadPose, PivotOptions, PivotRig, PivotSample};
use palpate_io::StrokesComments;
use palpate_live::{Losses, Moment, Recorder, Rotation, SceneWriter};

use super::serve::Server;
use super::view::Seen;
use super::{Arguments, Watched, line};
use crate::live_rig::metadata;
use crate::strokes::{Reconstruct, told};
use crate::terminal::{Failure, Terminal, print};

/// A stream from its first sample.
pub struct WatchedStrokes {
    rig: PivotRig,
    live: LiveStrokes,
    newest: Option<PivotSample>,
    recorder: Option<Recorder<PivotSample>>,
    scene: Option<SceneWriter<PivotSample>>,
}

impl Watched for WatchedStrokes {
    type Sample = PivotSample;

    fn check_target(out: &Path) -> Result<(), Failure> {
        Ok(palpate_io::check_strokes_target(out)?)
    }

    fn new(arguments: &Arguments, known: Option<StrokesComments>) -> Result<Self, Failure> {
        let StrokesComments { rig, swing_period_s } = known.unwrap_or_default();
        let rig = rig.unwrap_or_else(|| PivotRig::uncalibrated(PadPose::default()));
        let metadata = metadata::<PivotSample>(&arguments.source, known.as_ref());
        let record = |path| Recorder::create(path, Rotation::default(), &metadata);
        let recorder = arguments.log.as_deref().map(record).transpose()?;
        let scene = arguments.scene.as_deref().map(|path| SceneWriter::create(path, &metadata)).transpose()?;
        let live = LiveStrokes::new(PivotOptions::new(rig)).swing_period_s(swing_period_s);
        Ok(Self { rig, live, newest: None, recorder, scene })
    }

    fn record(&mut self, samples: &[PivotSample]) -> Result<(), Failure> {
        Ok(self.recorder.as_mut().map_or(Ok(()), |recorder| recorder.push(samples))?)
    }

    fn push(&mut self, sample: &PivotSample) -> Result<(), Failure> {
        let estimate = self.live.push(sample);
        self.newest = Some(*sample);
        if let Some(scene) = &mut self.scene {
            let moment = Moment::of_strokes(sample, estimate, &self.rig.pad);
            scene.push(sample, &moment, || line::of_strokes(estimate))?;
        }
        Ok(())
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
        let Self { rig, live, recorder, scene, .. } = self;
        if let Some(recorder) = recorder {
            recorder.finish()?;
        }
        if let Some(scene) = scene {
            scene.finish()?;
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
            terminal.say(&told(&summary, arguments.out.as_deref()))?;
        }
        Ok(summary.certified)
    }
}
