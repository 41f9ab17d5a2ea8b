//! One row of the table: what a job was, and what came of it. Nothing in it depends on when or where the job was run.

use serde::{Deserialize, Serialize};

/// A row. `None`, in the table null: not known, not asked for, or not a finite number.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Place of the job in the sweep, from 0.
    pub job: u64,
    /// How far the job came.
    pub status: Status,
    /// Seed of a simulation.
    pub seed: Option<u64>,
    /// What the object is called, or the path of the log.
    pub object: String,
    /// Mean radius of the true object, metres.
    pub mean_radius_m: Option<f64>,
    /// How the palms of a simulation moved.
    pub motion: Option<String>,
    /// Standard deviation of simulated noise on the contact positions before rounding, metres.
    pub noise_sd_m: Option<f64>,
    /// Steps per inch of the simulated pads.
    pub counts_per_inch: Option<f64>,
    /// Standard deviation of simulated noise on the palm angles, radians.
    pub angle_noise_sd_rad: Option<f64>,
    /// Share of readings that a simulation left out.
    pub dropout: Option<f64>,
    /// Samples in the log.
    pub samples: Option<u64>,
    /// True number of jumps in a simulation.
    pub jumps: Option<u64>,
    /// Jumps that were found.
    pub jumps_found: Option<u64>,
    /// Share of the boundary that was felt, as the result has it.
    pub coverage: Option<f64>,
    /// Whether shape and motion are certified.
    pub certified: bool,
    /// Whether the centre of mass is.
    pub com_certified: bool,
    /// Whether the shape is as good as that from the reference: RMS error within 1.5 times.
    pub solved: Option<bool>,
    /// Certified, and worse than the reference by more than chance.
    pub wrong: Option<bool>,
    /// Certified, and in contradiction to its own error bars by the rule of the accuracy study: the RMS error of r,
    /// of ψ, or, where certified, of the centre of mass is beyond five times its RMS error bar, and beyond 0.5 % of the radius or 2 degrees; poses that are open left out.
    pub beyond_error_bars: Option<bool>,
    /// RMS error of r over the felt boundary after the best rotation, metres.
    pub rms_r_m: Option<f64>,
    /// The same after the best translation as well, metres.
    pub rms_form_m: Option<f64>,
    /// Hausdorff distance of the felt boundary, metres.
    pub hausdorff_m: Option<f64>,
    /// RMS error of ψ, radians.
    pub rms_psi_rad: Option<f64>,
    /// RMS error of the centre of mass, metres.
    pub rms_com_m: Option<f64>,
    /// Share of the felt boundary whose true r lies in its 95 % band.
    pub inside_band: Option<f64>,
    /// `rms_r_m` of the reference, a reconstruction that starts from the truth.
    pub reference_rms_r_m: Option<f64>,
    /// `rms_psi_rad` of the reference.
    pub reference_rms_psi_rad: Option<f64>,
    /// `coverage` of the reference.
    pub reference_coverage: Option<f64>,
    /// Cramér-Rao bound of the RMS error of r, metres.
    pub bound_r_m: Option<f64>,
    /// Number of harmonics of the result.
    pub harmonics: Option<u64>,
    /// Arrangements that fit equally well, 1 when the result is unique.
    pub alternatives: Option<u64>,
    /// Order of rotation of the symmetry that was found, 1 for none.
    pub symmetry_order: Option<u64>,
    /// Whether the object was found to be its own mirror image.
    pub symmetry_mirror: Option<bool>,
    /// Weighted squared residuals per degree of freedom.
    pub chi2_per_dof: Option<f64>,
    /// Standard deviation of the contact positions, stated or estimated, metres.
    pub sensor_sd_m: Option<f64>,
    /// Share of the unknown constants of the rig whose true value lies in its 95 % band.
    pub constants_inside_band: Option<f64>,
    /// The largest error of any of them, in its own standard deviations.
    pub worst_constant_sds: Option<f64>,
    /// RMS error of the centre of mass along one axis (the mean of both) over its RMS standard deviation.
    pub com_error_sds: Option<f64>,
    /// Share of the coefficients of friction whose true value lies in its 95 % band, where any were found.
    pub friction_inside_band: Option<f64>,
    /// The larger error of these coefficients; and in their own standard deviations.
    pub worst_friction_error: Option<f64>,
    /// See above.
    pub worst_friction_sds: Option<f64>,
    /// Error of the radius of gyration, where it was found, in its own standard deviations.
    pub gyration_error_sds: Option<f64>,
    /// Why the result is not certified, or why there is none.
    pub reason: String,
}

