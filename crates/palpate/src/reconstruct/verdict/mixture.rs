//! Error bars of a mixture of models of one log: how far their optima are apart counts as what each leaves open does (J. A. Hoeting et al., *Bayesian
//! model averaging: a tutorial*, Statistical Science 14, 1999; `docs/theory.md`, what the log says of itself).

use super::uncertainty::{FoundRig, PoseErrorBars, Uncertainty};
use crate::estimate::jumps::DetectedJump;
use crate::estimate::measurements::Instant;
use crate::estimate::solver::gauss_newton::Estimate;
use crate::log::Log;
use crate::math::angle::{mean_direction, wrapped};
use crate::mechanics::ContactMode;
use crate::palms::PalmPair;
use crate::reconstruct::result::friction::FrictionEstimate;
use crate::reconstruct::result::inertia::InertiaEstimate;
use crate::shape::SupportFunction;

/// Another model of the log, against the optimum that is the answer.
pub(crate) struct OtherModel<'a> {
    /// Its probability; negative for what the answer's own error bars count already.
    weight: f64,
    /// What it leaves open itself; `None` for no more than the answer.
    of: Option<&'a dyn Uncertainty>,
    shape: SupportFunction,
    /// The rotation that brings it to the answer.
    turned_rad: f64,
    /// How far ψ and the centre of mass are from those of the answer at each sample, radians and metres.
    psi_rad: Vec<f64>,
    center_m: Vec<f64>,
}

impl<'a> OtherModel<'a> {
    /// Of the optimum that is the answer and another one, for the palms at each sample.
    pub fn new(
        weight: f64,
        of: Option<&'a dyn Uncertainty>,
        [answer, other]: [&Estimate; 2],
        palms: &[PalmPair],
    ) -> Self {
        let apart = || other.psi.iter().zip(&answer.psi).map(|(other, psi)| other - psi);
        let turned_rad = mean_direction(apart());
        let [of_answer, shape] = [answer, other].map(|at| SupportFunction::from_coefficients(&at.coefficients));
        let center = |shape: &SupportFunction, psi: f64, palms: &PalmPair| {
            let (theta1, theta2) = palms.contact_angles(psi);
            palms.center_of_mass_m(shape.at(theta1), shape.at(theta2))
        };
        let samples = answer.psi.iter().zip(&other.psi).zip(palms);
        let center_m = samples
            .map(|((psi, other), palms)| {
                let ([x, y], [other_x, other_y]) = (center(&of_answer, *psi, palms), center(&shape, *other, palms));
                (other_x - x).hypot(other_y - y) / 2_f64.sqrt()
            })
            .collect();
        let psi_rad = apart().map(|apart| wrapped(apart - turned_rad).abs()).collect();
        Self { weight, of, shape, turned_rad, psi_rad, center_m }
    }
}

/// The error bars of an answer among other models, in the frame of the answer.
pub(crate) struct Mixture<'a> {
    pub answer: &'a dyn Uncertainty,
    pub shape: SupportFunction,
    pub others: Vec<OtherModel<'a>>,
}

struct MixedErrorBars<'a> {
    answer: Box<dyn PoseErrorBars + 'a>,
    others: Vec<Option<Box<dyn PoseErrorBars + 'a>>>,
    of: &'a Mixture<'a>,
}

impl Uncertainty for Mixture<'_> {
    fn error_bars(&self, felt: &[f64], inflation: f64) -> Option<Box<dyn PoseErrorBars + '_>> {
        let answer = self.answer.error_bars(felt, inflation)?;
        let others = self.others.iter().map(|other| {
            let felt: Vec<f64> = felt.iter().map(|theta| theta - other.turned_rad).collect();
            other.of?.error_bars(&felt, inflation)
        });
        Some(Box::new(MixedErrorBars { answer, others: others.collect(), of: self }))
    }

    fn of_rig(&self, inflation: f64) -> Option<FoundRig> {
        self.answer.of_rig(inflation)
    }

    fn inertia(&self, inflation: f64) -> Option<InertiaEstimate> {
        self.answer.inertia(inflation)
    }

    fn friction(&self) -> Option<FrictionEstimate> {
        self.answer.friction()
    }

    fn modes(&self, index: usize) -> Option<[ContactMode; 2]> {
        self.answer.modes(index)
    }

    fn jumps(&self, shape: &SupportFunction, log: &Log, psi: &[f64]) -> Vec<DetectedJump> {
        self.answer.jumps(shape, log, psi)
    }
}

impl MixedErrorBars<'_> {
    /// The standard deviation about the answer, from that of the answer, and for each other model its own and its distance: no model knows more
    /// than the answer does.
    fn mixed(&self, sd: f64, other: impl Fn(&OtherModel, Option<&dyn PoseErrorBars>) -> (f64, f64)) -> f64 {
        let others = self.of.others.iter().zip(&self.others);
        let more = others.map(|(model, bars)| {
            let (own, apart) = other(model, bars.as_deref());
            model.weight * ((own * own - sd * sd).max(0.0) + apart * apart)
        });
        (sd * sd + more.sum::<f64>().max(0.0)).sqrt()
    }

    fn of_boundary_m(&self, theta: f64, sd_m: impl Fn(&dyn PoseErrorBars, f64) -> f64) -> f64 {
        self.mixed(sd_m(&*self.answer, theta), |model, bars| {
            let there = theta - model.turned_rad;
            (bars.map_or(0.0, |bars| sd_m(bars, there)), model.shape.at(there).r - self.of.shape.at(theta).r)
        })
    }
}

