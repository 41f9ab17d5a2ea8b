//! The second rig of the paper, a pivoting grasp: `palpate reconstruct` on a log of its strokes, and `palpate simulate --rig pivot`.

use std::path::Path;
use std::time::Instant;

use palpate::pivot::{
    PadPose, PivotOptions, PivotReconstructError, PivotRig, PivotSimulateError, PivotSimulateOptions, PivotSimulation,
    Stroke, compare_strokes, reconstruct_strokes, simulate_strokes,
};
use palpate::sensor::Touchpad;
use palpate::shape::SupportFunction;
use palpate_io::StrokesSummary;
use palpate_report::{StrokesInput, StrokesTruthOverlay, strokes_page};

use crate::reconstruct::command_line;
use crate::terminal::{Ending, Failure, Terminal, print};

/// Noise of the arm that is simulated, a fifth of that of the pad.
const ARM_NOISE_SHARE: f64 = 0.2;

/// Strokes that are simulated, as multiples of the mean radius from the middle of the pad: down, there, and back.
const STROKES: [[f64; 3]; 6] =
    [[0.0, 4.5, 3.0], [0.3, -4.0, -2.5], [-0.5, 4.0, 2.0], [0.5, -4.5, -3.0], [0.0, 3.5, 1.5], [-0.3, -3.5, -2.0]];

/// Force with which the arm presses, in weights of the object, and friction where none is asked for.
const PRESS: f64 = 3.0;
const USUAL_FRICTION: f64 = 0.4;

/// Where the pivot is if nothing is said: so many mean radii from the centre of mass. About the middle of a round object no angle is told.
const PIVOT_SHARE: f64 = 0.3;

/// Length of the pad that is simulated where none is stated, in mean radii: for the longest of the strokes, either way.
const PAD_LENGTH: f64 = 20.0;

/// What is asked of a reconstruction.
pub struct Reconstruct<'a> {
    pub log: &'a Path,
    /// Heading of the report.
    pub title: &'a str,
    pub out: &'a Path,
    pub rig: Option<&'a Path>,
    /// Readings are taken as they are.
    pub exact: bool,
    pub truth: Option<&'a Path>,
    pub harmonics: Option<usize>,
    pub sensor_sd_m: Option<f64>,
    pub json: bool,
}

impl Reconstruct<'_> {
    /// Reads, reconstructs, writes, and says how it went.
    pub fn run(&self, terminal: &Terminal) -> Result<Ending, Failure> {
        let file = palpate_io::read_strokes(self.log)?;
        let rig = match self.rig {
            Some(path) => palpate_io::read_pivot_rig(path)?,
            None if self.exact => PivotRig::exact(PadPose::default()),
            None => PivotRig::uncalibrated(PadPose::default()),
        };
        let rig = PivotRig { reading_sd_m: self.sensor_sd_m.or(rig.reading_sd_m), ..rig };
        let truth = self.truth.map(palpate_io::read_truth).transpose()?;
        palpate_io::check_strokes_target(self.out)?;
        let started = Instant::now();
        let found = reconstruct_strokes(&file.log, &PivotOptions::new(rig).harmonics(self.harmonics))?;
        let seconds = started.elapsed().as_secs_f64();
        let truth = match &truth {
            Some(truth) => {
                let errors =
                    compare_strokes(&found, truth).map_err(|error| Failure::Input(format!("the truth: {error}")))?;
                Some(StrokesTruthOverlay { truth, errors })
            }
            None => None,
        };
        let summary = StrokesSummary::new(&found, truth.map(|truth| truth.errors).as_ref());
        let report = strokes_page(&StrokesInput {
            title: self.title,
            log: &file.log,
            rig: &rig,
            reconstruction: &found,
            truth,
            seconds,
            command: Some(&command_line()),
            version: env!("CARGO_PKG_VERSION"),
        });
        palpate_io::write_strokes_result(self.out, &found, &summary, &report)?;
        if self.json {
            let json = summary.to_json().map_err(|error| Failure::Other(format!("summary.json: {error}")))?;
            print(json.trim_end())?;
        } else {
            terminal.say(&told(&summary, self.out))?;
        }
        Ok(if summary.certified { Ending::Success } else { Ending::NotCertified })
    }
}

fn told(summary: &StrokesSummary, out: &Path) -> String {
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
    lines.push(format!("  report  {}", out.join("report.html").display()));
    lines.join("\n")
}

/// What is asked of a simulation.
pub struct Simulate<'a> {
    pub out: &'a Path,
    /// About its centre of mass.
    pub shape: &'a SupportFunction,
    pub touchpad: Touchpad,
    pub friction: Option<f64>,
    pub rate_hz: f64,
    pub seed: u64,
    pub name: String,
}

impl Simulate<'_> {
    /// Simulates and writes the log and the truth.
    pub fn run(self, terminal: &Terminal) -> Result<Ending, Failure> {
        let (_, simulation) = simulated(self.shape, self.touchpad, self.friction, self.rate_hz, self.seed)?;
        let truth_dir = palpate_io::truth_dir_of(self.out);
        palpate_io::write_truth(&truth_dir, &simulation.truth)?;
        let metadata = [("made by", format!("palpate simulate {}", env!("CARGO_PKG_VERSION"))), ("shape", self.name)];
        palpate_io::write_strokes(self.out, &simulation.log, &metadata)?;
        let felt = simulation.log.samples.iter().filter(|sample| sample.s_m.is_some()).count();
        terminal.say(&format!(
            "{}: {} strokes, {} samples, {felt} with a contact\n{}: its truth (about the pivot)",
            self.out.display(),
            STROKES.len(),
            simulation.log.samples.len(),
            truth_dir.display()
        ))?;
        Ok(Ending::Success)
    }
}

/// The strokes of `palpate simulate --rig pivot`, and the shape about the pivot.
pub fn simulated(
    shape: &SupportFunction,
    touchpad: Touchpad,
    friction: Option<f64>,
    rate_hz: f64,
    seed: u64,
) -> Result<(SupportFunction, PivotSimulation), Failure> {
    let radius_m = shape.mean_radius_m();
    let pivot_m = [0.0, PIVOT_SHARE * radius_m];
    let length_m = if touchpad.length_m.is_finite() { touchpad.length_m } else { PAD_LENGTH * radius_m };
    let strokes =
        STROKES.map(|ways| Stroke { along_m: ways.map(|way| 0.5 * length_m + way * radius_m).to_vec(), press: PRESS });
    let options = PivotSimulateOptions {
        touchpad: Touchpad { length_m, ..touchpad },
        arm_noise_sd_m: ARM_NOISE_SHARE * touchpad.noise_sd_m,
        center_of_mass_m: pivot_m.map(|m| -m),
        friction: friction.unwrap_or(USUAL_FRICTION),
        rate_hz,
        seed,
        ..PivotSimulateOptions::default()
    };
    let about_pivot = shape.translated(-pivot_m[0], -pivot_m[1]);
    let simulation = simulate_strokes(&about_pivot, &strokes, &options)?;
    Ok((about_pivot, simulation))
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
