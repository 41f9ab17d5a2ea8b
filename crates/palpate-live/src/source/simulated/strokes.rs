//! Strokes of a pivoting grasp that are simulated, from a small plan.

use std::path::Path;

use palpate::pivot::{HeldObject, PivotRig, PivotSample, PivotSimulateOptions, simulate_strokes};
use palpate::sensor::Touchpad;
use palpate::shape::NamedShape;
use palpate_io::StrokesComments;
use serde::Deserialize;

use crate::error::SourceError;

/// What the plan of strokes says of its motion.
pub(super) const MOTION: &str = "strokes";

/// What is simulated. Every key but `motion` may be left out.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct Plan {
    /// As for `palpate simulate --shape`.
    shape: String,
    radius_mm: f64,
    motion: String,
    /// From the centre of mass; left out as for `palpate simulate --rig pivot`.
    pivot_mm: Option<[f64; 2]>,
    /// Planned strokes, a file from the folder of the plan; left out as for `palpate simulate --rig pivot`.
    strokes: Option<String>,
    rate_hz: f64,
    noise_mm: f64,
    /// Share of the readings that are missing.
    dropout: f64,
    friction: Option<f64>,
    /// A rig file with the pad and its errors, from the folder of the plan.
    rig: Option<String>,
    seed: u64,
    /// So many times faster than the clock; 0 = as fast as possible.
    speed: f64,
}

impl Default for Plan {
    fn default() -> Self {
        Self {
            shape: "pebble".to_owned(),
            radius_mm: 30.0,
            motion: MOTION.to_owned(),
            pivot_mm: None,
            strokes: None,
            rate_hz: PivotSimulateOptions::default().rate_hz,
            noise_mm: 0.1,
            dropout: 0.0,
            friction: None,
            rig: None,
            seed: 1,
            speed: 1.0,
        }
    }
}

/// The samples of a plan, its speed, and what is known of rig and object.
pub(crate) fn simulated(path: &Path, text: &str) -> Result<(Vec<PivotSample>, f64, StrokesComments), SourceError> {
    let plan: Plan = super::parse(path, text)?;
    plan.simulate(path.parent().unwrap_or(Path::new(""))).map_err(|problem| SourceError::settings(path, problem))
}

impl Plan {
    fn simulate(&self, folder: &Path) -> Result<(Vec<PivotSample>, f64, StrokesComments), String> {
        super::require_speed(self.speed)?;
        let of_file = |key: &str, error: palpate_io::ReadError| format!("{key}: {error}");
        let rig = match &self.rig {
            Some(rig) => palpate_io::read_pivot_rig(&folder.join(rig)).map_err(|error| of_file("rig", error))?,
            None => PivotRig::default(),
        };
        let shape = self.shape.parse::<NamedShape>().map_err(|error| format!("shape: {error}"))?;
        let shape = shape.shape(1e-3 * self.radius_mm).map_err(|error| error.to_string())?;
        let touchpad = Touchpad { noise_sd_m: 1e-3 * self.noise_mm, dropout: self.dropout, ..Touchpad::ideal() };
        let held =
            HeldObject::new(&shape, self.pivot_mm.map(|pivot| pivot.map(|mm| 1e-3 * mm)), touchpad, self.friction);
        let strokes = match &self.strokes {
            Some(file) => {
                palpate_io::read_planned_strokes(&folder.join(file)).map_err(|error| of_file("strokes", error))?
            }
            None => held.usual_strokes(),
        };
        let options = PivotSimulateOptions { rig, rate_hz: self.rate_hz, seed: self.seed, ..held.options };
        let log = simulate_strokes(&held.about_pivot, &strokes, &options).map_err(|error| error.to_string())?.log;
        let said = StrokesComments { rig: Some(rig), swing_period_s: log.swing_period_s };
        Ok((log.samples, self.speed, said))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rigs::RigKind;
    use crate::source::simulated::{Simulated, rig_kind};
    use crate::source::{Arrival, Source};

    fn open(plan: &str) -> (RigKind, Result<Simulated<PivotSample>, SourceError>) {
        let dir = tempfile::tempdir().expect("a folder");
        std::fs::write(dir.path().join("rig.toml"), "[pad]\ntilt_rad = 0.1\n").expect("a rig");
        std::fs::write(dir.path().join("strokes.csv"), "stroke,along_m,press\n1,0.3,3\n1,0.35,3\n").expect("strokes");
        let path = dir.path().join("plan.toml");
        std::fs::write(&path, plan).expect("a plan");
        (rig_kind(&path), Simulated::open(&path))
    }

    fn all(mut source: Simulated<PivotSample>) -> Vec<PivotSample> {
        let mut samples = Vec::new();
        while let Ok(Arrival::Sample(sample)) = source.next() {
            samples.push(sample);
        }
        samples
    }

    #[test]
    fn a_plan_of_strokes_is_one_by_its_motion_and_has_the_pad_of_its_rig() {
        let base = "motion = 'strokes'\nshape = 'egg'\nspeed = 0\nstrokes = 'strokes.csv'\n";
        let (kind, plain) = open(base);
        assert_eq!(kind, RigKind::Pivot);
        assert_eq!(open("motion = 'turn'\n").0, RigKind::Palms);
        assert_eq!(open("\n").0, RigKind::Palms);
        let plain = all(plain.expect("a plan"));
        let tilted = open(&format!("{base}rig = 'rig.toml'\n")).1.expect("a plan");
        let said = tilted.rig().and_then(|said| said.rig).expect("its rig");
        assert_eq!(said.pad.tilt_rad, 0.1);
        let tilted = all(tilted);
        assert!(plain.len() > 20 && plain.iter().any(|sample| sample.s_m.is_some()));
        assert!(tilted[0].pivot_y_m > plain[0].pivot_y_m + 0.01, "the pad rises to the right");
        let usual = open(&base.replace("strokes = 'strokes.csv'", "")).1.expect("a plan");
        assert!(all(usual).len() > 10 * plain.len());
    }

    #[test]
    fn plans_that_cannot_be_are_refused_by_name() {
        for (plan, expected) in [
            ("motion = 'strokes'\nshape = 'cube'", "shape: "),
            ("motion = 'strokes'\nspeed = -1", "speed must"),
            ("motion = 'strokes'\nduration_s = 1", "line 2: unknown field `duration_s`"),
            ("motion = 'strokes'\nrig = 'none.toml'", "rig: "),
            ("motion = 'strokes'\nstrokes = 'none.csv'", "strokes: "),
            ("motion = 'strokes'\nrate_hz = -3", ""),
        ] {
            let message = open(plan).1.map(|_| ()).expect_err(plan).to_string();
            assert!(message.contains(&format!("plan.toml: {expected}")), "{message}");
        }
    }
}
