//! Friction and centre of mass of a result: what the forces within the friction cones ask of its form and motion (`docs/theory.md`, friction).

use crate::estimate::friction::regimes::{Place, Regime, regimes};
use crate::estimate::friction::strips::{LEAST_FRICTION, center_and_friction};
use crate::estimate::measurements::Measurements;
use crate::estimate::model::contact::psi_sd_by_contacts;
use crate::log::Log;
use crate::reconstruct::result::reconstruction::Reconstruction;

/// Coefficients of friction and centre of mass, from form and motion.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct FrictionEstimate {
    /// Coefficients of friction of palm 1 and palm 2.
    pub coefficients: [f64; 2],
    /// Their standard deviations.
    pub coefficient_sds: [f64; 2],
    /// The centre of mass from the origin of the object frame of the result, in that frame, metres.
    pub center_m: [f64; 2],
    /// Its standard deviations, metres.
    pub center_sd_m: [f64; 2],
    /// What the forces miss, in standard deviations of what form and motion are known by; near 1, or less, where Coulomb's law holds.
    pub misfit: f64,
    /// Samples that slide on both palms.
    pub slides: usize,
    /// Runs of samples that roll on palm 1 and on palm 2.
    pub rolls: [usize; 2],
}

/// Root mean square of what the forces miss, in standard deviations of form and motion, up to which Coulomb's law explains them: right motions
/// leave at most 1, and wrong ones that the contacts alone allow 1.8.
const EXPLAINED: f64 = 1.5;

/// Standard deviations from the least, which is that of a log that asks for none, at which a coefficient of friction is told by the log.
const TOLD_SDS: f64 = 5.0;

impl FrictionEstimate {
    /// Whether there is friction, and Coulomb's law holds.
    pub(crate) fn explains(&self) -> bool {
        self.misfit < EXPLAINED && self.is_told()
    }

    /// Whether the log tells friction on either palm.
    pub(crate) fn is_told(&self) -> bool {
        let sds = self.coefficients.iter().zip(self.coefficient_sds);
        sds.into_iter().any(|(coefficient, sd)| coefficient - LEAST_FRICTION > TOLD_SDS * sd)
    }
}

impl Reconstruction {
    /// The same about the centre of mass of Coulomb's law.
    pub(crate) fn with_friction(mut self, friction: FrictionEstimate) -> Self {
        let [x, y] = friction.center_m;
        let [x_sd, y_sd] = friction.center_sd_m;
        self.shape = self.shape.translated(-x, -y);
        for point in &mut self.outline {
            let (sin, cos) = point.theta_rad.sin_cos();
            point.r_m -= x * cos + y * sin;
            point.r_sd_m = point.r_sd_m.hypot(x_sd * cos).hypot(y_sd * sin);
            (point.x_m, point.y_m) = (point.x_m - x, point.y_m - y);
        }
        for pose in &mut self.motion {
            let (sin, cos) = pose.psi_rad.sin_cos();
            pose.com_x_m += cos * x - sin * y;
            pose.com_y_m += sin * x + cos * y;
            pose.com_sd_m = pose.com_sd_m.hypot(x_sd).hypot(y_sd);
        }
        self.friction = Some(FrictionEstimate { center_m: [0.0; 2], ..friction });
        self
    }
}

/// Whether both palms turn about one hinge that stays: the closed forms of rolling hold for no others.
pub(crate) fn is_hinged(log: &Log) -> bool {
    let hinge = log.samples.first().map(|sample| sample.palms.base1_m);
    log.samples
        .iter()
        .all(|sample| [sample.palms.base1_m, sample.palms.base2_m].iter().all(|base| Some(*base) == hinge))
}

