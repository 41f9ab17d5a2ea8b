//! A sweep: its jobs, run here or in a folder from which it goes on after a kill.

use std::num::NonZero;
use std::path::{Path, PathBuf};

use crate::digest::Digest;
use crate::folder::journal::Header;
use crate::folder::{Done, SweepFolder};
use crate::job::{Job, Outcome};
use crate::plan::Plan;
use crate::plan::plan_error::PlanError;
use crate::plan::unfold;
use crate::sweep_error::SweepError;
use crate::threads;

/// A list of jobs.
#[derive(Clone, Debug, PartialEq)]
pub struct Sweep {
    /// The jobs, in the order of the table.
    pub jobs: Vec<Job>,
    /// The folder from which logs are looked for.
    pub base: PathBuf,
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
        let jobs = self.jobs.len() as u64;
        let mut outcomes = Vec::with_capacity(self.jobs.len());
        progress(Done { finished: 0, jobs });
        self.each(&(0..jobs).collect::<Vec<_>>(), threads, &mut |outcome| {
            outcomes.push(outcome);
            progress(Done { finished: outcomes.len() as u64, jobs });
            Ok(())
        })?;
        outcomes.sort_by_key(|outcome| outcome.row.job);
        Ok(outcomes)
    }

    /// Does all jobs that are not finished yet in the folder `dir`, made if missing, keeps each in its journal, and writes the
    /// [tables](crate::folder::table) when all are done. Outcomes come in the order of the jobs.
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

    /// Does the jobs of these numbers on `threads` threads and hands each outcome over, on the calling thread, as it comes. An
    /// error there ends the work.
    ///
    /// # Errors
    /// No threads can be had, or `take` failed.
    pub fn each(
        &self,
        numbers: &[u64],
        threads: NonZero<usize>,
        take: &mut dyn FnMut(Outcome) -> Result<(), SweepError>,
    ) -> Result<(), SweepError> {
        let job = |number: u64| self.jobs.get(usize::try_from(number).ok()?).map(|job| (number, job));
        let todo: Vec<(u64, &Job)> = numbers.iter().filter_map(|number| job(*number)).collect();
        threads::each(&todo, &self.base, threads, take)
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
