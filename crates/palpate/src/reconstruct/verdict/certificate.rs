//! The certificate (`docs/theory.md`, the certificate): tests of consistency, convexity, jumps, stability, ambiguity and
//! precision against [`CertificateLimits`]. A certified result that is wrong is the worst failure, so that every failed test is a
//! [`Doubt`].

use super::doubt::{Doubt, Verdict};
use crate::reconstruct::options::limits::CertificateLimits;

/// The quantities that the certificate tests, as numbers: a verdict by other limits needs no new reconstruction.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct Findings {
    /// Samples of the log.
    pub samples: usize,
    /// Mean radius of the shape, metres.
    pub mean_radius_m: f64,
    /// How far the shape is from a convex one, metres.
    pub concavity_m: f64,
    /// Weighted squared residuals of the contact positions per degree of freedom.
    pub chi2_per_dof: f64,
    /// Degrees of freedom of the contact positions.
    pub dof: f64,
    /// Whether log or user state the noise.
    pub noise_stated: bool,
    /// Root mean square of what the fit leaves in the contact positions, metres.
    pub sensor_m: f64,
    /// The same of most of them, from the median, metres.
    pub typical_sensor_m: f64,
    /// Root mean square that their noise explains, metres.
    pub expected_sensor_m: f64,
    /// Standard deviation of the balance, metres.
    pub balance_m: f64,
    /// Jumps that statics does not allow the object found.
    pub unphysical_jumps: usize,
    /// Time (seconds) of the first of them, and by how much the object would turn (radians).
    pub first_unphysical_jump: Option<(f64, f64)>,
    /// Jumps that the next one undoes at once.
    pub jump_reversals: usize,
    /// The smallest turn in a jump, radians; infinite without a jump.
    pub shortest_jump_rad: f64,
    /// Samples at rest at a pose that is no minimum of the energy.
    pub unstable: usize,
    /// Share of the boundary that was felt.
    pub coverage: f64,
    /// Samples with an ambiguous pose.
    pub ambiguous: usize,
    /// By how much the orientation would be wrong if those of them were elsewhere that are no few single ones, told by their own error bars: radians
    /// (root mean square over all samples).
    pub ambiguity_rad: f64,
    /// Standard deviation of ψ over all samples that could be placed, radians: root mean square.
    pub psi_sd_rad: f64,
    /// The largest of them, radians.
    pub largest_psi_sd_rad: f64,
    /// Largest standard deviation of r over the felt boundary, metres: of the form alone where the centre of mass is not known.
    pub largest_felt_r_sd_m: f64,
    /// Standard deviation of the centre of mass where it is so large that the form is known better than its place about it, metres; else 0.
    pub center_sd_m: f64,
    /// Contact readings, and how many of them were left out as gross outliers.
    pub readings: usize,
    /// See `readings`.
    pub outliers: usize,
    /// Probability of the symmetry of the object found; `None` where it has none.
    pub symmetry_probability: Option<f64>,
    /// Standard deviation of the difference between felt copies of the same boundary, metres; `None` where it has none.
    pub symmetry_deviation_sd_m: Option<f64>,
    /// The constant of the rig that the log has furthest from what the rig was stated to have, and how far, in standard deviations of the
    /// statement; `None` where every constant is exact.
    pub furthest_constant: Option<(String, f64)>,
    /// By how much the constants of the rig would still move, in standard deviations.
    pub rig_unsettled_sds: f64,
}

/// Share of outliers that a refusal for other reasons mentions: so many leave some behind that are not as gross, and are not seen.
const OUTLIERS_THAT_EXPLAIN: f64 = 0.005;

/// What the fit leaves is negligible below this share of what no shape explains: an exact log leaves the corners of the object there.
const NEGLIGIBLE: f64 = 0.1;

/// The doubt that so many outliers among the readings are, besides others: where they are many, or may be the reason of those.
pub(crate) fn doubt_of_outliers(
    outliers: usize,
    readings: usize,
    doubts: &[Doubt],
    limits: &CertificateLimits,
) -> Option<Doubt> {
    let share = outliers as f64 / readings.max(1) as f64;
    let is_doubt = share > limits.outliers || (share > OUTLIERS_THAT_EXPLAIN && !doubts.is_empty());
    is_doubt.then_some(Doubt::Outliers { outliers, readings })
}

