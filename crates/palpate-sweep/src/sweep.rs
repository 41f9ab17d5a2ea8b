//! A sweep: its jobs, run here or in a folder from which it goes on after a kill.

use std::num::NonZero;
use std::path::{Path, PathBuf};

use crate::job::{Job, Outcome};
use crate::plan::Plan;
use crate::plan::plan_error::PlanError;
use crate::plan::unfold;
use crate::sweep_error::SweepError;
use crate::threads;

/// How many jobs are finished.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Done {
    /// So many are, counting those of earlier runs.
    pub finished: u64,
    /// Of so many.
    pub jobs: u64,
}

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
}
