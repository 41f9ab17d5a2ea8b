//! Equations 19 to 21 of Moll & Erdmann 2001 integrated from given initial values, without the search for them.

use crate::estimate::measurements::Measurements;
use crate::estimate::model::noise_from_log::{contact_scatter_m, steps_m};
use crate::log::Log;
use crate::math::local_polynomial::FEWEST;
use crate::reconstruct::options::ReconstructOptions;
use crate::reconstruct::options::check::check_log;
use crate::reconstruct::options::error::ReconstructError;
use crate::reconstruct::options::method::Method;
use crate::reconstruct::paper::piece::Piece;

/// Least noise, as a share of the size of the object: exact readings are not damped.
pub(crate) const LEAST_NOISE: f64 = 1e-9;

/// The differential equations of Moll & Erdmann 2001 (19 to 21) over a log without jumps, smoothed and prepared for integration.
///
/// This is the inner part of [`Method::Ode`], which searches for the initial values and puts the pieces between jumps
/// together. Take it to compare integrators, or where the object is known at one instant.
#[derive(Clone, Debug)]
pub struct PaperEquations {
    piece: Piece,
    times_s: Vec<f64>,
}

/// The integrated state at one sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Integrated {
    /// When, seconds.
    pub time_s: f64,
    /// Orientation ψ relative to the first sample, radians.
    pub psi_rad: f64,
    /// Support function at the contact with palm 1, metres.
    pub r1_m: f64,
    /// Support function at the contact with palm 2, metres.
    pub r2_m: f64,
}

impl PaperEquations {
    /// Smooths the samples of `log` that saw both contacts and are later than the one before.
    ///
    /// # Errors
    /// As [`reconstruct`](crate::reconstruct::reconstruct), and with fewer samples than the rates ask for.
    pub fn new(log: &Log) -> Result<Self, ReconstructError> {
        check_log(log, &ReconstructOptions { method: Method::Ode, ..ReconstructOptions::default() })?;
        let measurements = Measurements::new(log, None);
        let sd_m = contact_scatter_m(&measurements, steps_m(log)).max(LEAST_NOISE * measurements.size_m());
        let seen = measurements.instants.iter().filter(|instant| instant.both_seen()).count();
        let piece = Piece::new(log, &measurements, 0..measurements.len(), Method::Ode, sd_m)
            .ok_or(ReconstructError::TooFewSamples { seen, needed: FEWEST })?;
        let times_s = piece.samples.iter().map(|&sample| log.samples[sample].time_s).collect();
        Ok(Self { piece, times_s })
    }

    /// Integrates from r₁ and r₂ at the first sample, metres, by the fourth-order Adams-Bashforth-Moulton method with one step
    /// per sample.
    ///
    /// # Errors
    /// When the integral diverges.
    pub fn integrate(&self, r1_m: f64, r2_m: f64) -> Result<Vec<Integrated>, ReconstructError> {
        let contacts = self.piece.integrate((r1_m, r2_m)).ok_or(ReconstructError::NotSolvable)?;
        let both = self.times_s.iter().zip(contacts);
        Ok(both
            .map(|(&time_s, contact)| Integrated { time_s, psi_rad: contact.psi, r1_m: contact.r1, r2_m: contact.r2 })
            .collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::palms::PalmMotion;
    use crate::shape::NamedShape;
    use crate::simulate::{SimulateOptions, simulate};

    /// Largest error of ψ over a part of a motion on which the lines of force keep off the centre of mass, radians.
    fn error(samples: usize) -> f64 {
        let shape = NamedShape::Pebble.shape(0.03).expect("a positive size");
        let motion = PalmMotion::random(2, 90.0, 1.0).expect("a motion");
        let (start_s, end_s) = (5.0, 16.0);
        let part = (0..samples).map(|sample| start_s + (end_s - start_s) * sample as f64 / (samples - 1) as f64);
        // From the start of the motion, which determines the pose.
        let before = (0..50).map(|step| 0.1 * f64::from(step));
        let motion: Vec<_> = before.chain(part).map(|time_s| (time_s, motion.at(time_s))).collect();
        let mut simulated = simulate(&shape, &motion, &SimulateOptions::default()).expect("the scene is sound");
        let first = simulated.log.samples.len() - samples;
        let truth = simulated.truth.motion.split_off(first);
        let log = Log { samples: simulated.log.samples.split_off(first) };
        let (theta1, theta2) = log.samples[0].palms.contact_angles(truth[0].psi_rad);
        let integrated = PaperEquations::new(&log)
            .and_then(|equations| equations.integrate(shape.at(theta1).r, shape.at(theta2).r))
            .expect("the integral stays finite");
        let off = integrated.iter().zip(&truth).map(|(found, pose)| {
            assert_eq!(found.time_s, pose.time_s);
            (found.psi_rad - (pose.psi_rad - truth[0].psi_rad)).abs()
        });
        off.fold(0.0, f64::max)
    }

    #[test]
    fn the_truth_at_the_start_gives_the_truth_throughout() {
        let errors = [150, 300, 600].map(error);
        assert!(errors[2] < 1e-6, "{errors:?}");
        // Fourth order, or better where the rates, of fifth order, decide.
        assert!(errors.windows(2).all(|pair| pair[0] > 12.0 * pair[1]), "{errors:?}");
    }

    #[test]
    fn too_few_samples_are_refused() {
        assert!(matches!(PaperEquations::new(&Log::default()), Err(ReconstructError::TooFewSamples { .. })));
    }
}
