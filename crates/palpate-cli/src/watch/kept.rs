//! What `palpate watch` writes while it watches: a recording of the samples, and a scene of what is seen.

use palpate_live::{Moment, Recorder, Rotation, SceneWriter};

use super::Arguments;
use crate::live_rig::{LiveRig, metadata};
use crate::terminal::Failure;

/// Both, where they are asked for.
pub struct Kept<S: LiveRig> {
    recorder: Option<Recorder<S>>,
    scene: Option<SceneWriter<S>>,
}

impl<S: LiveRig> Kept<S> {
    /// With what is known of the rig in their heads.
    pub fn create(arguments: &Arguments, known: Option<&S::Rig>) -> Result<Self, Failure> {
        let metadata = metadata::<S>(&arguments.source, known);
        let record = |path| Recorder::create(path, Rotation::default(), &metadata);
        let recorder = arguments.log.as_deref().map(record).transpose()?;
        let scene = arguments.scene.as_deref().map(|path| SceneWriter::create(path, &metadata)).transpose()?;
        Ok(Self { recorder, scene })
    }

    /// Records samples.
    pub fn record(&mut self, samples: &[S]) -> Result<(), Failure> {
        Ok(self.recorder.as_mut().map_or(Ok(()), |recorder| recorder.push(samples))?)
    }

    /// Adds a moment to the scene, and what is known then as a line of JSON.
    pub fn show<'a>(
        &mut self,
        sample: &S,
        moment: impl FnOnce() -> Moment<'a>,
        line: impl FnOnce() -> String,
    ) -> Result<(), Failure> {
        Ok(self.scene.as_mut().map_or(Ok(()), |scene| scene.push(sample, &moment(), line))?)
    }

    /// Ends both.
    pub fn finish(self) -> Result<(), Failure> {
        if let Some(recorder) = self.recorder {
            recorder.finish()?;
        }
        if let Some(scene) = self.scene {
            scene.finish()?;
        }
        Ok(())
    }
}