/// Friction and centre of mass behind a result of `log`; `None` where the motion does not tell sticking from sliding, or the palms have no
/// common hinge.
pub fn friction(log: &Log, result: &Reconstruction) -> Option<FrictionEstimate> {
    let corrected = result.calibration.as_ref().map(|of_rig| of_rig.calibration.corrected(log));
    let measurements = Measurements::new(corrected.as_ref().unwrap_or(log), None);
    if measurements.len() != result.motion.len() || measurements.len() < 2 || !is_hinged(log) {
        return None;
    }
    let psi: Vec<f64> = result.motion.iter().map(|pose| pose.psi_rad).collect();
    let starts: Vec<usize> = (1..psi.len()).filter(|&i| result.motion[i].piece != result.motion[i - 1].piece).collect();
    let coefficients = result.shape.coefficients();
    let psi_sd = psi_sd_by_contacts(&measurements, &coefficients, &psi, result.sensor_sd_m);
    let regimes: Vec<Regime> = regimes(&measurements, &psi, &psi_sd, &starts);
    if regimes.iter().all(|regime| regime.place == Place::Anywhere) {
        return None;
    }
    let found =
        center_and_friction(&measurements, &coefficients, &psi, &psi_sd, &regimes, result.shape.mean_radius_m())?;
    let sd = |index: usize| found.covariance[(index, index)].max(0.0).sqrt();
    Some(FrictionEstimate {
        coefficients: found.coefficients,
        coefficient_sds: [sd(2), sd(3)],
        center_m: found.center_m,
        center_sd_m: [sd(0), sd(1)],
        misfit: found.misfit,
        slides: found.slides,
        rolls: found.runs,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::palms::PalmPair;
    use crate::reconstruct::{ReconstructOptions, Reconstructor, Start};
    use crate::sensor::Touchpad;
    use crate::shape::SupportFunction;
    use crate::simulate::{SimulateOptions, Simulation, simulate};

    fn estimate() -> FrictionEstimate {
        FrictionEstimate {
            coefficients: [0.2, 0.0],
            coefficient_sds: [0.039, 0.01],
            center_m: [0.0; 2],
            center_sd_m: [1e-4; 2],
            misfit: 1.0,
            slides: 10,
            rolls: [2, 3],
        }
    }

    #[test]
    fn friction_explains_where_it_is_told_and_the_forces_agree() {
        assert!(estimate().explains());
        assert!(!FrictionEstimate { coefficient_sds: [0.041, 0.01], ..estimate() }.explains());
        assert!(FrictionEstimate { misfit: 0.99 * EXPLAINED, ..estimate() }.explains());
        assert!(!FrictionEstimate { misfit: 1.01 * EXPLAINED, ..estimate() }.explains());
        // The least there is, however well it is known, is none.
        let least = FrictionEstimate { coefficients: [LEAST_FRICTION; 2], coefficient_sds: [1e-9; 2], ..estimate() };
        assert!(!least.explains());
    }

    /// An object that is squeezed and turned for 40 s between palms with friction.
    fn sticky(friction: [f64; 2]) -> Simulation {
        let shape = SupportFunction::new(0.03, vec![[2e-3, -1e-3], [1.8e-3, 6e-4], [-5e-4, 7e-4]]);
        let at = |index: u32| {
            let t = 0.05 * f64::from(index);
            (t, PalmPair::hinged(0.9 + 0.3 * (0.7 * t).sin(), 1.2 + 0.4 * (0.9 * t + 0.5).sin()))
        };
        let motion: Vec<(f64, PalmPair)> = (0..800).map(at).collect();
        let touchpad = Touchpad { noise_sd_m: 3e-5, ..Touchpad::ideal() };
        let options = SimulateOptions { touchpad, friction, start_psi_rad: 0.4, ..SimulateOptions::default() };
        simulate(&shape, &motion, &options).expect("possible")
    }

    #[test]
    fn friction_and_centre_of_mass_come_out_of_form_and_motion() {
        for coefficients in [[0.1, 0.1], [0.05, 0.2]] {
            let run = sticky(coefficients);
            let psi_rad: Vec<f64> = run.truth.motion.iter().map(|pose| pose.psi_rad).collect();
            let support = run.truth.support.iter().step_by(4).copied().collect::<Vec<_>>();
            let shape = SupportFunction::from_samples(&support, 6).expect("enough of them");
            // A form about another origin, and the true motion.
            let moved = shape.translated(2e-3, -1e-3);
            let start = Start::Motion { shape: moved.clone(), psi_rad };
            let found =
                Reconstructor::from(ReconstructOptions::default()).start(start).run(&run.log).expect("a result");
            let turned = run.truth.motion[0].psi_rad;
            let result = Reconstruction {
                shape: SupportFunction::from_samples(
                    &support.iter().map(|(theta, _)| (*theta, moved.at(theta - turned).r)).collect::<Vec<_>>(),
                    6,
                )
                .expect("enough of them"),
                motion: found
                    .motion
                    .iter()
                    .zip(&run.truth.motion)
                    .map(|(pose, truth)| crate::reconstruct::Pose {
                        psi_rad: truth.psi_rad - turned,
                        piece: 0,
                        ..*pose
                    })
                    .collect(),
                sensor_sd_m: 3e-5,
                ..found
            };
            let friction = friction(&run.log, &result).expect("a motion that tells");
            for palm in 0..2 {
                let off = friction.coefficients[palm] - coefficients[palm];
                assert!(off.abs() < 0.1 * coefficients[palm], "{coefficients:?}: {friction:?}");
            }
            let about_center = result.with_friction(friction).shape;
            let off_m = |theta: f64| about_center.at(theta).r - shape.at(theta - turned).r;
            assert!((0..12).all(|i| off_m(0.5 * f64::from(i)).abs() < 2e-4), "{coefficients:?}: {friction:?}");
        }
    }
}
