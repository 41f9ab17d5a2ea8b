//! A job: plain data that gives the same row wherever it is run.

use std::path::Path;
use std::time::Instant;

use palpate::sensor::Touchpad;
use serde::{Deserialize, Serialize};

use crate::log_job::LogJob;
use crate::row::Row;
use crate::score::{Known, ReconstructChoice, ScoreChoice, score};
use crate::simulate_job::SimulateJob;

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
        let reconstruct_s = match &self.source {
            Source::Simulate(job) => self.simulate(job, &mut row),
            Source::Log(job) => self.read(job, base, &mut row),
        };
        Outcome { row, reconstruct_s, job_s: clock.elapsed().as_secs_f64() }
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
