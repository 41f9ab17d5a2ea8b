//! The second rig of the paper, a pivoting grasp: `palpate reconstruct` on a log of its strokes, and `palpate simulate --rig pivot`.

use std::path::Path;
use std::time::Instant;

use palpate::Truth;
use palpate::pivot::{
    HeldObject, PadPose, PivotLog, PivotOptions, PivotReconstructError, PivotRig, PivotSimulateError,
    PivotSimulateOptions, compare_strokes, reconstruct_strokes, simulate_strokes,
};
use palpate::sensor::Touchpad;
use palpate::shape::SupportFunction;
use palpate_io::StrokesSummary;
use palpate_report::{StrokesInput, StrokesTruthOverlay, strokes_page};

use crate::reconstruct::command_line;
use crate::terminal::{Ending, Failure, Terminal};

/// What is asked of a reconstruction.
pub struct Reconstruct<'a> {
    pub log: &'a PivotLog,
    /// Heading of the report.
    pub title: &'a str,
    /// The result folder, where one is wanted.
    pub out: Option<&'a Path>,
    pub rig: PivotRig,
    pub truth: Option<&'a Truth>,
    pub harmonics: Option<usize>,
}

impl Reconstruct<'_> {
    /// Reconstructs and writes.
    pub fn run(&self) -> Result<StrokesSummary, Failure> {
        let started = Instant::now();
        let found = reconstruct_strokes(self.log, &PivotOptions::new(self.rig).harmonics(self.harmonics))?;
        let seconds = started.elapsed().as_secs_f64();
        let truth = match self.truth {
            Some(truth) => {
                let errors =
                    compare_strokes(&found, truth).map_err(|error| Failure::Input(format!("the truth: {error}")))?;
                Some(StrokesTruthOverlay { truth, errors })
            }
            None => None,
        };
        let summary = StrokesSummary::new(&found, truth.map(|truth| truth.errors).as_ref());
        if let Some(out) = self.out {
            let report = strokes_page(&StrokesInput {
                title: self.title,
                log: self.log,
                rig: &self.rig,
                reconstruction: &found,
                truth,
                seconds,
                command: Some(&command_line()),
                version: env!("CARGO_PKG_VERSION"),
            });
            palpate_io::write_strokes_result(out, &found, &summary, &report)?;
        }
        Ok(summary)
    }
}

/// The rig of a file; without one it is exact, or what the log says, or an ordinary one that nobody calibrated, with a level pad in the origin.
pub fn rig(path: Option<&Path>, is_exact: bool, said: Option<PivotRig>) -> Result<PivotRig, Failure> {
    Ok(match path {
        Some(path) => palpate_io::read_pivot_rig(path)?,
        None if is_exact => PivotRig::exact(PadPose::default()),
        None => said.unwrap_or_else(|| PivotRig::uncalibrated(PadPose::default())),
    })
}

/// The summary in a few lines.
pub fn told(summary: &StrokesSummary, out: Option<&Path>) -> String {
    let mut lines = vec![if summary.certified {
        "certified: shape about the pivot and motion".to_owned()
    } else {
        "NOT certified".to_owned()
    }];
    for reason in &summary.reasons {
        lines.push(format!("  - {}", reason.message));
        lines.push(format!("    {}", reason.next_step));
    }
    lines.push(format!(
        "  shape   mean radius {:.3} mm, felt boundary known to {:.3} mm (one standard deviation, as all below)",
        1e3 * summary.mean_radius_m,
        1e3 * summary.r_sd_m.unwrap_or(f64::NAN)
    ));
    lines.push(format!(
        "  felt    {:.0} % of the boundary in {} samples of {}, {} segments; noise of the pad {:.3} mm, of the arm {:.3} mm",
        100.0 * summary.coverage,
        summary.placed,
        summary.samples,
        summary.segments,
        1e3 * summary.sensor_sd_m,
        1e3 * summary.arm_sd_m
    ));
    let height_mm = 1e3 * summary.calibration_sd.height_sd_m;
    if height_mm > 0.0 {
        lines.push(format!(
            "  size    known to {height_mm:.3} mm all around, as the height of the pad is: no log tells more"
        ));
    }
    lines.push(match &summary.center_of_mass {
        Some(center) => {
            let distance = center.distance_m.map_or_else(String::new, |m| format!(", {:.2} mm from it", 1e3 * m));
            format!(
                "  mass    its centre lies at {:.1} ± {:.1} deg from the pivot{distance}",
                center.direction_rad.to_degrees(),
                center.direction_sd_rad.to_degrees()
            )
        }
        None => "  mass    its centre is not told: let the object hang at rest before each stroke".to_owned(),
    });
    if let Some(truth) = &summary.truth {
        lines.push(format!(
            "  truth   r is off by {:.4} mm, the orientation by {:.2} deg (root mean square)",
            1e3 * truth.rms_r_m,
            truth.rms_psi_rad.to_degrees()
        ));
    }
    lines.extend(out.map(|out| format!("  report  {}", out.join("report.html").display())));
    lines.join("\n")
}

