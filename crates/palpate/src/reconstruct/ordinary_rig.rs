//! A log as one of an ordinary rig, whose constants nobody knows exactly (`docs/theory.md`, calibration). With them open the search allows for more error and
//! corrects readings as it goes, so that it may arrange what it misses where readings are exact; constants that come out as stated make that an arrangement
//! of the exact rig, and others tell that this is not exact.

use super::reconstructor::Reconstructor;
use super::refine::job::Job;
use super::result::calibration::ConstantEstimate;
use super::result::reconstruction::Reconstruction;
use super::search::schedule::Found;
use super::start::arrangement_of;
use crate::log::Log;
use crate::sensor::{Rig, Tolerances};

/// Samples of a log that are tried at least, where it has as many: with fewer, jumps are lost; more cost time.
const SAMPLES: usize = 800;

/// A constant that the log has further than so many of its own standard deviations from what was stated is another: one of seven that are as stated is
/// once in fifty logs.
const DIFFERENT_SDS: f64 = 3.0;

impl Reconstructor<'_> {
    /// The same with no constant of the rig known better than in an ordinary one.
    pub(super) fn with_ordinary_rig(&self) -> Self {
        let Rig { calibration, tolerances, .. } = self.known_rig();
        self.clone().rig(Rig::new(calibration, at_least_ordinary(&tolerances)))
    }

    /// What explains a part of the log ([`thinned`]) with certainty where the rig is an ordinary one; `None` where it is no other than that which is known.
    pub(super) fn explained_by_ordinary_rig(&self, log: &Log) -> Option<Reconstruction> {
        let ordinary = self.with_ordinary_rig();
        if ordinary.known_rig() == self.known_rig() {
            return None;
        }
        ordinary.run_briefly(&thinned(log)).ok().filter(Reconstruction::is_com_certified)
    }
}

/// The same as an arrangement of the readings as they are; `None` where it has constants that are not as stated.
pub(super) fn arranged(job: &Job, ordinary: &Reconstruction) -> Option<Found> {
    if differs_from_stated(ordinary) {
        return None;
    }
    let instants = job.measurements.instants.iter().step_by(every(job.measurements.len())).copied().collect();
    let psi = ordinary.motion.iter().map(|pose| pose.psi_rad).collect();
    Some(arrangement_of(job, job.measurements.of(instants), &ordinary.shape, psi))
}

/// Whether a constant of the rig is told to be another than was stated.
pub(super) fn differs_from_stated(found: &Reconstruction) -> bool {
    found.calibration.iter().flat_map(|calibration| &calibration.constants).any(is_another)
}

fn is_another(constant: &ConstantEstimate) -> bool {
    constant.prior_sd > 0.0 && (constant.value - constant.stated).abs() > DIFFERENT_SDS * constant.sd
}

/// A part of a log, thinned to no fewer than [`SAMPLES`] where it has as many.
pub(super) fn thinned(log: &Log) -> Log {
    Log { samples: log.samples.iter().step_by(every(log.samples.len())).copied().collect() }
}

fn every(samples: usize) -> usize {
    (samples / SAMPLES).max(1)
}

/// No constant is known better than in an ordinary rig.
fn at_least_ordinary(stated: &Tolerances) -> Tolerances {
    let ordinary = Tolerances::default();
    let largest = |stated: [f64; 2], ordinary: [f64; 2]| [0, 1].map(|palm| stated[palm].max(ordinary[palm]));
    Tolerances {
        zero_sd_m: largest(stated.zero_sd_m, ordinary.zero_sd_m),
        scale_sd: largest(stated.scale_sd, ordinary.scale_sd),
        angle_zero_sd_rad: largest(stated.angle_zero_sd_rad, ordinary.angle_zero_sd_rad),
        surface_sd_m: largest(stated.surface_sd_m, ordinary.surface_sd_m),
        ..*stated
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::palms::PalmMotion;
    use crate::reconstruct::ReconstructOptions;
    use crate::sensor::{Calibration, Touchpad};
    use crate::shape::NamedShape;
    use crate::simulate::{SimulateOptions, Simulation, simulate};

    fn felt() -> Simulation {
        let shape = NamedShape::Stone.shape(0.03).expect("a positive size");
        let motion = PalmMotion::random(3, 60.0, 0.6).and_then(|motion| motion.sample(30.0)).expect("possible");
        let touchpad = Touchpad { noise_sd_m: 1e-4, ..Touchpad::ideal() };
        simulate(&shape, &motion, &SimulateOptions { touchpad, ..SimulateOptions::default() }).expect("possible")
    }

    #[test]
    fn constants_as_stated_arrange_the_log_as_it_is_and_others_do_not() {
        let options = ReconstructOptions::default();
        let reconstructor = Reconstructor::from(options.clone());
        let Simulation { log, truth, .. } = felt();
        assert!(thinned(&log).samples.len() < log.samples.len());
        let ordinary = reconstructor.explained_by_ordinary_rig(&log).expect("explained");
        let job = Job::new(&log, &options);
        let found = arranged(&job, &ordinary).expect("as stated");
        let [estimate] = &found.estimates[..] else { panic!("one arrangement") };
        let of_sample = |index: usize| truth.motion[every(log.samples.len()) * index].psi_rad;
        let first_rad = estimate.psi[0] - of_sample(0);
        for (index, (instant, psi)) in found.thin.instants.iter().zip(&estimate.psi).enumerate() {
            assert_eq!(instant.position, (every(log.samples.len()) * index) as f64);
            assert!((psi - of_sample(index) - first_rad).abs() < 0.03, "{index}");
        }
        let off = Calibration { zero_m: [1e-3, 0.0], ..Calibration::default() }.distorted(&log);
        let ordinary = reconstructor.explained_by_ordinary_rig(&off).expect("explained");
        assert!(arranged(&Job::new(&off, &options), &ordinary).is_none());
        assert_eq!(reconstructor.rig(Rig::uncalibrated()).explained_by_ordinary_rig(&log), None);
    }

    #[test]
    fn a_constant_is_another_where_the_log_says_so_and_it_was_not_stated_exactly() {
        let zero = |sds: f64, prior_sd: f64| ConstantEstimate {
            name: "s1_zero_m".to_owned(),
            value: 3e-4 + sds * 2e-5,
            sd: 2e-5,
            stated: 3e-4,
            prior_sd,
        };
        assert!(is_another(&zero(-1.01 * DIFFERENT_SDS, 5e-4)) && !is_another(&zero(0.99 * DIFFERENT_SDS, 5e-4)));
        assert!(!is_another(&zero(2.0 * DIFFERENT_SDS, 0.0)));
    }
}
