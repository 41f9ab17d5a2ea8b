//! A sweep: its jobs, run here or in a folder from which it goes on after a kill.

use std::num::NonZero;
use std::path::{Path, PathBuf};

use crate::digest::Digest;
use crate::job::{Job, Outcome};
use crate::journal::{Header, Journal};
use crate::plan::Plan;
use crate::plan_error::PlanError;
use crate::sweep_error::SweepError;
use crate::{table, threads, unfold};

/// A list of jobs.
#[derive(Clone, Debug, PartialEq)]
pub struct Sweep {
    /// The jobs, in the order of the table.
    pub jobs: Vec<Job>,
    /// The folder from which logs are looked for.
    pub base: PathBuf,
}

/// How many jobs are finished.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Done {
    /// So many are, counting those of earlier runs.
    pub finished: u64,
    /// Of so many.
    pub jobs: u64,
}

impl Sweep {
    /// The jobs of a plan that lies in the folder `base`.
    ///
    /// # Errors
    /// Nothing to do, a log that is not there, or too much of everything.
    pub fn new(plan: &Plan, base: &Path) -> Result<Self, PlanError> {
        Ok(Self { jobs: unfold::jobs(plan, base)?, base: base.to_path_buf() })
    }

    /// Does one job, here and now; `None` when there is no job of that number.
    pub fn outcome(&self, index: u64) -> Option<Outcome> {
        let job = self.jobs.get(usize::try_from(index).ok()?)?;
        Some(job.run(index, &self.base))
    }

    /// Does all jobs on `threads` threads; outcomes in the order of the jobs. `progress` is told before the first job and after
    /// each.
    ///
    /// # Errors
    /// No threads can be had.
    pub fn run(&self, threads: NonZero<usize>, progress: &mut dyn FnMut(Done)) -> Result<Vec<Outcome>, SweepError> {
        self.rest(Vec::new(), threads, progress, &mut |_| Ok(()))
    }

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
        std::fs::create_dir_all(dir).map_err(|error| SweepError::io(dir, &error))?;
        if !Journal::is_in(dir)
            && let Some(path) = table::FILES.iter().map(|name| dir.join(name)).find(|path| path.exists())
        {
            return Err(SweepError::Foreign { path: path.display().to_string() });
        }
        let (mut journal, finished) = Journal::open(dir, &self.header()?)?;
        let outcomes = self.rest(finished, threads, progress, &mut |outcome| journal.add(outcome))?;
        table::write(dir, &outcomes)?;
        Ok(outcomes)
    }

    /// Does what is not finished.
    fn rest(
        &self,
        finished: Vec<Outcome>,
        threads: NonZero<usize>,
        progress: &mut dyn FnMut(Done),
        keep: &mut dyn FnMut(&Outcome) -> Result<(), SweepError>,
    ) -> Result<Vec<Outcome>, SweepError> {
        let mut outcomes: Vec<Option<Outcome>> = vec![None; self.jobs.len()];
        for outcome in finished {
            if let Some(place) = outcomes.get_mut(outcome.row.job as usize) {
                *place = Some(outcome);
            }
        }
        let todo: Vec<(u64, &Job)> =
            (0..).zip(&self.jobs).zip(&outcomes).filter(|(_, outcome)| outcome.is_none()).map(|(job, _)| job).collect();
        let jobs = self.jobs.len() as u64;
        let mut done = Done { finished: jobs - todo.len() as u64, jobs };
        progress(done);
        threads::each(&todo, &self.base, threads, &mut |outcome| {
            keep(&outcome)?;
            done.finished += 1;
            progress(done);
            if let Some(place) = outcomes.get_mut(outcome.row.job as usize) {
                *place = Some(outcome);
            }
            Ok(())
        })?;
        Ok(outcomes.into_iter().flatten().collect())
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
