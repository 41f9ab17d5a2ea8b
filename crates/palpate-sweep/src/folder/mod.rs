//! The folder of a sweep at work: each finished job goes into its journal, and the tables are written when all are finished.

pub mod journal;
pub mod table;

use std::num::NonZero;
use std::path::{Path, PathBuf};

use crate::digest::Digest;
use crate::folder::journal::{Header, Journal};
use crate::job::Outcome;
use crate::sweep::{Done, Sweep};
use crate::sweep_error::SweepError;

impl Sweep {
    /// Does all jobs that are not finished yet in the folder `dir`, made if missing, keeps each in its journal, and writes the
    /// [tables](table) when all are done. Outcomes come in the order of the jobs.
    ///
    /// # Errors
    /// The folder belongs to another sweep, another program is at work in it, or it cannot be written.
    pub fn run_in(
        &self,
        dir: &Path,
        threads: NonZero<usize>,
        progress: &mut dyn FnMut(Done),
    ) -> Result<Vec<Outcome>, SweepError> {
        let mut folder = self.open(dir)?;
        progress(folder.done());
        self.each(&folder.todo(), threads, &mut |outcome| {
            folder.keep(outcome)?;
            progress(folder.done());
            Ok(())
        })?;
        folder.finish()
    }

    /// Opens the folder `dir`, made if missing, for this sweep, to be handed what comes of its jobs.
    ///
    /// # Errors
    /// The folder belongs to another sweep, another program is at work in it, or it cannot be written.
    pub fn open(&self, dir: &Path) -> Result<SweepFolder, SweepError> {
        SweepFolder::open(dir, &self.header()?, self.jobs.len())
    }

    /// Which sweep this is: the same for the same jobs on the same logs with the same version of palpate.
    fn header(&self) -> Result<Header, SweepError> {
        let mut digest = Digest::new();
        for job in &self.jobs {
            let json = serde_json::to_vec(job).map_err(|error| SweepError::Encode(error.to_string()))?;
            digest = digest.with(&json);
        }
        Ok(Header { version: env!("CARGO_PKG_VERSION").to_owned(), jobs: self.jobs.len() as u64, digest: digest.hex() })
    }
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