impl Findings {
    /// The verdict by these limits.
    pub fn verdict(&self, limits: &CertificateLimits) -> Verdict {
        let mut doubts = self.contradictions(limits);
        doubts.extend(self.gaps(limits));
        doubts.extend(doubt_of_outliers(self.outliers, self.readings, &doubts, limits));
        let balanced = self.balance_m <= limits.balance_m(self.expected_sensor_m, self.mean_radius_m.abs());
        if doubts.is_empty() && !balanced {
            doubts.push(Doubt::Unbalanced { balance_sd_m: self.balance_m });
        } else if doubts.is_empty() && self.center_sd_m > 0.0 {
            doubts.push(Doubt::UncertainCenter { sd_m: self.center_sd_m });
        }
        Verdict::new(doubts)
    }

    /// Doubts that contradict the result.
    fn contradictions(&self, limits: &CertificateLimits) -> Vec<Doubt> {
        let mut doubts = Vec::new();
        if !(self.mean_radius_m.is_finite() && self.mean_radius_m > 0.0) {
            doubts.push(Doubt::NegativeRadius);
        }
        if let Some((time_s, turn_rad)) = self.first_unphysical_jump {
            doubts.push(Doubt::UnphysicalJumps { time_s, turn_rad, jumps: self.unphysical_jumps });
        }
        if self.chi2_per_dof > limits.chi2(self.dof, self.noise_stated) || !self.chi2_per_dof.is_finite() {
            let (left_m, expected_m) = (self.sensor_m, self.expected_sensor_m);
            doubts.push(Doubt::Misfit { left_m, expected_m, stated: self.noise_stated });
        }
        if self.concavity_m > limits.concavity * self.mean_radius_m {
            doubts.push(Doubt::NotConvex);
        }
        if self.unstable as f64 > limits.unstable_share * self.samples as f64 {
            doubts.push(Doubt::UnstablePoses { samples: self.unstable, of: self.samples });
        }
        doubts
    }