/// Errors below this are rounding, metres.
const ROUNDING_M: f64 = 1e-6;

impl Row {
    /// Whether the shape is as good as that of the reference: RMS error within 1.5 times. `None` without a reference.
    pub fn is_solved(&self) -> Option<bool> {
        Some(self.rms_r_m? <= 1.5 * self.reference_rms_r_m? + ROUNDING_M)
    }

    /// Whether shape or motion is worse than chance explains: the RMS error of r beyond 3 times that of the reference and 4 times the
    /// bound (where there is one), or that of ψ beyond 3 times that of the reference and 0.02. A certified result must not be. `None`
    /// without a reference.
    pub fn is_beyond_chance(&self) -> Option<bool> {
        let chance_m = (3.0 * self.reference_rms_r_m?).max(4.0 * self.bound_r_m.unwrap_or(0.0)) + ROUNDING_M;
        let chance_rad = (3.0 * self.reference_rms_psi_rad?).max(0.02);
        Some(self.rms_r_m? > chance_m || self.rms_psi_rad? > chance_rad)
    }
}

/// An error in terms of what a result says of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Claimed {
    /// Root mean square of the error.
    pub(crate) error: f64,
    /// Root mean square of the standard deviation claimed.
    pub(crate) sd: f64,
    /// Errors below this harm nobody.
    pub(crate) harmless: f64,
}

/// Own standard deviations beyond which an error is not chance.
const BEYOND_SDS: f64 = 5.0;

/// Errors that harm nobody: of r and of the centre of mass, over the mean radius; of ψ, radians (2 degrees).
pub(crate) const HARMLESS_LENGTH: f64 = 0.005;
pub(crate) const HARMLESS_RAD: f64 = 2.0 * std::f64::consts::PI / 180.0;

impl Claimed {
    /// Whether the error is beyond five of its own standard deviations, and large enough to matter.
    pub(crate) fn is_beyond(self) -> bool {
        self.error > BEYOND_SDS * self.sd && self.error > self.harmless
    }
}

/// How far a job came.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Status {
    /// There was no log: it could not be simulated or read.
    #[default]
    NoLog,
    /// There was a log, but no result.
    NoResult,
    /// There is a result, certified or not.
    Reconstructed,
    /// A panic: a mistake of palpate's own.
    Panicked,
}

impl Status {
    /// Its name, as in the table.
    pub fn name(self) -> &'static str {
        match self {
            Self::NoLog => "no-log",
            Self::NoResult => "no-result",
            Self::Reconstructed => "reconstructed",
            Self::Panicked => "panicked",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row() -> Row {
        Row {
            rms_r_m: Some(1e-4),
            rms_psi_rad: Some(0.01),
            reference_rms_r_m: Some(1e-4),
            reference_rms_psi_rad: Some(0.01),
            ..Row::default()
        }
    }

    #[test]
    fn a_result_is_solved_within_one_and_a_half_times_the_error_of_the_reference() {
        let at = |error_m| Row { rms_r_m: Some(error_m), ..row() }.is_solved();
        assert_eq!((at(1.5e-4), at(1.52e-4)), (Some(true), Some(false)));
        assert_eq!(Row { reference_rms_r_m: None, ..row() }.is_solved(), None);
    }

    #[test]
    fn an_error_is_beyond_its_bars_from_five_on_where_it_matters() {
        let at = |error, sd| Claimed { error, sd, harmless: 1e-4 }.is_beyond();
        assert_eq!((at(4.9e-3, 1e-3), at(5.1e-3, 1e-3)), (false, true));
        assert_eq!((at(9.9e-5, 1e-9), at(1.01e-4, 1e-9)), (false, true));
    }

    #[test]
    fn chance_reaches_to_three_references_and_four_bounds() {
        let shape = |error_m, bound_r_m| Row { rms_r_m: Some(error_m), bound_r_m, ..row() }.is_beyond_chance();
        assert_eq!((shape(3e-4, None), shape(3.02e-4, None)), (Some(false), Some(true)));
        assert_eq!((shape(3.9e-4, Some(1e-4)), shape(4.02e-4, Some(1e-4))), (Some(false), Some(true)));
        let motion = |error_rad| Row { rms_psi_rad: Some(error_rad), ..row() }.is_beyond_chance();
        assert_eq!((motion(0.03), motion(0.031)), (Some(false), Some(true)));
        let small = Row { rms_psi_rad: Some(0.019), reference_rms_psi_rad: Some(0.001), ..row() };
        assert_eq!(small.is_beyond_chance(), Some(false));
        assert_eq!(Row { reference_rms_psi_rad: None, ..row() }.is_beyond_chance(), None);
    }
}
