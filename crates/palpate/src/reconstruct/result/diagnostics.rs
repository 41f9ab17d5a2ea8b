//! Diagnostics of the contacts at each sample from the readings, without the fitted outline: the generalised contact support
//! functions (eq. 8 of Moll & Erdmann 2001) and the radii of curvature (eq. 9), with rates by local polynomials (Savitzky-Golay);
//! and the difference between outline and readings in the distance of the contacts.

use crate::log::Log;
use crate::math::local_polynomial::Smoothing;
use crate::palms::{ContactRates, GeneralizedContactSupport, radii_of_curvature_m};
use crate::reconstruct::result::reconstruction::Reconstruction;

/// A contact whose normal angle changes more slowly than this, in radians per second, does not determine the curvature (eq. 9
/// divides by the rate).
const SLOWEST_ROLL: f64 = 1e-3;

/// Diagnostics of the contacts at one sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactDiagnostics {
    /// Time in seconds.
    pub time_s: f64,
    /// r̃₁, d̃₁, r̃₂ and d̃₂; `None` where a contact was not seen.
    pub support: Option<GeneralizedContactSupport>,
    /// Radius of curvature of the object at contact 1 by eq. 9, metres; `None` where the contact stands still on the object,
    /// was not seen, or lies in a piece of fewer than seven samples. Not smoothed by any model of the outline: noise makes it
    /// leave the range of a convex object now and then.
    pub curvature_radius1_m: Option<f64>,
    /// The same at contact 2.
    pub curvature_radius2_m: Option<f64>,
    /// Error in the norm of the contact point vector: the distance between the two contacts on the reconstructed outline, less
    /// the distance that the sensors say, metres; `None` where a contact was not seen.
    pub contact_vector_error_m: Option<f64>,
}

/// The diagnostics of each sample of `log`, in order. Rates come from local polynomials over each piece between jumps; the
/// orientation that eq. 9 needs is that of `reconstruction`, which must belong to the log.
pub fn diagnostics(log: &Log, reconstruction: &Reconstruction) -> Vec<ContactDiagnostics> {
    let mut all: Vec<ContactDiagnostics> = log
        .samples
        .iter()
        .zip(&reconstruction.motion)
        .map(|(sample, pose)| {
            let support = sample
                .s1_m
                .zip(sample.s2_m)
                .map(|(s1, s2)| GeneralizedContactSupport::of_readings(&sample.palms, s1, s2));
            let found =
                GeneralizedContactSupport::of_shape(&reconstruction.shape, pose.theta1_rad, sample.palms.phi2_rad);
            ContactDiagnostics {
                time_s: sample.time_s,
                support,
                curvature_radius1_m: None,
                curvature_radius2_m: None,
                contact_vector_error_m: support.map(|felt| found.r1.hypot(found.d1) - felt.r1.hypot(felt.d1)),
            }
        })
        .collect();
    let pieces = reconstruction.motion.chunk_by(|a, b| a.piece == b.piece);
    let mut start = 0;
    for piece in pieces {
        let mut samples: Vec<usize> = Vec::with_capacity(piece.len());
        for index in start..(start + piece.len()).min(all.len()) {
            let later = samples.last().is_none_or(|&last: &usize| all[index].time_s > all[last].time_s);
            if later && all[index].support.is_some() {
                samples.push(index);
            }
        }
        start += piece.len();
        curvatures(log, reconstruction, &samples, &mut all);
    }
    all
}

/// Fills in eq. 9 over one piece.
fn curvatures(log: &Log, reconstruction: &Reconstruction, samples: &[usize], all: &mut [ContactDiagnostics]) {
    let times_s: Vec<f64> = samples.iter().map(|&index| all[index].time_s).collect();
    let generalized = |index: usize, value: fn(&GeneralizedContactSupport) -> f64| {
        all[index].support.as_ref().map_or(f64::NAN, value)
    };
    let theta1: Vec<f64> = samples.iter().map(|&index| reconstruction.motion[index].theta1_rad).collect();
    let phi2: Vec<f64> = samples.iter().map(|&index| log.samples[index].palms.phi2_rad).collect();
    let r1: Vec<f64> = samples.iter().map(|&index| generalized(index, |support| support.r1)).collect();
    let r2: Vec<f64> = samples.iter().map(|&index| generalized(index, |support| support.r2)).collect();
    let smoothings = [&theta1, &phi2, &r1, &r2].map(|values| Smoothing::new(&times_s, values));
    let [Some(theta1), Some(phi2), Some(r1), Some(r2)] = smoothings else { return };
    for (&index, &time_s) in samples.iter().zip(&times_s) {
        let rates = ContactRates {
            theta1_rad_per_s: theta1.at(time_s).1,
            phi2_rad_per_s: phi2.at(time_s).1,
            r1_m_per_s: r1.at(time_s).1,
            r2_m_per_s: r2.at(time_s).1,
        };
        let Some(support) = all[index].support else { continue };
        let (v1, v2) = radii_of_curvature_m(&support, &rates, log.samples[index].palms.phi2_rad);
        let rolls = |rate: f64| rate.abs() >= SLOWEST_ROLL;
        all[index].curvature_radius1_m = v1.filter(|_| rolls(rates.theta1_rad_per_s));
        all[index].curvature_radius2_m = v2.filter(|_| rolls(rates.theta1_rad_per_s + rates.phi2_rad_per_s));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::palms::PalmMotion;
    use crate::reconstruct::{Reconstructor, Start};
    use crate::shape::NamedShape;
    use crate::simulate::{SimulateOptions, simulate};

    #[test]
    fn curvatures_are_those_of_the_object() {
        let shape = NamedShape::Pebble.shape(0.03).expect("a positive size");
        let motion = PalmMotion::random(8, 20.0, 0.8).and_then(|motion| motion.sample(40.0)).expect("possible");
        let mut run = simulate(&shape, &motion, &SimulateOptions::default()).expect("possible");
        run.log.samples[300].s1_m = None;
        let psi: Vec<f64> = run.truth.motion.iter().map(|pose| pose.psi_rad).collect();
        let start = Start::Motion { shape: shape.clone(), psi_rad: psi };
        let found = Reconstructor::new().start(start).run(&run.log).expect("solvable");
        let all = diagnostics(&run.log, &found);
        assert_eq!(all.len(), run.log.samples.len());
        assert_eq!((all[300].support, all[300].curvature_radius1_m), (None, None));
        let mut errors: Vec<f64> = Vec::new();
        for ((sample, pose), diagnostics) in run.log.samples.iter().zip(&run.truth.motion).zip(&all) {
            let (theta1, theta2) = sample.palms.contact_angles(pose.psi_rad);
            errors.extend(diagnostics.curvature_radius1_m.map(|v| (v - shape.at(theta1).v).abs()));
            errors.extend(diagnostics.curvature_radius2_m.map(|v| (v - shape.at(theta2).v).abs()));
            if let Some(support) = diagnostics.support {
                let truth = GeneralizedContactSupport::of_shape(&shape, theta1, sample.palms.phi2_rad);
                assert!(diagnostics.contact_vector_error_m.is_some_and(|error| error.abs() < 1e-6));
                assert!((support.r1 - truth.r1).abs() < 1e-9 && (support.d2 - truth.d2).abs() < 1e-9);
            }
        }
        assert!(errors.len() > run.log.samples.len(), "{}", errors.len());
        errors.sort_by(f64::total_cmp);
        assert!(errors[errors.len() * 9 / 10] < 1e-3 * 0.03, "{}", errors[errors.len() * 9 / 10]);
    }
}