    /// Doubts about what the log does not determine.
    fn gaps(&self, limits: &CertificateLimits) -> Vec<Doubt> {
        let mut doubts = Vec::new();
        if self.coverage < limits.coverage {
            doubts.push(Doubt::LittleFelt { coverage: self.coverage });
        }
        if self.ambiguity_rad > limits.ambiguity_rad {
            doubts.push(Doubt::AmbiguousPoses { samples: self.ambiguous, ambiguity_rad: self.ambiguity_rad });
        }
        if self.jump_reversals > limits.reversals {
            doubts.push(Doubt::JumpReversals { reversals: self.jump_reversals });
        }
        if !(self.psi_sd_rad <= limits.psi_sd_rad && self.largest_psi_sd_rad <= limits.largest_psi_sd_rad) {
            let (sd_rad, largest_sd_rad) = (self.psi_sd_rad, self.largest_psi_sd_rad);
            doubts.push(Doubt::UncertainOrientation { sd_rad, largest_sd_rad });
        }
        let short = self.shortest_jump_rad < limits.short_jump_rad;
        let r_sd = if short { limits.r_sd_with_short_jumps } else { limits.r_sd };
        // Not a number is not known.
        let known = self.largest_felt_r_sd_m <= r_sd * self.mean_radius_m;
        if !known || !self.largest_felt_r_sd_m.is_finite() {
            doubts.push(Doubt::UncertainBoundary { sd_m: self.largest_felt_r_sd_m });
        }
        // Much less than what no shape explains may be as uneven as it likes.
        let typical_m = self.typical_sensor_m.max(NEGLIGIBLE * limits.model_allowance * self.mean_radius_m.abs());
        if self.sensor_m > limits.tails * typical_m {
            doubts.push(Doubt::StrayReadings { typical_m: self.typical_sensor_m, all_m: self.sensor_m });
        }
        if let Some((probability, deviation_sd_m)) = self.symmetry_probability.zip(self.symmetry_deviation_sd_m) {
            let known = deviation_sd_m <= limits.symmetry_deviation * self.mean_radius_m;
            if !(probability >= limits.symmetry_probability && known) {
                doubts.push(Doubt::UncertainSymmetry { probability, deviation_sd_m });
            }
        }
        if let Some((constant, off_sds)) = self.furthest_constant.clone().filter(|(_, off)| *off > limits.rig_off_sds) {
            doubts.push(Doubt::UnlikelyRig { constant, off_sds });
        }
        if self.rig_unsettled_sds > limits.rig_unsettled_sds {
            doubts.push(Doubt::UnsettledRig { sds: self.rig_unsettled_sds });
        }
        doubts
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Findings without a doubt.
    fn sound() -> Findings {
        Findings {
            samples: 400,
            mean_radius_m: 0.03,
            concavity_m: 0.0,
            chi2_per_dof: 1.0,
            dof: 1e6,
            noise_stated: false,
            sensor_m: 1e-4,
            typical_sensor_m: 1e-4,
            expected_sensor_m: 1e-4,
            balance_m: 1e-5,
            unphysical_jumps: 0,
            first_unphysical_jump: None,
            jump_reversals: 0,
            shortest_jump_rad: f64::INFINITY,
            unstable: 0,
            coverage: 0.9,
            ambiguous: 0,
            ambiguity_rad: 0.0,
            psi_sd_rad: 1e-3,
            largest_psi_sd_rad: 1e-2,
            largest_felt_r_sd_m: 1e-5,
            center_sd_m: 0.0,
            readings: 800,
            outliers: 0,
            symmetry_probability: None,
            symmetry_deviation_sd_m: None,
            furthest_constant: None,
            rig_unsettled_sds: 0.0,
        }
    }

    fn verdict(findings: &Findings) -> Verdict {
        findings.verdict(&CertificateLimits::default())
    }

    /// `just` is within its limit, `over` beyond it; nothing else is changed.
    fn crosses(just: &Findings, over: &Findings, expected: &Doubt) {
        assert_eq!(verdict(just), Verdict::default());
        assert_eq!(verdict(over).doubts, std::slice::from_ref(expected));
        assert!(!verdict(over).is_certified() && !verdict(over).is_com_certified());
        assert_eq!(verdict(over).is_explained(), !expected.is_contradiction());
    }

    #[test]
    fn a_sound_result_is_certified() {
        assert!(verdict(&sound()).is_certified() && verdict(&sound()).is_com_certified());
        assert_eq!(verdict(&sound()).reason(), "");
    }

    #[test]
    fn the_mean_radius_must_be_positive() {
        for mean_radius_m in [-0.03, 0.0, f64::NAN] {
            let found = verdict(&Findings { mean_radius_m, ..sound() });
            assert_eq!(found.doubts[0], Doubt::NegativeRadius);
            assert!(!found.is_explained());
        }
    }

    #[test]
    fn every_jump_must_be_physical() {
        let unphysical = Findings { unphysical_jumps: 2, first_unphysical_jump: Some((2.0, 1.5)), ..sound() };
        let expected = Doubt::UnphysicalJumps { time_s: 2.0, turn_rad: 1.5, jumps: 2 };
        crosses(&Findings { shortest_jump_rad: 1.5, ..sound() }, &unphysical, &expected);
        assert!(expected.to_string().contains("2.000 s and 1 more"), "{expected}");
    }

    #[test]
    fn chi2_may_exceed_one_by_a_half_or_by_a_fifth_of_stated_noise() {
        for (noise_stated, excess) in [(false, 0.5), (true, 0.2)] {
            let at = |chi2_per_dof| Findings { chi2_per_dof, noise_stated, ..sound() };
            let expected = Doubt::Misfit { left_m: 1e-4, expected_m: 1e-4, stated: noise_stated };
            crosses(&at(1.0 + excess - 1e-6), &at(1.0 + excess + 1e-6), &expected);
        }
        let found = verdict(&Findings { chi2_per_dof: f64::NAN, ..sound() });
        assert!(matches!(found.doubts[..], [Doubt::Misfit { .. }]));
    }

    #[test]
    fn chi2_of_few_readings_may_exceed_one_by_six_of_its_standard_deviations() {
        // √(2/dof) = 0.2.
        let at = |chi2_per_dof| Findings { chi2_per_dof, dof: 50.0, ..sound() };
        let expected = Doubt::Misfit { left_m: 1e-4, expected_m: 1e-4, stated: false };
        crosses(&at(2.2 - 1e-6), &at(2.2 + 1e-6), &expected);
    }

    #[test]
    fn the_shape_must_be_convex_but_for_less_than_any_error_bar() {
        // 0.01 % of 30 mm.
        let at = |concavity_m| Findings { concavity_m, ..sound() };
        crosses(&at(2.99e-6), &at(3.01e-6), &Doubt::NotConvex);
    }

    #[test]
    fn one_pose_in_a_hundred_may_be_unstable() {
        let at = |unstable| Findings { unstable, ..sound() };
        crosses(&at(4), &at(5), &Doubt::UnstablePoses { samples: 5, of: 400 });
    }

    #[test]
    fn a_tenth_of_the_boundary_must_be_felt() {
        let at = |coverage| Findings { coverage, ..sound() };
        crosses(&at(0.1), &at(0.099), &Doubt::LittleFelt { coverage: 0.099 });
    }

    #[test]
    fn ambiguous_poses_may_move_the_motion_by_a_hundredth_of_a_radian() {
        let at = |ambiguity_rad| Findings { ambiguous: 3, ambiguity_rad, ..sound() };
        crosses(&at(0.01), &at(0.0101), &Doubt::AmbiguousPoses { samples: 3, ambiguity_rad: 0.0101 });
    }

    #[test]
    fn a_centre_of_mass_that_is_not_known_leaves_shape_and_motion_certified() {
        let verdict = verdict(&Findings { center_sd_m: 3e-3, ..sound() });
        assert_eq!(verdict.doubts, [Doubt::UncertainCenter { sd_m: 3e-3 }]);
        assert!(verdict.is_certified() && !verdict.is_com_certified());
    }

    #[test]
    fn one_reversal_of_a_jump_is_attributed_to_noise() {
        let at = |jump_reversals| Findings { jump_reversals, shortest_jump_rad: 1.0, ..sound() };
        crosses(&at(1), &at(2), &Doubt::JumpReversals { reversals: 2 });
    }

    #[test]
    fn the_orientation_must_be_known_over_all_and_at_the_worst() {
        let over_all = |psi_sd_rad| Findings { psi_sd_rad, ..sound() };
        let expected = Doubt::UncertainOrientation { sd_rad: 0.0301, largest_sd_rad: 1e-2 };
        crosses(&over_all(0.03), &over_all(0.0301), &expected);
        let at_worst = |largest_psi_sd_rad| Findings { largest_psi_sd_rad, ..sound() };
        let expected = Doubt::UncertainOrientation { sd_rad: 1e-3, largest_sd_rad: 0.301 };
        crosses(&at_worst(0.3), &at_worst(0.301), &expected);
        assert!(!verdict(&over_all(f64::NAN)).is_certified());
    }

    #[test]
    fn the_felt_boundary_must_be_known_to_two_per_cent_and_better_where_jumps_are_short() {
        let at = |largest_felt_r_sd_m| Findings { largest_felt_r_sd_m, ..sound() };
        crosses(&at(6e-4), &at(6.01e-4), &Doubt::UncertainBoundary { sd_m: 6.01e-4 });
        assert!(!verdict(&at(f64::INFINITY)).is_certified());
        let between = |shortest_jump_rad| Findings { shortest_jump_rad, ..at(6e-4) };
        crosses(&between(0.25), &between(0.249), &Doubt::UncertainBoundary { sd_m: 6e-4 });
        let known_better = |largest_felt_r_sd_m| Findings { shortest_jump_rad: 0.1, ..at(largest_felt_r_sd_m) };
        crosses(&known_better(1.5e-4), &known_better(1.51e-4), &Doubt::UncertainBoundary { sd_m: 1.51e-4 });
    }

    #[test]
    fn the_center_of_mass_alone_is_in_doubt_where_the_balance_is_missed() {
        // By noise: three standard deviations of the contacts; by the model: four times 0.2 % of the radius.
        for (expected_sensor_m, limit_m) in [(1e-4, 3e-4), (1e-6, 2.4e-4)] {
            let at = |balance_m| Findings { balance_m, expected_sensor_m, ..sound() };
            assert!(verdict(&at(limit_m - 1e-9)).is_com_certified());
            let missed = verdict(&at(limit_m + 1e-9));
            assert!(missed.is_certified() && !missed.is_com_certified() && missed.is_explained());
            assert_eq!(missed.doubts, [Doubt::Unbalanced { balance_sd_m: limit_m + 1e-9 }]);
        }
        // Where the shape is not certified, the balance raises no doubt of its own.
        let both = verdict(&Findings { concavity_m: 1e-3, balance_m: 1.0, ..sound() });
        assert_eq!(both.doubts, [Doubt::NotConvex]);
    }

    #[test]
    fn a_few_readings_may_make_the_root_mean_square_twice_that_of_most() {
        let at = |typical_sensor_m, sensor_m| Findings { typical_sensor_m, sensor_m, ..sound() };
        let expected = |typical_m, all_m| Doubt::StrayReadings { typical_m, all_m };
        crosses(&at(5.01e-5, 1e-4), &at(4.99e-5, 1e-4), &expected(4.99e-5, 1e-4));
        // 0.1 of 0.2 % of 30 mm is 6 µm.
        crosses(&at(1e-9, 1.19e-5), &at(1e-9, 1.21e-5), &expected(1e-9, 1.21e-5));
    }

    #[test]
    fn outliers_are_a_doubt_when_they_are_many_and_a_reason_when_something_else_is() {
        let at = |outliers| Findings { outliers, ..sound() };
        crosses(&at(80), &at(81), &Doubt::Outliers { outliers: 81, readings: 800 });
        let misfit = |outliers| verdict(&Findings { concavity_m: 1e-3, outliers, ..sound() }).doubts;
        assert_eq!(misfit(4), [Doubt::NotConvex]);
        assert_eq!(misfit(5), [Doubt::Outliers { outliers: 5, readings: 800 }, Doubt::NotConvex]);
    }

    #[test]
    fn a_symmetry_must_be_nine_times_as_likely_as_all_else_and_its_copies_compared_to_a_hundredth() {
        let symmetry_deviation_sd_m = Some(1e-4);
        let at = |probability| Findings { symmetry_probability: Some(probability), symmetry_deviation_sd_m, ..sound() };
        crosses(&at(0.9), &at(0.899), &Doubt::UncertainSymmetry { probability: 0.899, deviation_sd_m: 1e-4 });
        let at = |sd_m| Findings { symmetry_deviation_sd_m: Some(sd_m), ..at(0.99) };
        crosses(&at(3e-4), &at(3.01e-4), &Doubt::UncertainSymmetry { probability: 0.99, deviation_sd_m: 3.01e-4 });
        assert!(!verdict(&at(f64::NAN)).is_certified());
    }

    #[test]
    fn limits_can_be_set_and_invalid_ones_are_refused() {
        let mut limits = CertificateLimits { r_sd: 1e-4, ..CertificateLimits::default() };
        assert!(!sound().verdict(&limits).is_certified());
        assert!(limits.check().is_ok());
        limits.chi2_sds = -1.0;
        assert!(limits.check().is_err_and(|error| error.to_string().contains("chi2_sds")));
        limits.chi2_sds = f64::NAN;
        assert!(limits.check().is_err());
    }

    #[test]
    fn a_constant_of_the_rig_that_is_far_from_its_statement_is_a_doubt() {
        let at = |off_sds| Findings { furthest_constant: Some(("s1_zero_m".to_owned(), off_sds)), ..sound() };
        crosses(&at(2.99), &at(3.01), &Doubt::UnlikelyRig { constant: "s1_zero_m".to_owned(), off_sds: 3.01 });
    }

    #[test]
    fn constants_that_still_move_are_a_doubt() {
        let at = |rig_unsettled_sds| Findings { rig_unsettled_sds, ..sound() };
        crosses(&at(0.49), &at(0.51), &Doubt::UnsettledRig { sds: 0.51 });
    }
}
