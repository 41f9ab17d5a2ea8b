//! Error bars of an optimum of shape, motion and all else together, from normal equations shaped like an arrow.

use super::uncertainty::PoseErrorBars;
use crate::estimate::jumps::DetectedJump;
use crate::estimate::measurements::Instant;
use crate::estimate::model::layout::Layout;
use crate::estimate::solver::arrow::{BandRow, Eliminated, SplineGivenDense};
use crate::estimate::solver::error_bars::pose_variances;
use crate::estimate::solver::posterior::Posterior;
use nalgebra::{DMatrix, DVector};

pub(crate) struct JointErrorBars<'a> {
    coefficients: &'a [f64],
    layout: Layout,
    /// After the best rotation over the felt boundary, after the best rotation and translation there, and after the best rotation of the motion.
    covariance: DMatrix<f64>,
    of_form: DMatrix<f64>,
    of_motion: DMatrix<f64>,
    motion: SplineGivenDense,
    /// ψ of every sample, and the row of the band that it is.
    samples: Vec<(BandRow, f64)>,
    inflation: f64,
}

impl<'a> JointErrorBars<'a> {
    /// Of a shape with `besides` other unknowns that all samples share; after the best rotation over the boundary at the normal angles `felt`.
    /// `None` where the log does not determine the shape.
    pub fn new(
        eliminated: &Eliminated,
        (coefficients, besides): (&'a [f64], usize),
        samples: Vec<(BandRow, f64)>,
        felt: &[f64],
        inflation: f64,
    ) -> Option<Self> {
        let layout = Layout { order: coefficients.len() / 2, shared: besides };
        let mut mean = DVector::zeros(layout.unknowns());
        mean.rows_mut(0, coefficients.len()).copy_from_slice(coefficients);
        let information = eliminated.information().clone();
        let posterior = Posterior { layout, mean, information };
        let (covariance, of_form) = (posterior.covariance_over(felt)?, posterior.covariance_of_form(felt)?);
        let motion = eliminated.given_dense();
        // Where the centre of mass is uncertain, r about it says little of a rotation, and the motion by itself all.
        let mean_slope =
            samples.iter().fold(DVector::zeros(layout.unknowns()), |sum, (row, _)| sum + motion.slope(*row));
        let of_motion = posterior.covariance_turned_by(&mean_slope)?;
        Some(Self { coefficients, layout, covariance, of_form, of_motion, motion, samples, inflation })
    }

    fn sd(&self, covariance: &DMatrix<f64>, theta: f64) -> f64 {
        let row = self.layout.support_row(theta);
        (self.inflation * (covariance * &row).dot(&row).max(0.0)).sqrt()
    }
}

impl PoseErrorBars for JointErrorBars<'_> {
    fn r_sd_m(&self, theta: f64) -> f64 {
        self.sd(&self.covariance, theta)
    }

    fn form_sd_m(&self, theta: f64) -> f64 {
        self.sd(&self.of_form, theta)
    }

    fn pose_sd(&self, index: usize, instant: &Instant) -> (f64, f64) {
        let (row, psi) = self.samples[index];
        let given = (self.motion.slope(row), self.motion.variance(row));
        let at = (instant, self.coefficients, psi);
        let (of_psi, of_center) = pose_variances(self.layout, &self.of_motion, given, at);
        ((self.inflation * of_psi).sqrt(), (self.inflation * of_center).sqrt())
    }

    fn deviance_of(&self, _: &[DetectedJump]) -> Option<f64> {
        // The forces say where the object goes.
        Some(0.0)
    }
}
