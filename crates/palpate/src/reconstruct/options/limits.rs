//! Every number that decides whether a result is certified, in one place (`docs/constants.md` says why each is what it is, and
//! what half and twice of it do).

use crate::estimate::model::balance_tolerance::{
    BALANCE_ALLOWANCES, BALANCE_SENSOR_SDS, MODEL_ALLOWANCE, STABILITY_SLACK,
};
use crate::reconstruct::options::error::ReconstructError;

/// The limits of the certificate. Shares are of the mean radius unless said otherwise.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default))]
#[non_exhaustive]
pub struct CertificateLimits {
    /// Systematic errors that no shape explains (palms that are not quite slow, not quite straight) are forgiven up to this
    /// share: 0.002. The noise that the fit is held against is never less.
    pub model_allowance: f64,
    /// χ² per degree of freedom may exceed 1 by so many of its own standard deviations, √(2/dof): 6 …
    pub chi2_sds: f64,
    /// … and in any case by this where log or user state the noise (0.2), which real sensors keep to about a tenth,
    pub chi2_excess_stated: f64,
    /// and by this where it is estimated from the scatter of neighbouring samples (0.5), which is good to a fifth.
    pub chi2_excess_estimated: f64,
    /// How far the shape may be from a convex one: 0.0001, less than any error bar. Few harmonics of a corner leave less.
    pub concavity: f64,
    /// Largest share of samples that may rest at a pose that is no minimum of the energy: 0.01 of all samples.
    pub unstable_share: f64,
    /// Error of the stiffness that errors of the shape cause: 0.05.
    pub stability_slack: f64,
    /// Least fraction of the boundary that tells an object: 0.1. Of less, noise alone could pass for the motion of a still one.
    pub coverage: f64,
    /// By how much the motion may be wrong if the ambiguous samples of pieces, or single ones that are more than a hundredth of all, were elsewhere (root
    /// mean square): 0.01 rad. A few single ones are told by their error bars.
    pub ambiguity_rad: f64,
    /// Jump reversals that are attributed to the noise of one sample: 1.
    pub reversals: usize,
    /// Largest standard deviation of ψ, root mean square over all samples: 0.03 rad.
    pub psi_sd_rad: f64,
    /// Largest standard deviation of ψ at any sample: 0.3 rad.
    pub largest_psi_sd_rad: f64,
    /// Largest standard deviation of the felt boundary: 0.02 …
    pub r_sd: f64,
    /// … but this (0.005) where the object jumps between neighbouring poses: such poses may be at wrong minima that hold the
    /// optimum on the slope of a long valley, and the error bars of one optimum know nothing of that.
    pub r_sd_with_short_jumps: f64,
    /// A jump by less than this leads to a neighbouring pose: 0.25 rad.
    pub short_jump_rad: f64,
    /// Share of the contact readings that may be gross outliers, which are left out: 0.1.
    pub outliers: f64,
    /// Root mean square of what the fit leaves in the contact positions, over the standard deviation of most of them: 2. Error bars and
    /// evidence take the errors for Gaussian (1); those of Student's t with three degrees of freedom have 1.5. Beyond, a few readings decide.
    pub tails: f64,
    /// Least probability of a symmetry of the object: 0.9. A less likely one would complete the boundary by a guess.
    pub symmetry_probability: f64,
    /// Largest standard deviation of the difference between felt copies of a symmetric object: 0.01. Beyond, the copies say nothing of
    /// each other, and what is not felt would be a guess.
    pub symmetry_deviation: f64,
    /// A constant of the rig may be off what the rig was stated to have by so many standard deviations: 3.
    pub rig_off_sds: f64,
    /// The constants of the rig may still move by so many standard deviations: 0.5.
    pub rig_unsettled_sds: f64,
    /// Balance holds while its standard deviation is at most so many of the contact positions': 3 …
    pub balance_sensor_sds: f64,
    /// … or so many times `model_allowance`: 4.
    pub balance_allowances: f64,
}

impl Default for CertificateLimits {
    fn default() -> Self {
        Self {
            model_allowance: MODEL_ALLOWANCE,
            chi2_sds: 6.0,
            chi2_excess_stated: 0.2,
            chi2_excess_estimated: 0.5,
            concavity: 1e-4,
            unstable_share: 0.01,
            stability_slack: STABILITY_SLACK,
            coverage: 0.1,
            ambiguity_rad: 0.01,
            reversals: 1,
            psi_sd_rad: 0.03,
            largest_psi_sd_rad: 0.3,
            r_sd: 0.02,
            r_sd_with_short_jumps: 0.005,
            short_jump_rad: 0.25,
            outliers: 0.1,
            tails: 2.0,
            symmetry_probability: 0.9,
            rig_off_sds: 3.0,
            rig_unsettled_sds: 0.5,
            symmetry_deviation: 0.01,
            balance_sensor_sds: BALANCE_SENSOR_SDS,
            balance_allowances: BALANCE_ALLOWANCES,
        }
    }
}

impl CertificateLimits {
    /// The largest χ² per degree of freedom that the noise explains.
    pub(crate) fn chi2(&self, dof: f64, stated: bool) -> f64 {
        let excess = if stated { self.chi2_excess_stated } else { self.chi2_excess_estimated };
        1.0 + (self.chi2_sds * (2.0 / dof).sqrt()).max(excess)
    }

    /// Standard deviation of the balance up to which it holds, metres.
    pub(crate) fn balance_m(&self, sensor_m: f64, mean_radius_m: f64) -> f64 {
        (self.balance_sensor_sds * sensor_m).max(self.balance_allowances * self.model_allowance * mean_radius_m)
    }

    /// # Errors
    /// When a limit is negative or not a number: nothing could be certified, or everything.
    pub(crate) fn check(&self) -> Result<(), ReconstructError> {
        let limits = [
            ("model_allowance", self.model_allowance),
            ("chi2_sds", self.chi2_sds),
            ("chi2_excess_stated", self.chi2_excess_stated),
            ("chi2_excess_estimated", self.chi2_excess_estimated),
            ("concavity", self.concavity),
            ("unstable_share", self.unstable_share),
            ("stability_slack", self.stability_slack),
            ("coverage", self.coverage),
            ("ambiguity_rad", self.ambiguity_rad),
            ("psi_sd_rad", self.psi_sd_rad),
            ("largest_psi_sd_rad", self.largest_psi_sd_rad),
            ("r_sd", self.r_sd),
            ("r_sd_with_short_jumps", self.r_sd_with_short_jumps),
            ("short_jump_rad", self.short_jump_rad),
            ("outliers", self.outliers),
            ("tails", self.tails),
            ("symmetry_probability", self.symmetry_probability),
            ("symmetry_deviation", self.symmetry_deviation),
            ("balance_sensor_sds", self.balance_sensor_sds),
            ("balance_allowances", self.balance_allowances),
        ];
        match limits.into_iter().find(|(_, value)| !(*value >= 0.0 && value.is_finite())) {
            Some((name, value)) => Err(ReconstructError::BadOption(format!(
                "the limit {name} of the certificate must be a number that is not negative, not {value}"
            ))),
            None => Ok(()),
        }
    }
}
