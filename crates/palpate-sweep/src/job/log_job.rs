//! A job that begins with a recorded log, and the truth beside it if there is one.

use std::path::Path;

use palpate::compare::true_support;
use palpate::{Log, Truth};
use palpate_io::RigFile;
use serde::{Deserialize, Serialize};

use crate::digest::Digest;

/// A log to reconstruct.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct LogJob {
    /// Path of the log from the folder of the plan, with `/` between names.
    pub log: String,
    /// Whether a truth folder lies beside it.
    pub truth: bool,
    /// Digest of all these files when the sweep was planned: a log that has changed makes another sweep.
    pub digest: String,
    /// The rig that wrote it, as a comment `# rig:` has it; `None` for what the log says of itself, or else the default tolerances.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rig: Option<String>,
}

impl LogJob {
    /// The log of this path from the folder `base`.
    pub(crate) fn new(base: &Path, log: String, rig: Option<String>) -> Self {
        let path = base.join(&log);
        let dir = palpate_io::truth_dir_of(&path);
        let truth = dir.is_dir();
        let mut digest = Digest::new();
        let files = [path, dir.join("shape.csv"), dir.join("motion.csv")];
        for file in &files[..if truth { 3 } else { 1 }] {
            // What cannot be read is told in the row of the job.
            let content = std::fs::read(file).unwrap_or_default();
            digest = digest.with(&(content.len() as u64).to_le_bytes()).with(&content);
        }
        Self { log, truth, digest: digest.hex(), rig }
    }

    /// Whether log and truth in the folder `base` are those that the sweep was planned with.
    pub(crate) fn is_as_planned(&self, base: &Path) -> bool {
        Self::new(base, self.log.clone(), self.rig.clone()) == *self
    }

    /// Reads the log, by what is known of its rig, and its truth; or says why they cannot be used.
    pub(crate) fn read(&self, base: &Path) -> Result<(Log, RigFile, Option<Truth>), String> {
        let path = base.join(&self.log);
        let (log, rig) = self.read_by_rig(&path).map_err(|error| without_folder(&error, base))?;
        if !self.truth {
            return Ok((log, rig, None));
        }
        let dir = palpate_io::truth_dir_of(&path);
        let truth = palpate_io::read_truth(&dir).map_err(|error| without_folder(&error.to_string(), base))?;
        let (poses, samples) = (truth.motion.len(), log.samples.len());
        if poses != samples {
            return Err(format!("the truth has {poses} poses, the log {samples} samples; they do not belong together"));
        }
        true_support(&truth).map_err(|error| format!("the true shape is unusable: {error}"))?;
        Ok((log, rig, Some(truth)))
    }

    fn read_by_rig(&self, path: &Path) -> Result<(Log, RigFile), String> {
        if let Some(comment) = &self.rig {
            let rig = palpate_io::parse_rig_comment(&self.log, comment).map_err(|error| error.to_string())?;
            let file = palpate_io::read_log_as(path, &rig.conventions).map_err(|error| error.to_string())?;
            return Ok((file.log, rig));
        }
        let (file, said) = palpate_io::read_log_with_rig(path).map_err(|error| error.to_string())?;
        Ok((file.log, said.unwrap_or_default()))
    }
}

/// A message that is the same wherever the logs lie.
fn without_folder(message: &str, base: &Path) -> String {
    let folder = format!("{}{}", base.display(), std::path::MAIN_SEPARATOR);
    message.replace(&folder, "")
}
