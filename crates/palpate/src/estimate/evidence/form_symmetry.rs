//! Whether the form of an object nearly comes to itself by a rotation, wherever its centre of mass is: boundary that was not felt is then about as its copies
//! are. Decided by the ratio of the evidences of the prior of such a form and of the general one: both are Gaussian, and so is the likelihood at the
//! optimum of the general one (`docs/theory.md`, what the log says of itself).

use super::symmetry::ORDERS;
use crate::estimate::measurements::Measurements;
use crate::estimate::model::prior::Prior;
use crate::estimate::solver::gauss_newton::{Fit, Smoother};
use nalgebra::{DMatrix, DVector};

/// The prior of the form that is likeliest by the optimum of a general one, which does not come to itself: that of order 1.
pub(crate) fn likeliest_form(measurements: &Measurements, general: &Fit) -> Prior {
    let smoother = Smoother::new(measurements, general.order, general.noise, general.prior).strictly_convex();
    let of_general = smoother.linearise_without_convexity(&general.estimate.coefficients, &general.estimate.psi);
    let optimum = DVector::from_row_slice(&general.estimate.coefficients);
    let pulled = &of_general.matrix * &optimum;
    let with_prior = |prior: &Prior| {
        let mut information: DMatrix<f64> = of_general.matrix.clone();
        let sds = prior.standard_deviations(general.order);
        for (index, (sd, before)) in sds.iter().zip(&smoother.precision).enumerate() {
            information[(index, index)] += 1.0 / (sd * sd) - before;
        }
        let factor = information.cholesky()?;
        let missed = pulled.dot(&optimum) - factor.solve(&pulled).dot(&pulled);
        Some(-0.5 * (missed + factor.ln_determinant()) - sds.iter().map(|sd| sd.ln()).sum::<f64>())
    };
    let priors = ORDERS.map(|form_order| Prior { form_order, ..general.prior });
    let known = priors.into_iter().filter_map(|prior| Some((with_prior(&prior)?, prior)));
    known.max_by(|a, b| a.0.total_cmp(&b.0)).map_or(general.prior, |(_, prior)| prior)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::model::evidence::Evidence;
    use crate::estimate::model::noise::Noise;
    use crate::estimate::solver::gauss_newton::{Estimate, StoppingCriteria};
    use crate::palms::PalmMotion;
    use crate::sensor::Touchpad;
    use crate::shape::{SupportFunction, rounded_polygon};
    use crate::simulate::{SimulateOptions, simulate};

    /// The likeliest order of a form that was felt in part, with its centre of mass off by this share of its radius.
    fn order(form: SupportFunction, off: f64) -> u32 {
        let size_m = form.mean_radius_m();
        let shape = form.translated(off * size_m, 0.5 * off * size_m);
        let motion = PalmMotion::random(3, 20.0, 0.5).and_then(|motion| motion.sample(20.0)).expect("possible");
        let noise = Noise { sensor_m: 5e-5, balance_m: 1e-5 };
        let touchpad = Touchpad { noise_sd_m: noise.sensor_m, ..Touchpad::ideal() };
        let run =
            simulate(&shape, &motion, &SimulateOptions { touchpad, ..SimulateOptions::default() }).expect("possible");
        let measurements = Measurements::new(&run.log, None);
        let psi = run.truth.motion.iter().map(|pose| pose.psi_rad).collect();
        let (order, prior) = (16, Prior::new(size_m, 0.3 * size_m));
        let stopping = StoppingCriteria { iterations: 30, tolerance: 1e-7 };
        let estimate: Estimate =
            Smoother::new(&measurements, order, noise, prior).run(shape.coefficients(), psi, stopping);
        let general = Fit { estimate, order, noise, prior, evidence: Evidence::NONE };
        likeliest_form(&measurements, &general).form_order
    }

    #[test]
    fn the_form_of_a_polygon_comes_to_itself_wherever_its_centre_of_mass_is() {
        for (corners, off) in [(3, 0.0), (3, 0.1), (5, 0.1)] {
            let form = rounded_polygon(corners, 0.3, 0.3).expect("possible").scaled(0.03);
            assert_eq!(order(form, off), corners, "{corners} corners");
        }
        let neither = SupportFunction::new(0.03, vec![[0.0, 0.0], [1.5e-3, 5e-4], [1e-3, -5e-4]]);
        assert_eq!(order(neither, 0.0), 1);
    }
}
