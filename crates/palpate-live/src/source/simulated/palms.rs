//! Two palms that are simulated, from a small plan.

use std::path::Path;

use palpate::Sample;
use palpate::palms::PalmMotion;
use palpate::plan::{PalmLimits, plan_turn};
use palpate::sensor::Touchpad;
use palpate::shape::NamedShape;
use palpate::simulate::{SimulateOptions, simulate};
use palpate_io::RigFile;
use serde::Deserialize;

use crate::error::SourceError;

/// Samples of a plan at most.
const MOST_SAMPLES: f64 = 1e6;

/// What is simulated. Every key may be left out.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct Plan {
    /// As for `palpate simulate --shape`.
    shape: String,
    radius_mm: f64,
    motion: Motion,
    duration_s: f64,
    rate_hz: f64,
    noise_mm: f64,
    angle_noise_deg: f64,
    /// Share of the readings that are missing.
    dropout: f64,
    /// Coefficients of friction of both palms.
    friction: [f64; 2],
    /// A rig file with the errors and conventions of the rig, from the folder of the plan.
    rig: Option<String>,
    /// Draw the errors by the standard deviations of the rig file.
    draw_rig: bool,
    /// Write the normal forces of an object of this mass.
    mass_g: Option<f64>,
    seed: u64,
    /// So many times faster than the clock; 0 = as fast as possible.
    speed: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Motion {
    Turn,
    Zigzag,
    Random,
}

impl Default for Plan {
    fn default() -> Self {
        Self {
            shape: "pebble".to_owned(),
            radius_mm: 30.0,
            motion: Motion::Turn,
            duration_s: 60.0,
            rate_hz: 100.0,
            noise_mm: 0.1,
            angle_noise_deg: 0.0,
            dropout: 0.0,
            friction: [0.0; 2],
            rig: None,
            draw_rig: false,
            mass_g: None,
            seed: 1,
            speed: 1.0,
        }
    }
}

/// The samples of a plan, its speed and its rig.
pub(crate) fn simulated(path: &Path, text: &str) -> Result<(Vec<Sample>, f64, RigFile), SourceError> {
    let plan: Plan = super::parse(path, text)?;
    let rig = match &plan.rig {
        Some(rig) => palpate_io::read_rig(&path.parent().unwrap_or(Path::new("")).join(rig))
            .map_err(|error| SourceError::settings(path, format!("rig: {error}")))?,
        None => RigFile::exact(),
    };
    let samples = plan.simulate(&rig).map_err(|problem| SourceError::settings(path, problem))?;
    Ok((samples, plan.speed, rig))
}

