//! Constant errors of a rig: what lies between the readings and the truth, with exact derivatives. A log is corrected as a whole before
//! estimation.
//!
//! A pad reads scale · s + zero where the contact is at s; a palm stands at its reading less the angle's zero; the sensing surface lies in
//! front of the line through the base point, so that the supporting line of palm k is at r_k + p_k (`docs/theory.md`, contact); the angles
//! are read some time after the positions. Of these nine constants a log of an unknown object tells all but two: the common scale of the
//! pads and the common offset of their surfaces, under which the contact constraint and the balance are unchanged.

use crate::log::{Log, Sample};
use crate::palms::{Contacts, PalmPair};
use crate::shape::ContactSupport;

/// Constant errors of two palms and their pads; the default is a rig without errors.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default))]
#[non_exhaustive]
pub struct Calibration {
    /// What each pad adds to every position, metres.
    pub zero_m: [f64; 2],
    /// What each pad multiplies every position by; 1 without error, positive.
    pub scale: [f64; 2],
    /// What the encoders add to φ₁ and to φ₂, radians.
    pub angle_zero_rad: [f64; 2],
    /// How far each sensing surface lies in front of the line through the base point of its palm, metres.
    pub surface_m: [f64; 2],
    /// How much later than the positions of a sample its palm angles were read, seconds.
    pub clock_offset_s: f64,
}

impl Default for Calibration {
    fn default() -> Self {
        Self { zero_m: [0.0; 2], scale: [1.0; 2], angle_zero_rad: [0.0; 2], surface_m: [0.0; 2], clock_offset_s: 0.0 }
    }
}

/// Derivatives of the two contact residuals (predicted less measured position, metres) by each constant: `[palm][contact]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CalibrationRows {
    /// By [`Calibration::zero_m`].
    pub by_zero: [[f64; 2]; 2],
    /// By [`Calibration::scale`], metres.
    pub by_scale_m: [[f64; 2]; 2],
    /// By [`Calibration::angle_zero_rad`], metres per radian.
    pub by_angle_zero_m: [[f64; 2]; 2],
    /// By [`Calibration::surface_m`].
    pub by_surface: [[f64; 2]; 2],
}

impl Calibration {
    /// The log that a rig without errors had written.
    pub fn corrected(&self, log: &Log) -> Log {
        let correct = |(index, sample): (usize, &Sample)| {
            let palms = self.palms(&palms_later(log, index, -self.clock_offset_s));
            let shift = self.surface_shift_m(&palms);
            let position = |palm: usize, reading: Option<f64>| reading.map(|s| self.position_m(palm, s) - shift[palm]);
            let sd = |palm: usize, sd_m: Option<f64>| sd_m.map(|sd_m| sd_m / self.scale[palm]);
            Sample {
                palms,
                s1_m: position(0, sample.s1_m),
                s2_m: position(1, sample.s2_m),
                s1_sd_m: sd(0, sample.s1_sd_m),
                s2_sd_m: sd(1, sample.s2_sd_m),
                ..*sample
            }
        };
        Log { samples: log.samples.iter().enumerate().map(correct).collect() }
    }

    /// The log that this rig writes where one without errors had written `log`.
    pub fn distorted(&self, log: &Log) -> Log {
        let distort = |(index, sample): (usize, &Sample)| {
            let shift = self.surface_shift_m(&sample.palms);
            let [zero1, zero2] = self.angle_zero_rad;
            let reading =
                |palm: usize, s: Option<f64>| s.map(|s| self.scale[palm] * (s + shift[palm]) + self.zero_m[palm]);
            let sd = |palm: usize, sd_m: Option<f64>| sd_m.map(|sd_m| sd_m * self.scale[palm]);
            let later = palms_later(log, index, self.clock_offset_s);
            let palms = PalmPair { phi1_rad: later.phi1_rad + zero1, phi2_rad: later.phi2_rad + zero2, ..later };
            Sample {
                palms,
                s1_m: reading(0, sample.s1_m),
                s2_m: reading(1, sample.s2_m),
                s1_sd_m: sd(0, sample.s1_sd_m),
                s2_sd_m: sd(1, sample.s2_sd_m),
                ..*sample
            }
        };
        Log { samples: log.samples.iter().enumerate().map(distort).collect() }
    }

    /// The palms as they stand, from their readings.
    pub fn palms(&self, read: &PalmPair) -> PalmPair {
        let [zero1, zero2] = self.angle_zero_rad;
        PalmPair { phi1_rad: read.phi1_rad - zero1, phi2_rad: read.phi2_rad - zero2, ..*read }
    }

    /// The position of a contact on palm 1 (`palm` 0) or palm 2 (`palm` 1), metres from the base point, from its reading.
    pub fn position_m(&self, palm: usize, reading_m: f64) -> f64 {
        (reading_m - self.zero_m[palm]) / self.scale[palm]
    }

    /// How much further out both contacts lie (metres) because the surfaces stand in front of their lines.
    pub fn surface_shift_m(&self, palms: &PalmPair) -> [f64; 2] {
        palms.angles().positions(self.surface_m, [0.0; 2])
    }

