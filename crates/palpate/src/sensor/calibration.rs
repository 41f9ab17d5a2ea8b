//! Constant errors of a rig: what lies between the readings and the truth, with exact derivatives. Applied in one place, where a log is
//! made ready for estimation.
//!
//! A pad reads scale · s + zero where the contact is at s; a palm stands at its reading less the angle's zero; the sensing surface lies in
//! front of the line through the base point, so that the supporting line of palm k is at r_k + p_k (`docs/theory.md`, contact). Of these
//! ten constants a log of an unknown object tells all but two: the common scale of the pads and the common offset of their surfaces, under
//! which the contact constraint and the balance are unchanged.

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
    /// What the encoder of each palm adds to its angle against the horizontal, radians.
    pub angle_zero_rad: [f64; 2],
    /// How far each sensing surface lies in front of the line through the base point of its palm, metres.
    pub surface_m: [f64; 2],
}

impl Default for Calibration {
    fn default() -> Self {
        Self { zero_m: [0.0; 2], scale: [1.0; 2], angle_zero_rad: [0.0; 2], surface_m: [0.0; 2] }
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
    /// The palms as they stand, from their readings.
    pub fn palms(&self, read: &PalmPair) -> PalmPair {
        let [angle1, angle2] = self.angle_zero_rad;
        PalmPair { phi1_rad: read.phi1_rad - angle1, phi2_rad: read.phi2_rad - (angle2 - angle1), ..*read }
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
        let (palms, contacts) = (palms.angles(), Contacts::from(contacts));
        let apart = |values: [f64; 2]| [[values[0], 0.0], [0.0, values[1]]];
        let in_front = Contacts { r: [0, 1].map(|k| contacts.r[k] + self.surface_m[k]), ..contacts };
        // θ moves with the palm as ever, but d and v are those of the outline: only what φ₂ does to r + p changes.
        let by_palms = palms.positions_by_palms(&in_front);
        let excess = [self.surface_m[0], -self.surface_m[1]];
        // The derivative above takes v − r with r + p for r.
        let by_angle = [0, 1].map(|palm| {
            [0, 1].map(|contact| {
                let own = if palm == contact { excess[contact] } else { 0.0 };
                -(by_palms[palm][contact] + own)
            })
        });
        CalibrationRows {
            by_zero: apart([1.0 / self.scale[0], 1.0 / self.scale[1]]),
            by_scale_m: apart([positions_m[0] / self.scale[0], positions_m[1] / self.scale[1]]),
            by_angle_zero_m: by_angle,
            by_surface: [palms.positions([1.0, 0.0], [0.0; 2]), palms.positions([0.0, 1.0], [0.0; 2])],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::SupportFunction;

    const PSI: f64 = 0.7;

    fn read() -> (PalmPair, [f64; 2]) {
        (PalmPair::hinged(0.6, 1.3), [0.041, 0.052])
    }

    fn calibration() -> Calibration {
        Calibration {
            zero_m: [4e-4, -3e-4],
            scale: [1.01, 0.992],
            angle_zero_rad: [5e-3, -8e-3],
            surface_m: [2e-3, 7e-4],
        }
    }

    fn contacts(palms: &PalmPair) -> [ContactSupport; 2] {
        let shape = SupportFunction::new(0.03, vec![[2e-3, -1e-3], [1.8e-3, 6e-4], [-5e-4, 7e-4]]);
        let (theta1, theta2) = palms.contact_angles(PSI);
        [shape.at(theta1), shape.at(theta2)]
    }

    /// Predicted less measured positions.
    fn residuals(calibration: &Calibration) -> [f64; 2] {
        let (read, readings) = read();
        let palms = calibration.palms(&read);
        let at = Contacts::from(contacts(&palms));
        let (on_lines, shift) = (palms.angles().positions(at.r, at.d), calibration.surface_shift_m(&palms));
        [0, 1].map(|k| on_lines[k] + shift[k] - calibration.position_m(k, readings[k]))
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
        let read = PalmPair::hinged(0.4 + 5e-3, 1.7 - 8e-3 - 5e-3);
        let found = calibration.palms(&read);
        assert!((found.phi1_rad - truth.phi1_rad).abs() < 1e-15 && (found.phi2_rad - truth.phi2_rad).abs() < 1e-15);
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
