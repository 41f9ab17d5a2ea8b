//! The folder of a sweep at work: each finished job goes into its journal, and the tables are written when all are finished.

pub mod journal;
pub mod table;

use std::path::{Path, PathBuf};

use crate::folder::journal::{Header, Journal};
use crate::job::Outcome;
use crate::sweep_error::SweepError;

/// How many jobs are finished.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Done {
    /// So many are, counting those of earlier runs.
    pub finished: u64,
    /// Of so many.
    pub jobs: u64,
}

/// The folder of a sweep, opened by the sweep and locked until it goes. Whoever does the jobs, here or elsewhere, hands each
/// outcome to [`keep`](Self::keep).
#[derive(Debug)]
pub struct SweepFolder {
    dir: PathBuf,
    journal: Journal,
    outcomes: Vec<Option<Outcome>>,
    finished: u64,
}

impl SweepFolder {
    /// Opens the folder `dir`, made if missing, for the sweep of this header, which has so many jobs.
    ///
    /// # Errors
    /// The folder belongs to another sweep, another program is at work in it, or it cannot be written.
    pub(crate) fn open(dir: &Path, header: &Header, jobs: usize) -> Result<Self, SweepError> {
        std::fs::create_dir_all(dir).map_err(|error| SweepError::io(dir, &error))?;
        if !Journal::is_in(dir)
            && let Some(path) = table::FILES.iter().map(|name| dir.join(name)).find(|path| path.exists())
        {
            return Err(SweepError::Foreign { path: path.display().to_string() });
        }
        let (journal, finished) = Journal::open(dir, header)?;
        let mut folder = Self { dir: dir.to_path_buf(), journal, outcomes: vec![None; jobs], finished: 0 };
        for outcome in finished {
            folder.put(outcome);
        }
        Ok(folder)
    }

    /// How many jobs are finished.
    pub fn done(&self) -> Done {
        Done { finished: self.finished, jobs: self.outcomes.len() as u64 }
    }

    /// Numbers of the jobs that are not, in order.
    pub fn todo(&self) -> Vec<u64> {
        (0..).zip(&self.outcomes).filter(|(_, outcome)| outcome.is_none()).map(|(job, _)| job).collect()
    }

    /// Keeps what came of a job. A job that is finished already stays as it is: done twice, it gave the same row.
    ///
    /// # Errors
    /// The journal cannot be written.
    pub fn keep(&mut self, outcome: Outcome) -> Result<(), SweepError> {
        if self.place(&outcome).is_some_and(|place| place.is_none()) {
            self.journal.add(&outcome)?;
            self.put(outcome);
        }
        Ok(())
    }

    /// Writes the [tables](table) and closes the folder. Outcomes come in the order of the jobs.
    ///
    /// # Errors
    /// A job is not finished, or the folder cannot be written.
    pub fn finish(self) -> Result<Vec<Outcome>, SweepError> {
        let Done { finished, jobs } = self.done();
        if finished < jobs {
            return Err(SweepError::Unfinished { dir: self.dir.display().to_string(), missing: jobs - finished });
        }
        let outcomes: Vec<Outcome> = self.outcomes.into_iter().flatten().collect();
        table::write(&self.dir, &outcomes)?;
        Ok(outcomes)
    }

    /// Where the outcome of its job belongs.
    fn place(&mut self, outcome: &Outcome) -> Option<&mut Option<Outcome>> {
        self.outcomes.get_mut(usize::try_from(outcome.row.job).ok()?)
    }

    /// Puts it there.
    fn put(&mut self, outcome: Outcome) {
        if let Some(place) = self.place(&outcome)
            && place.replace(outcome).is_none()
        {
            self.finished += 1;
        }
    }
}
