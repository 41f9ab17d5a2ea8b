//! The long valley of the cost along what is known least of a shape: where the centre of mass of a nearly round object is. Samples at
//! wrong poses, each at a minimum of its own, bar the way down it, so that other places of it are looked at.

use crate::estimate::measurements::Problem;
use crate::estimate::solver::gauss_newton::Fit;
use crate::estimate::solver::gauss_newton::{Estimate, Smoother};

/// Standard deviations from the optimum at which the valley is looked at, up and down.
const FAR: f64 = 4.0;

/// A valley shorter than this share of the mean radius (one standard deviation) hides nothing.
const SHORT: f64 = 1e-3;

/// Estimates on both sides of an optimum; none where all of the shape is known well.
pub(crate) fn both_ways(problem: &Problem, fit: &Fit) -> Option<[Estimate; 2]> {
    let smoother = Smoother::new(problem, fit.order, fit.noise, fit.prior);
    let (sd_m, direction) = smoother.belief(&fit.estimate)?.weakest_direction()?;
    let long = sd_m > SHORT * fit.estimate.coefficients[0].abs();
    let step = direction * (FAR * sd_m);
    long.then(|| [-1.0, 1.0].map(|side| smoother.moved(&fit.estimate, &(&step * side))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::model::noise::Noise;
    use crate::estimate::model::prior::Prior;
    use crate::sensor::Touchpad;
    use crate::shape::SupportFunction;
    use crate::plan::{PalmLimits, plan_turn};
    use crate::simulate::{SimulateOptions, simulate};

    const SIZE_M: f64 = 0.03;

    /// The optimum of a log of a nearly round object with a little noise, half of which is left out.
    fn optimum(samples: usize) -> (Problem, Fit) {
        let shape = SupportFunction::new(SIZE_M, vec![[1e-3, -5e-4], [4e-4, 2e-4], [-2e-4, 1e-4]]);
        let plan = plan_turn(&shape, &PalmLimits::default(), 40.0).expect("a motion without a jump");
        let options = SimulateOptions {
            start_psi_rad: plan.start_psi_rad,
            touchpad: Touchpad { noise_sd_m: 1e-4, ..Touchpad::ideal() },
            ..SimulateOptions::default()
        };
        let motion = plan.motion.sample(20.0).expect("possible");
        let mut run = simulate(&shape, &motion, &options).expect("possible");
        run.log.samples.truncate(samples);
        let psi = run.truth.motion.iter().take(samples).map(|pose| pose.psi_rad).collect();
        let problem = Problem::new(&run.log, None);
        let noise = Noise { sensor_m: 1e-4, balance_m: 2e-5 };
        let prior = Prior { size_m: SIZE_M, scale_m: 0.5 * SIZE_M };
        let estimate = Estimate { coefficients: shape.coefficients(), psi, cost: 0.0 };
        (problem, Fit { estimate, order: 3, noise, prior, log_evidence: 0.0 })
    }

    #[test]
    fn a_log_that_tells_all_has_no_valley_and_a_short_one_has() {
        let (problem, fit) = optimum(800);
        assert!(both_ways(&problem, &fit).is_none());
        let (problem, fit) = optimum(120);
        let [one, other] = both_ways(&problem, &fit).expect("a valley");
        let centre = |estimate: &Estimate| (estimate.coefficients[1], estimate.coefficients[4]);
        let ((x, y), (x1, y1), (x2, y2)) = (centre(&fit.estimate), centre(&one), centre(&other));
        // The first harmonic moves, to both sides by as much.
        assert!((x1 - x).hypot(y1 - y) > 4e-5, "{x1} {x} {y1} {y}");
        assert!((x1 + x2 - 2.0 * x).abs() < 1e-12 && (y1 + y2 - 2.0 * y).abs() < 1e-12);
    }
}