    /// The derivatives of the contact residuals at an instant: `palms` as they stand, both contacts on the outline, and the measured
    /// positions from the base points, metres.
    pub fn rows(&self, palms: &PalmPair, contacts: [ContactSupport; 2], positions_m: [f64; 2]) -> CalibrationRows {
        let angles = palms.angles();
        let at = Contacts::from(contacts);
        let apart = |values: [f64; 2]| [[values[0], 0.0], [0.0, values[1]]];
        // What a palm touches from its base point: a body that is larger by p, about a point that lies at −b.
        let (offset1, offset2) = palms.base_offsets_m();
        let (p, offsets, along) = (self.surface_m, [offset1, offset2], palms.base_feet_m());
        let seen = Contacts {
            r: [0, 1].map(|k| at.r[k] + p[k] + offsets[k]),
            d: [0, 1].map(|k| at.d[k] + along[k]),
            v: [0, 1].map(|k| at.v[k] + p[k]),
        };
        let [by_palm1, by_palm2] = angles.positions_by_palms(&seen);
        CalibrationRows {
            by_zero: apart([1.0 / self.scale[0], 1.0 / self.scale[1]]),
            by_scale_m: apart([positions_m[0] / self.scale[0], positions_m[1] / self.scale[1]]),
            by_angle_zero_m: [[0, 1].map(|k| -by_palm1[k] - by_palm2[k]), by_palm2.map(|by_angle| -by_angle)],
            by_surface: [angles.positions([1.0, 0.0], [0.0; 2]), angles.positions([0.0, 1.0], [0.0; 2])],
        }
    }
}

/// The palms so many seconds after a sample: the cubic through the samples around that time, which for a motion that changes its
/// rate is far better than the rate times the time.
fn palms_later(log: &Log, index: usize, later_s: f64) -> PalmPair {
    let samples = &log.samples;
    let palms = samples[index].palms;
    if later_s == 0.0 {
        return palms;
    }
    let time_s = samples[index].time_s + later_s;
    let last = samples.len() - 1;
    let count = if (samples[0].time_s..=samples[last].time_s).contains(&time_s) { INSIDE } else { BEYOND };
    let after = samples.partition_point(|sample| sample.time_s < time_s);
    let first = after.saturating_sub(count / 2).min(samples.len().saturating_sub(count));
    let around = &samples[first..(first + count).min(samples.len())];
    let (mut phi1_rad, mut phi2_rad) = (0.0, 0.0);
    for (k, at) in around.iter().enumerate() {
        let others = around.iter().enumerate().filter(|(other, _)| *other != k).map(|(_, other)| other.time_s);
        let share: f64 = others.map(|other_s| (time_s - other_s) / (at.time_s - other_s)).product();
        phi1_rad += share * at.palms.phi1_rad;
        phi2_rad += share * at.palms.phi2_rad;
    }
    PalmPair { phi1_rad, phi2_rad, ..palms }
}

/// Samples that the polynomial goes through: a cubic, and beyond the ends of the log a line, which noise of the angles bends less.
const INSIDE: usize = 4;
const BEYOND: usize = 2;

/// Time before and after a sample over which rates are taken, seconds: far below the time between samples.
const RATE_STEP_S: f64 = 1e-5;