/// What is asked of a simulation.
pub struct Simulate<'a> {
    pub out: &'a Path,
    /// About its centre of mass.
    pub shape: &'a SupportFunction,
    /// Where the pivot is from there.
    pub pivot_m: Option<[f64; 2]>,
    pub touchpad: Touchpad,
    pub friction: Option<f64>,
    /// A file of strokes, in place of the usual ones.
    pub strokes: Option<&'a Path>,
    pub rate_hz: f64,
    pub seed: u64,
    pub name: String,
}

impl Simulate<'_> {
    /// Simulates and writes the log and the truth.
    pub fn run(self, terminal: &Terminal) -> Result<Ending, Failure> {
        let held = HeldObject::new(self.shape, self.pivot_m, self.touchpad, self.friction);
        let strokes = self.strokes.map(palpate_io::read_planned_strokes).transpose()?;
        let strokes = strokes.unwrap_or_else(|| held.usual_strokes());
        let options = PivotSimulateOptions { rate_hz: self.rate_hz, seed: self.seed, ..held.options };
        let simulation = simulate_strokes(&held.about_pivot, &strokes, &options)?;
        let truth_dir = palpate_io::truth_dir_of(self.out);
        palpate_io::write_truth(&truth_dir, &simulation.truth)?;
        let metadata = [("made by", format!("palpate simulate {}", env!("CARGO_PKG_VERSION"))), ("shape", self.name)];
        palpate_io::write_strokes(self.out, &simulation.log, &metadata)?;
        let felt = simulation.log.samples.iter().filter(|sample| sample.s_m.is_some()).count();
        let strokes = match strokes.len() {
            1 => "1 stroke".to_owned(),
            count => format!("{count} strokes"),
        };
        terminal.say(&format!(
            "{}: {strokes}, {} samples, {felt} with a contact\n{}: its truth (about the pivot)",
            self.out.display(),
            simulation.log.samples.len(),
            truth_dir.display()
        ))?;
        Ok(Ending::Success)
    }
}

/// The usual strokes over a pad, and the shape about the pivot.
#[cfg(feature = "paper")]
pub fn simulated(
    shape: &SupportFunction,
    touchpad: Touchpad,
    rate_hz: f64,
    seed: u64,
) -> Result<(SupportFunction, palpate::pivot::PivotSimulation), Failure> {
    let held = HeldObject::new(shape, None, touchpad, None);
    let options = PivotSimulateOptions { rate_hz, seed, ..held.options.clone() };
    let simulation = simulate_strokes(&held.about_pivot, &held.usual_strokes(), &options)?;
    Ok((held.about_pivot, simulation))
}

impl From<PivotReconstructError> for Failure {
    fn from(error: PivotReconstructError) -> Self {
        Self::Input(error.to_string())
    }
}

impl From<PivotSimulateError> for Failure {
    fn from(error: PivotSimulateError) -> Self {
        Self::Input(error.to_string())
    }
}
