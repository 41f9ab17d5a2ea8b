//! A job: plain data that gives the same row however often and on however many threads it is run, to the bit on one kind of processor
//! and one platform, to rounding on others.

pub(crate) mod forces;
pub(crate) mod log_job;
pub(crate) mod object;
pub(crate) mod row;
pub(crate) mod score;
pub(crate) mod simulate_job;
pub(crate) mod touchpad;
pub(crate) mod varied;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::time::Instant;

use palpate::reconstruct::{CertificateLimits, ReconstructOptions, Reconstruction};
use palpate::sensor::Touchpad;
use serde::{Deserialize, Serialize};

use crate::job::forces::ForcesJob;
use crate::job::log_job::LogJob;
use crate::job::row::{Row, Status};
use crate::job::score::{Known, ReconstructChoice, ScoreChoice, Scored, TrueForces, score, tell_of_forces};
use crate::job::simulate_job::{NoLog, SimulateJob, Simulated};
use crate::job::varied::VariedJob;
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
    /// A simulation under conditions that are drawn.
    Varied(VariedJob),
    /// A simulation with friction, or with inertia, that is drawn.
    Forces(ForcesJob),
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
        self.run_with(CertificateLimits::default(), index, base).0
    }

    /// The same with these limits of the certificate; also returns the result, of which a row holds only the figures.
    pub fn run_with(&self, limits: CertificateLimits, index: u64, base: &Path) -> (Outcome, Option<Reconstruction>) {
        let clock = Instant::now();
        let mut row = Row { job: index, ..Row::default() };
        let mut options = ReconstructOptions::from(&self.reconstruct);
        options.limits = limits;
        let scored = panics_told(&mut row, |row| match &self.source {
            Source::Simulate(job) => self.simulate(job, &options, row),
            Source::Varied(job) => self.varied(*job, &options, row),
            Source::Forces(job) => self.forces(*job, &options, row),
            Source::Log(job) => self.read(job, base, &options, row),
        });
        let outcome = |reconstruct_s| Outcome { row, reconstruct_s, job_s: clock.elapsed().as_secs_f64() };
        match scored {
            Some(Scored { seconds, found }) => (outcome(Some(seconds)), found),
            None => (outcome(None), None),
        }
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

    fn simulate(&self, job: &SimulateJob, options: &ReconstructOptions, row: &mut Row) -> Option<Scored> {
        let pads = job.touchpads;
        row.seed = Some(job.seed);
        row.motion = Some(job.motion.name().to_owned());
        row.noise_sd_m = Some(pads.noise_sd_m);
        row.counts_per_inch = pads.counts_per_inch;
        row.angle_noise_sd_rad = Some(pads.angle_noise_sd_rad);
        row.dropout = Some(pads.dropout);
        let options = options.clone().with_rig(job.rig.as_deref().copied().unwrap_or_default());
        let simulated = job.simulate();
        if let (Err(_), Ok((object, _))) = (&simulated, job.object.of_seed(job.seed)) {
            // What gave no log is told as well.
            row.object = object;
        }
        self.simulated(simulated, Touchpad::from(pads).position_sd_m(), &options, row)
    }

    fn varied(&self, job: VariedJob, options: &ReconstructOptions, row: &mut Row) -> Option<Scored> {
        let conditions = job.conditions();
        row.seed = Some(job.seed);
        row.motion = Some(conditions.words().0);
        row.noise_sd_m = Some(conditions.sensor.sd_m);
        row.dropout = Some(conditions.sensor.missing);
        self.simulated(job.simulate(), conditions.sensor.sd_m, options, row)
    }

    fn forces(&self, job: ForcesJob, options: &ReconstructOptions, row: &mut Row) -> Option<Scored> {
        let drawn = job.drawn();
        row.seed = Some(job.seed);
        row.noise_sd_m = Some(drawn.noise_sd_m);
        let simulated = job.simulate();
        let even_m = simulated.as_ref().map_or(f64::NAN, |simulated| simulated.shape.uniform_gyration_radius_m());
        let scored = self.simulated(simulated, drawn.noise_sd_m, options, row)?;
        if let Some(found) = &scored.found {
            let gyration_radius_m = drawn.inertia.map(|(gyration, _)| gyration * even_m);
            tell_of_forces(row, found, &TrueForces { friction: drawn.friction, gyration_radius_m });
        }
        Some(scored)
    }

    fn simulated(
        &self,
        simulated: Result<Simulated, NoLog>,
        sensor_sd_m: f64,
        options: &ReconstructOptions,
        row: &mut Row,
    ) -> Option<Scored> {
        match simulated {
            Ok(simulated) => {
                row.object = simulated.object;
                row.jumps = Some(simulated.simulation.jumps.len() as u64);
                let known = Known {
                    log: &simulated.simulation.log,
                    truth: Some(&simulated.simulation.truth),
                    shape: Some(&simulated.shape),
                    sensor_sd_m: Some(sensor_sd_m),
                    calibration: Some(simulated.calibration),
                };
                Some(score(row, &known, options, self.score))
            }
            Err(error) => {
                row.reason = error.to_string();
                None
            }
        }
    }

    fn read(&self, job: &LogJob, base: &Path, options: &ReconstructOptions, row: &mut Row) -> Option<Scored> {
        row.object.clone_from(&job.log);
        match job.read(base) {
            Ok((log, rig, truth)) => {
                let mut options = options.clone().with_rig(rig.rig);
                options.sensor_sd_m = options.sensor_sd_m.or(rig.reading_sd_m());
                let known =
                    Known { log: &log, truth: truth.as_ref(), shape: None, sensor_sd_m: None, calibration: None };
                Some(score(row, &known, &options, self.score))
            }
            Err(reason) => {
                row.reason = reason;
                None
            }
        }
    }
}

/// Does the work of one job. A panic is recorded in the row and does not affect the other jobs.
fn panics_told<T>(row: &mut Row, work: impl FnOnce(&mut Row) -> Option<T>) -> Option<T> {
    // A panic leaves only the row; its verdict is withdrawn.
    catch_unwind(AssertUnwindSafe(|| work(row))).unwrap_or_else(|panic| {
        let what = panic.downcast_ref::<String>().map(String::as_str).or(panic.downcast_ref::<&str>().copied());
        row.reason = format!("palpate failed on this job ({}); please report it", what.unwrap_or("a panic"));
        row.status = Status::Panicked;
        (row.certified, row.com_certified) = (false, false);
        (row.solved, row.wrong, row.beyond_error_bars) = (None, None, None);
        None
    })
}

#[cfg(test)]
mod tests {
    use super::panics_told;
    use crate::job::row::{Row, Status};

    #[test]
    fn a_panic_is_a_row_without_a_result() {
        let mut row = Row { job: 7, ..Row::default() };
        let seconds: Option<f64> = panics_told(&mut row, |row| {
            (row.status, row.certified, row.samples) = (Status::Reconstructed, true, Some(60));
            panic!("no such {}", "thing")
        });
        let reason = "palpate failed on this job (no such thing); please report it".to_owned();
        let told = Row { job: 7, status: Status::Panicked, samples: Some(60), reason, ..Row::default() };
        assert_eq!((row, seconds), (told, None));

        let mut row = Row::default();
        let seconds: Option<f64> = panics_told(&mut row, |_| panic!("at once"));
        assert_eq!(seconds, None);
        assert_eq!(row.status, Status::Panicked);
    }
}