impl Plan {
    /// What such a rig writes.
    fn simulate(&self, rig: &RigFile) -> Result<Vec<Sample>, String> {
        super::require_speed(self.speed)?;
        let samples = self.duration_s * self.rate_hz;
        if !(samples > 0.0 && samples <= MOST_SAMPLES) {
            return Err(format!(
                "duration_s and rate_hz make {samples} samples; between 1 and {MOST_SAMPLES} are simulated"
            ));
        }
        let shape = self.shape.parse::<NamedShape>().map_err(|error| format!("shape: {error}"))?;
        let shape = shape.shape(1e-3 * self.radius_mm).map_err(|error| error.to_string())?;
        let touchpad = Touchpad {
            noise_sd_m: 1e-3 * self.noise_mm,
            angle_noise_sd_rad: self.angle_noise_deg.to_radians(),
            dropout: self.dropout,
            rate_hz: self.rate_hz,
            ..Touchpad::ideal()
        };
        let (motion, start_psi_rad) = match self.motion {
            Motion::Turn => {
                let turn = plan_turn(&shape, &PalmLimits::default(), self.duration_s);
                let turn = turn.map_err(|error| format!("{error}; try motion = \"zigzag\""))?;
                (turn.motion, turn.start_psi_rad)
            }
            Motion::Zigzag => {
                (PalmMotion::squeeze_and_rotate(self.duration_s, 2).map_err(|error| error.to_string())?, 0.0)
            }
            Motion::Random => {
                (PalmMotion::random(self.seed, self.duration_s, 1.0).map_err(|error| error.to_string())?, 0.0)
            }
        };
        let options = SimulateOptions {
            touchpad,
            seed: self.seed,
            start_psi_rad,
            friction: self.friction,
            mass_kg: self.mass_g.map_or(0.1, |grams| 1e-3 * grams),
            with_forces: self.mass_g.is_some(),
            ..SimulateOptions::default()
        };
        let palms = motion.sample(self.rate_hz).map_err(|error| error.to_string())?;
        let simulation = simulate(&shape, &palms, &options).map_err(|error| error.to_string())?;
        let calibration = if self.draw_rig { rig.rig.drawn(self.seed) } else { rig.rig.calibration };
        Ok(rig.conventions.apply(&calibration.distorted(&simulation.log)).samples)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::source::simulated::Simulated;
    use crate::source::{Arrival, Source};
    use std::time::{Duration, Instant};

    fn open(plan: &str) -> Result<Simulated<Sample>, SourceError> {
        let dir = tempfile::tempdir().expect("a folder");
        std::fs::write(dir.path().join("rig.toml"), "[angles]\nsign2 = -1\n[palm1]\nzero_mm = 3\n").expect("a rig");
        std::fs::write(dir.path().join("plan.toml"), plan).expect("a plan");
        Simulated::open(&dir.path().join("plan.toml"))
    }

    fn all(mut source: Simulated<Sample>) -> Vec<Sample> {
        let mut samples = Vec::new();
        loop {
            match source.next() {
                Ok(Arrival::Sample(sample)) => samples.push(sample),
                Ok(Arrival::Nothing) => {}
                _ => return samples,
            }
        }
    }

    #[test]
    fn a_plan_has_friction_drop_outs_forces_and_the_errors_of_a_rig() {
        let base = "shape = 'egg'\nduration_s = 4\nrate_hz = 50\nnoise_mm = 0\nspeed = 0\nmotion = 'zigzag'\n";
        let plain = all(open(base).expect("a plan"));
        let rig = all(open(&format!("{base}rig = 'rig.toml'\nmass_g = 50\n")).expect("a plan"));
        assert_eq!((plain.len(), rig.len()), (201, 201));
        let (Some(before), Some(after)) = (plain[7].s1_m, rig[7].s1_m) else { panic!("no contact") };
        assert!((after - before - 0.003).abs() < 1e-12 && rig[7].palms.phi2_rad < 0.0 && rig[7].force1_n.is_some());
        let sticky = all(open(&format!("{base}friction = [0.05, 0.05]\n")).expect("a plan"));
        assert_ne!(sticky[100].s1_m, plain[100].s1_m);
        let missing = all(open(&format!("{base}dropout = 0.5\n")).expect("a plan"));
        assert!((50..150).contains(&missing.iter().filter(|sample| sample.s1_m.is_none()).count()));
    }

    #[test]
    fn samples_come_no_earlier_than_they_are_due() {
        let source = open("duration_s = 1\nrate_hz = 20\nspeed = 2\nmotion = 'zigzag'\n").expect("a plan");
        let begun = Instant::now();
        assert_eq!(all(source).len(), 21);
        assert!(begun.elapsed() >= Duration::from_millis(500));
    }

    #[test]
    fn plans_that_cannot_be_are_refused_by_name() {
        for (plan, expected) in [
            ("shape = 'cube'", "shape: "),
            ("speed = -1", "speed must"),
            ("duration_s = 1e9", "duration_s and rate_hz"),
            ("\nnoise = 1", "line 2: unknown field `noise`"),
            ("rig = 'none.toml'", "rig: "),
            ("radius_mm = -3", ""),
        ] {
            let message = open(plan).map(|_| ()).expect_err(plan).to_string();
            assert!(message.contains(&format!("plan.toml: {expected}")), "{message}");
        }
    }
}
