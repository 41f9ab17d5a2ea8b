//! A job: plain data that gives the same row wherever it is run.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::time::Instant;

use palpate::sensor::Touchpad;
use serde::{Deserialize, Serialize};

use crate::log_job::LogJob;
use crate::row::Row;
use crate::score::{Known, ReconstructChoice, ScoreChoice, score};
use crate::simulate_job::SimulateJob;
use crate::sweep_error::SweepError;

/// Where a log comes from, how it is reconstructed, and what the result is held against.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Job {
    /// Where the log comes from.
    pub source: Source,
    /// How it is reconstructed.
    pub reconstruct: ReconstructChoice,
    /// What the result is held against.
    pub score: ScoreChoice,
}

/// Where a log comes from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Source {
    /// A simulation.
    Simulate(SimulateJob),
    /// A file.
    Log(LogJob),
}

/// What came of a job.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// Its row.
    pub row: Row,
    /// Seconds that the reconstruction took; `None` when there was no log.
    pub reconstruct_s: Option<f64>,
    /// Seconds that the whole job took.
    pub job_s: f64,
}

impl Job {
    /// Does the job, number `index` of its sweep, with logs looked for from the folder `base`.
    pub fn run(&self, index: u64, base: &Path) -> Outcome {
        let clock = Instant::now();
        let mut row = Row { job: index, ..Row::default() };
        let reconstruct_s = panics_told(&mut row, |row| match &self.source {
            Source::Simulate(job) => self.simulate(job, row),
            Source::Log(job) => self.read(job, base, row),
        });
        Outcome { row, reconstruct_s, job_s: clock.elapsed().as_secs_f64() }
    }

    /// The same on a machine other than the one where the sweep was planned, which may see other files.
    ///
    /// # Errors
    /// A log is not there, or is another one.
    pub fn run_elsewhere(&self, index: u64, base: &Path) -> Result<Outcome, SweepError> {
        match &self.source {
            Source::Log(job) if !job.is_as_planned(base) => {
                Err(SweepError::OtherLog { log: job.log.clone(), base: base.display().to_string() })
            }
            _ => Ok(self.run(index, base)),
        }
    }

    fn simulate(&self, job: &SimulateJob, row: &mut Row) -> Option<f64> {
        let pads = job.touchpads;
        row.seed = Some(job.seed);
        row.motion = Some(job.motion.name().to_owned());
        row.noise_sd_m = Some(pads.noise_sd_m);
        row.counts_per_inch = pads.counts_per_inch;
        row.angle_noise_sd_rad = Some(pads.angle_noise_sd_rad);
        row.dropout = Some(pads.dropout);
        match job.simulate() {
            Ok(simulated) => {
                row.object = simulated.object;
                row.jumps = Some(simulated.simulation.jumps.len() as u64);
                let known = Known {
                    log: &simulated.simulation.log,
                    truth: Some(&simulated.simulation.truth),
                    shape: Some(&simulated.shape),
                    sensor_sd_m: Some(Touchpad::from(pads).position_sd_m()),
                };
                Some(score(row, &known, &(&self.reconstruct).into(), self.score))
            }
            Err(error) => {
                row.reason = error.to_string();
                None
            }
        }
    }

    fn read(&self, job: &LogJob, base: &Path, row: &mut Row) -> Option<f64> {
        row.object.clone_from(&job.log);
        match job.read(base) {
            Ok((log, truth)) => {
                let known = Known { log: &log, truth: truth.as_ref(), shape: None, sensor_sd_m: None };
                Some(score(row, &known, &(&self.reconstruct).into(), self.score))
            }
            Err(reason) => {
                row.reason = reason;
                None
            }
        }
    }
}

/// Does the work of one job. If it panics, the row says so, and the other jobs are none the worse for it.
fn panics_told(row: &mut Row, work: impl FnOnce(&mut Row) -> Option<f64>) -> Option<f64> {
    // What a panic leaves behind is the row alone; its verdict is taken back.
    catch_unwind(AssertUnwindSafe(|| work(row))).unwrap_or_else(|panic| {
        let what = panic.downcast_ref::<String>().map(String::as_str).or(panic.downcast_ref::<&str>().copied());
        row.reason = format!("palpate failed on this job ({}); please report it", what.unwrap_or("a panic"));
        row.status = row.status.without_result();
        (row.certified, row.com_certified, row.solved, row.wrong) = (false, false, None, None);
        None
    })
}

#[cfg(test)]
mod tests {
    use super::panics_told;
    use crate::row::{Row, Status};

    #[test]
    fn a_panic_is_a_row_without_a_result() {
        let mut row = Row { job: 7, ..Row::default() };
        let seconds = panics_told(&mut row, |row| {
            (row.status, row.certified, row.samples) = (Status::Reconstructed, true, Some(60));
            panic!("no such {}", "thing")
        });
        let reason = "palpate failed on this job (no such thing); please report it".to_owned();
        let told = Row { job: 7, status: Status::NoResult, samples: Some(60), reason, ..Row::default() };
        assert_eq!((row, seconds), (told, None));

        let mut row = Row::default();
        panics_told(&mut row, |_| panic!("at once"));
        assert_eq!(row.status, Status::NoLog, "there was no log yet");
    }
}
