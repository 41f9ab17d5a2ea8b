//! `palpate watch` on two palms.

use std::path::Path;
use std::time::Instant;

use palpate::live::Live;
use palpate::reconstruct::{ReconstructOptions, Reconstructor};
use palpate::{Log, Sample};
use palpate_io::{LogFile, RigFile, Summary};
use palpate_live::{Losses, Moment};

use super::kept::Kept;
use super::serve::Server;
use super::view::Seen;
use super::{Arguments, Watched, line};
use crate::reconstruct::{Job, solve, told};
use crate::terminal::{Failure, Terminal, print};

/// A stream from its first sample.
pub struct WatchedPalms {
    rig: RigFile,
    live: Live,
    newest: Option<Sample>,
}

impl Watched for WatchedPalms {
    type Sample = Sample;

    fn check_target(out: &Path) -> Result<(), Failure> {
        Ok(palpate_io::check_result_target(out)?)
    }

    fn new(known: Option<RigFile>) -> Self {
        let rig = known.unwrap_or_default();
        Self { live: Live::new(options(&rig)), newest: None, rig }
    }

    /// As the rig has it.
    fn push(&mut self, sample: &Sample, kept: &mut Kept<Sample>) -> Result<(), Failure> {
        for sample in &self.rig.conventions.apply(&Log { samples: vec![*sample] }).samples {
            let estimate = self.live.push(sample);
            self.newest = Some(*sample);
            kept.show(sample, || Moment::of_palms(sample, estimate), || line::of(estimate))?;
        }
        Ok(())
    }

    fn line(&self) -> String {
        line::of(self.live.estimate())
    }

    fn seen(&self) -> Seen<'_> {
        Seen::from(self.live.estimate())
    }

    fn show(&self, server: &Server, losses: Losses, rate_hz: f64) {
        if let Some(newest) = &self.newest {
            server.show(newest, self.live.estimate(), losses, rate_hz);
        }
    }

    fn finish(self, arguments: &Arguments, terminal: &Terminal) -> Result<bool, Failure> {
        let Self { rig, live, .. } = self;
        if live.kept_every() > 1 {
            terminal.note(&format!("the result is of one sample in {}", live.kept_every()));
        }
        let log = live.log().clone();
        drop(live);
        let summary = result(arguments, &rig, log, terminal)?;
        if arguments.json {
            print(&line::last(summary.to_json())?)?;
        } else {
            let shown = arguments.out.clone().unwrap_or_default();
            let text = told(&summary, &shown);
            // Without a folder there is no report to open.
            let lines = text.lines().filter(|line| arguments.out.is_some() || !line.starts_with("  report"));
            terminal.say(&lines.collect::<Vec<_>>().join("\n"))?;
        }
        Ok(summary.certified)
    }
}

/// What `palpate reconstruct` makes of the samples, written where a folder is given.
fn result(arguments: &Arguments, rig: &RigFile, log: Log, terminal: &Terminal) -> Result<Summary, Failure> {
    let name = arguments.source.to_string();
    let file = LogFile { log, metadata: Vec::new(), notes: Vec::new() };
    let reconstructor = Reconstructor::from(options(rig));
    let Some(out) = &arguments.out else {
        let started = Instant::now();
        let found = reconstructor.run_or_name_mistake(&file.log)?;
        return Ok(Summary::new(&found, started.elapsed().as_secs_f64()));
    };
    let job = Job {
        file: &file,
        name: Some(&name),
        title: &name,
        truth: None,
        reconstructor,
        min_touches: 1,
        diagnostics: false,
        animation: None,
        out,
    };
    solve(&job, terminal)
}

/// As of `palpate reconstruct`.
fn options(rig: &RigFile) -> ReconstructOptions {
    ReconstructOptions::default().with_rig(rig.rig).with_sensor_sd_m(rig.reading_sd_m())
}