impl PoseErrorBars for MixedErrorBars<'_> {
    fn r_sd_m(&self, theta: f64) -> f64 {
        self.of_boundary_m(theta, |bars, theta| bars.r_sd_m(theta))
    }

    fn form_sd_m(&self, theta: f64) -> f64 {
        self.of_boundary_m(theta, |bars, theta| bars.form_sd_m(theta))
    }

    fn pose_sd(&self, index: usize, instant: &Instant) -> (f64, f64) {
        let (psi_rad, center_m) = self.answer.pose_sd(index, instant);
        let own = |bars: Option<&dyn PoseErrorBars>| bars.map_or((0.0, 0.0), |bars| bars.pose_sd(index, instant));
        (
            self.mixed(psi_rad, |model, bars| (own(bars).0, model.psi_rad[index])),
            self.mixed(center_m, |model, bars| (own(bars).1, model.center_m[index])),
        )
    }

    fn deviance_of(&self, jumps: &[DetectedJump]) -> Option<f64> {
        self.answer.deviance_of(jumps)
    }

    fn may_be_without_barrier(&self, jump: &DetectedJump) -> bool {
        self.answer.may_be_without_barrier(jump)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::palms::{PalmAngles, PalmPair};

    /// The same standard deviations everywhere.
    struct Flat {
        r_m: f64,
        psi_rad: f64,
    }

    impl Uncertainty for Flat {
        fn error_bars(&self, _: &[f64], _: f64) -> Option<Box<dyn PoseErrorBars + '_>> {
            Some(Box::new(Self { ..*self }))
        }

        fn of_rig(&self, _: f64) -> Option<FoundRig> {
            None
        }

        fn inertia(&self, _: f64) -> Option<InertiaEstimate> {
            None
        }

        fn friction(&self) -> Option<FrictionEstimate> {
            None
        }
    }

    impl PoseErrorBars for Flat {
        fn r_sd_m(&self, _: f64) -> f64 {
            self.r_m
        }

        fn pose_sd(&self, _: usize, _: &Instant) -> (f64, f64) {
            (self.psi_rad, self.r_m)
        }

        fn deviance_of(&self, _: &[DetectedJump]) -> Option<f64> {
            Some(0.0)
        }
    }

    const ANSWER: Flat = Flat { r_m: 1e-5, psi_rad: 0.01 };

    fn estimate(radius_m: f64, turn: f64) -> Estimate {
        Estimate { coefficients: vec![radius_m, 0.0, 0.0], psi: vec![0.0, turn], cost: 0.0 }
    }

    /// Standard deviations of r and of ψ at the second of two samples.
    fn mixed(weight: f64, of: &Flat, other: &Estimate) -> (f64, f64) {
        let answer = estimate(0.03, 0.5);
        let palms = [PalmPair::hinged(1.0, 1.2); 2];
        let other = OtherModel::new(weight, Some(of), [&answer, other], &palms);
        let shape = SupportFunction::from_coefficients(&answer.coefficients);
        let mixture = Mixture { answer: &ANSWER, shape, others: vec![other] };
        let bars = mixture.error_bars(&[0.0, 1.0], 1.0).expect("error bars");
        let palms = PalmAngles::new(1.0, 1.2);
        let instant = Instant {
            palms,
            phi1: 1.0,
            phi2: 1.2,
            s1: 0.03,
            s2: 0.03,
            weight1: 1.0,
            weight2: 1.0,
            balance_weight: 1.0,
            position: 1.0,
        };
        (bars.r_sd_m(0.7), bars.pose_sd(1, &instant).0)
    }

    fn close(value: f64, expected: f64) {
        assert!((value - expected).abs() < 1e-9 * expected, "{value} instead of {expected}");
    }

    #[test]
    fn a_certain_model_elsewhere_adds_its_distance_and_its_own_error_bars() {
        let other = Flat { r_m: 2e-5, psi_rad: 0.02 };
        let (r_m, psi_rad) = mixed(1.0, &other, &estimate(0.0301, 0.6));
        close(r_m, f64::hypot(2e-5, 1e-4));
        // The best rotation takes half of the difference of the turns away.
        close(psi_rad, f64::hypot(0.02, 0.05));
    }

    #[test]
    fn models_count_by_their_probability() {
        let (r_m, psi_rad) = mixed(0.25, &ANSWER, &estimate(0.0301, 0.6));
        close(r_m, f64::hypot(1e-5, 0.5 * 1e-4));
        close(psi_rad, f64::hypot(0.01, 0.5 * 0.05));
    }

    #[test]
    fn no_model_takes_from_what_the_answer_leaves_open() {
        let (r_m, psi_rad) = mixed(1.0, &Flat { r_m: 0.0, psi_rad: 0.0 }, &estimate(0.03, 0.5));
        close(r_m, ANSWER.r_m);
        close(psi_rad, ANSWER.psi_rad);
    }
}