/// Rates of the angles φ₁ and φ₂ of each sample, radians per second.
pub(crate) fn palm_rates_rad_per_s(log: &Log) -> Vec<[f64; 2]> {
    let rate = |index: usize| {
        let [before, after] = [-RATE_STEP_S, RATE_STEP_S].map(|later_s| palms_later(log, index, later_s));
        [after.phi1_rad - before.phi1_rad, after.phi2_rad - before.phi2_rad].map(|turn| turn / (2.0 * RATE_STEP_S))
    };
    (0..log.samples.len()).map(rate).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::SupportFunction;

    const PSI: f64 = 0.7;

    /// Palms with base points apart, and positions.
    fn read() -> (PalmPair, [f64; 2]) {
        let palms = PalmPair { base1_m: [4e-3, -1e-3], base2_m: [-3e-3, 2e-3], ..PalmPair::hinged(0.6, 1.3) };
        (palms, [0.041, 0.052])
    }

    fn calibration() -> Calibration {
        Calibration {
            zero_m: [4e-4, -3e-4],
            scale: [1.01, 0.992],
            angle_zero_rad: [5e-3, -8e-3],
            surface_m: [2e-3, 7e-4],
            clock_offset_s: 0.0,
        }
    }

    fn shape() -> SupportFunction {
        SupportFunction::new(0.03, vec![[2e-3, -1e-3], [1.8e-3, 6e-4], [-5e-4, 7e-4]])
    }

    fn contacts(palms: &PalmPair) -> [ContactSupport; 2] {
        let shape = shape();
        let (theta1, theta2) = palms.contact_angles(PSI);
        [shape.at(theta1), shape.at(theta2)]
    }

    /// Predicted less measured positions.
    fn residuals(calibration: &Calibration) -> [f64; 2] {
        let (read, readings) = read();
        let palms = calibration.palms(&read);
        let shape = shape();
        let ((s1, s2), shift) = (palms.contact_positions_m(&shape, PSI), calibration.surface_shift_m(&palms));
        [s1 + shift[0] - calibration.position_m(0, readings[0]), s2 + shift[1] - calibration.position_m(1, readings[1])]
    }

    #[test]
    fn a_rig_without_errors_changes_nothing() {
        let (read, readings) = read();
        let none = Calibration::default();
        assert_eq!(none.palms(&read), read);
        assert_eq!([0, 1].map(|k| none.position_m(k, readings[k])), readings);
        assert_eq!(none.surface_shift_m(&read), [0.0; 2]);
    }

    #[test]
    fn readings_are_undone() {
        let calibration = calibration();
        let position_m = 0.037;
        let reading_m = calibration.scale[1] * position_m + calibration.zero_m[1];
        assert!((calibration.position_m(1, reading_m) - position_m).abs() < 1e-16);
        let truth = PalmPair::hinged(0.4, 1.7);
        let read = PalmPair::hinged(0.4 + 5e-3, 1.7 - 8e-3);
        let found = calibration.palms(&read);
        assert!((found.phi1_rad - truth.phi1_rad).abs() < 1e-15 && (found.phi2_rad - truth.phi2_rad).abs() < 1e-15);
    }

    #[test]
    fn a_log_that_a_rig_distorted_is_corrected() {
        let sample = |index: u32| {
            let t = 0.01 * f64::from(index);
            let palms = PalmPair { base1_m: [3e-3, 0.0], ..PalmPair::hinged(0.5 + 0.3 * t, 1.6 - 0.2 * t) };
            let seen = Sample::new(t, palms, 0.03 + 0.01 * t, 0.05 - 0.02 * t);
            Sample { s1_m: seen.s1_m.filter(|_| !index.is_multiple_of(5)), s2_sd_m: Some(1e-4), ..seen }
        };
        let log = Log { samples: (0..50).map(sample).collect() };
        let rig = Calibration { clock_offset_s: 0.02, ..calibration() };
        let read = rig.distorted(&log);
        assert!((read.samples[7].palms.phi1_rad - log.samples[7].palms.phi1_rad - 5e-3 - 0.02 * 0.3).abs() < 1e-12);
        let found = rig.corrected(&read);
        for (found, truth) in found.samples.iter().zip(&log.samples) {
            assert!((found.palms.phi1_rad - truth.palms.phi1_rad).abs() < 1e-12);
            assert!((found.palms.phi2_rad - truth.palms.phi2_rad).abs() < 1e-12);
            for (found, truth) in [(found.s1_m, truth.s1_m), (found.s2_m, truth.s2_m), (found.s2_sd_m, truth.s2_sd_m)] {
                assert_eq!(found.is_some(), truth.is_some());
                assert!((found.unwrap_or(0.0) - truth.unwrap_or(0.0)).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn derivatives_match_finite_differences() {
        const STEP: f64 = 1e-6;
        for at in [Calibration::default(), calibration()] {
            let (read, readings) = read();
            let palms = at.palms(&read);
            let positions = [0, 1].map(|k| at.position_m(k, readings[k]));
            let rows = at.rows(&palms, contacts(&palms), positions);
            let slope = |change: &dyn Fn(&mut Calibration, f64)| -> [f64; 2] {
                let [plus, minus] = [STEP, -STEP].map(|step| {
                    let mut moved = at;
                    change(&mut moved, step);
                    residuals(&moved)
                });
                [0, 1].map(|contact| (plus[contact] - minus[contact]) / (2.0 * STEP))
            };
            for palm in 0..2 {
                for (name, exact, numeric) in [
                    ("zero", rows.by_zero[palm], slope(&|c, step| c.zero_m[palm] += step)),
                    ("scale", rows.by_scale_m[palm], slope(&|c, step| c.scale[palm] += step)),
                    ("angle", rows.by_angle_zero_m[palm], slope(&|c, step| c.angle_zero_rad[palm] += step)),
                    ("surface", rows.by_surface[palm], slope(&|c, step| c.surface_m[palm] += step)),
                ] {
                    for contact in 0..2 {
                        let off = (exact[contact] - numeric[contact]).abs();
                        assert!(off < 1e-9, "{name} of palm {palm}, contact {contact}: {exact:?} {numeric:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn a_parallel_body_has_the_same_readings_as_surfaces_in_front() {
        // The common offset of the surfaces is a symmetry: the object found is larger by as much all around.
        let (palms, _) = read();
        let at = Contacts::from(contacts(&palms));
        let larger = Contacts { r: at.r.map(|r| r + 4e-3), v: at.v.map(|v| v + 4e-3), ..at };
        let shift = Calibration { surface_m: [4e-3; 2], ..Calibration::default() }.surface_shift_m(&palms);
        let (on_lines, of_larger) =
            (palms.angles().positions(at.r, at.d), palms.angles().positions(larger.r, larger.d));
        for k in 0..2 {
            assert!((on_lines[k] + shift[k] - of_larger[k]).abs() < 1e-16);
        }
    }
}
