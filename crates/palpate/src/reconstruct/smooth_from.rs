//! Maximum likelihood of shape and motion with everything else given (`docs/theory.md`, maximum likelihood): Gauss-Newton with
//! variable projection and chord steps, without a search, an estimate of the noise, a choice of the number of harmonics or a
//! verdict. For a log whose noise is known and whose motion is known roughly, and for comparison with other solvers.

use crate::estimate::measurements::Measurements;
use crate::estimate::model::noise::Noise;
use crate::estimate::model::prior::Prior;
use crate::estimate::solver::chord::Termination;
use crate::estimate::solver::gauss_newton::{Smoother, StoppingCriteria};
use crate::log::Log;
use crate::reconstruct::options::check::{check_harmonics, check_samples, check_start};
use crate::reconstruct::options::error::ReconstructError;
use crate::shape::SupportFunction;

/// What [`smooth_from`] takes as known. Made by [`SmoothOptions::new`], with struct update for the rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SmoothOptions {
    /// Number of harmonics K of the support function.
    pub harmonics: usize,
    /// Standard deviation of the contact positions, metres; of the others relative to it, where the log states them.
    pub sensor_sd_m: f64,
    /// Standard deviation of the balance equation g, metres.
    pub balance_sd_m: f64,
    /// Rough size of the object, metres: the standard deviation of the first harmonic, and a tenth of that of the mean radius.
    pub size_m: f64,
    /// Standard deviation of the k-th harmonic, times k², for k from 2, metres.
    pub prior_scale_m: f64,
    /// Gauss-Newton steps at the most. (Steps with the matrix of an earlier one are cheap and do not count.)
    pub most_steps: usize,
    /// The optimum counts as reached when a step lowers the cost by less than this share of it.
    pub tolerance: f64,
}

impl SmoothOptions {
    /// For a support function of so many harmonics (2 to [`MOST_HARMONICS`](super::MOST_HARMONICS)), contact positions of the standard
    /// deviation `sensor_sd_m` and an object of the mean radius `size_m` or so, both in metres and positive. The rest is as
    /// [`reconstruct`](super::reconstruct()) begins with: balance as exact as the contacts, harmonics that fall from half the size as 1/k²,
    /// and up to 100 steps until one lowers the cost by less than a share of 10⁻⁸.
    pub fn new(harmonics: usize, sensor_sd_m: f64, size_m: f64) -> Self {
        Self {
            harmonics,
            sensor_sd_m,
            balance_sd_m: sensor_sd_m,
            size_m,
            prior_scale_m: 0.5 * size_m,
            most_steps: 100,
            tolerance: 1e-8,
        }
    }
}

/// What [`smooth_from`] finds.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Smoothed {
    /// The shape.
    pub shape: SupportFunction,
    /// Orientation at each sample, radians. A rotation common to shape and motion remains open.
    pub psi_rad: Vec<f64>,
    /// The sum of squares at the end: residuals over their standard deviations, prior and convexity included.
    pub cost: f64,
    /// Whether the convexity constraint is active: somewhere the radius of curvature is at the margin that is kept.
    pub held_convex: bool,
    /// How the descent ended. Anything but [`Termination::StepsUsedUp`] is an optimum, to the tolerance or to rounding.
    pub termination: Termination,
    /// Gauss-Newton steps taken, as `most_steps` counts them.
    pub steps: usize,
}

/// Shape and motion that make the log most likely, from a start near them: a shape, and an orientation for each sample (radians).
/// The start must be near enough for Gauss-Newton; [`reconstruct`](super::reconstruct()) needs none.
///
/// ```
/// use palpate::reconstruct::{SmoothOptions, Termination, smooth_from};
/// # use palpate::{shape::NamedShape, plan::{PalmLimits, plan_turn}, simulate::{SimulateOptions, simulate}};
/// # let pebble = NamedShape::Pebble.shape(0.03)?;
/// # let plan = plan_turn(&pebble, &PalmLimits::default(), 40.0)?;
/// # let options = SimulateOptions { start_psi_rad: plan.start_psi_rad, ..SimulateOptions::default() };
/// # let felt = simulate(&pebble, &plan.motion.sample(10.0)?, &options)?;
/// # let (log, shape) = (felt.log, pebble);
/// # let psi_rad: Vec<f64> = felt.truth.motion.iter().map(|pose| pose.psi_rad).collect();
/// let options = SmoothOptions { balance_sd_m: 1e-5, ..SmoothOptions::new(8, 1e-4, 0.03) };
/// let smoothed = smooth_from(&log, &shape, &psi_rad, &options)?;
/// assert_ne!(smoothed.termination, Termination::StepsUsedUp);
/// assert!((smoothed.shape.perimeter_m() - shape.perimeter_m()).abs() < 1e-5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// When the log has a value that no log can have or fewer than [`FEWEST_SAMPLES`](super::FEWEST_SAMPLES) samples with both
/// contacts, when an option is out of its range, when `psi_rad` is not as long as the log, and when no cost can be told at the start.
pub fn smooth_from(
    log: &Log,
    shape: &SupportFunction,
    psi_rad: &[f64],
    options: &SmoothOptions,
) -> Result<Smoothed, ReconstructError> {
    check_samples(log)?;
    check_options(options)?;
    check_start(log, shape, Some(psi_rad))?;
    let measurements = Measurements::new(log, Some(options.sensor_sd_m));
    let noise = Noise { sensor_m: options.sensor_sd_m, balance_m: options.balance_sd_m };
    let prior = Prior::new(options.size_m, options.prior_scale_m);
    let smoother = Smoother::new(&measurements, options.harmonics, noise, prior).strictly_convex();
    let effort = StoppingCriteria { iterations: options.most_steps, tolerance: options.tolerance };
    let descent = smoother.descend(shape.coefficients(), psi_rad.to_vec(), effort);
    let found = descent.estimate;
    if !found.cost.is_finite() {
        return Err(ReconstructError::NotSolvable);
    }
    Ok(Smoothed {
        held_convex: smoother.holds_convex(&found.coefficients),
        shape: SupportFunction::from_coefficients(&found.coefficients),
        psi_rad: found.psi,
        cost: found.cost,
        termination: descent.termination,
        steps: descent.steps,
    })
}

fn check_options(options: &SmoothOptions) -> Result<(), ReconstructError> {
    check_harmonics(options.harmonics)?;
    let lengths = [
        ("the standard deviation of the sensors", options.sensor_sd_m),
        ("the standard deviation of the balance", options.balance_sd_m),
        ("the size", options.size_m),
        ("the scale of the prior", options.prior_scale_m),
    ];
    match lengths.into_iter().find(|(_, value)| !(*value > 0.0 && value.is_finite())) {
        Some((what, value)) => {
            Err(ReconstructError::BadOption(format!("{what} must be a positive number of metres, not {value}")))
        }
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::palms::PalmPair;
    use crate::plan::{PalmLimits, plan_turn};
    use crate::sensor::Touchpad;
    use crate::shape::NamedShape;
    use crate::simulate::{SimulateOptions, Simulation, simulate};

    const OPTIONS: SmoothOptions = SmoothOptions {
        harmonics: 6,
        sensor_sd_m: 1e-4,
        balance_sd_m: 1e-4,
        size_m: 0.03,
        prior_scale_m: 0.015,
        most_steps: 100,
        tolerance: 1e-10,
    };

    /// A pebble turned around, and a start that is off by three percent and 0.02 rad.
    fn setting() -> (Simulation, SupportFunction, Vec<f64>) {
        let pebble = NamedShape::Pebble.shape(0.03).expect("a valid size");
        let plan = plan_turn(&pebble, &PalmLimits::default(), 40.0).expect("a motion without a jump");
        let motion: Vec<(f64, PalmPair)> = plan.motion.sample(10.0).expect("possible");
        let options = SimulateOptions {
            touchpad: Touchpad { noise_sd_m: 1e-4, ..Touchpad::ideal() },
            start_psi_rad: plan.start_psi_rad,
            ..SimulateOptions::default()
        };
        let run = simulate(&pebble, &motion, &options).expect("possible");
        let harmonics = pebble.harmonics_m().iter().map(|[a, b]| [0.97 * a, 1.03 * b]).collect();
        let shape = SupportFunction::new(1.02 * pebble.mean_radius_m(), harmonics);
        let poses = run.truth.motion.iter().enumerate();
        let psi = poses.map(|(i, pose)| pose.psi_rad + 0.02 * (0.37 * i as f64).cos()).collect();
        (run, shape, psi)
    }

    /// The cost as documented, from the public forward model; `None` where the shape is not well convex.
    fn cost(log: &Log, shape: &SupportFunction, psi_rad: &[f64]) -> Option<f64> {
        let contacts: f64 = log
            .samples
            .iter()
            .zip(psi_rad)
            .map(|(sample, &psi)| {
                let palms = &sample.palms;
                let (s1, s2) = palms.contact_positions_m(shape, psi);
                let (theta1, theta2) = palms.contact_angles(psi);
                let g = shape.at(theta1).d * palms.phi12_rad().sin() + shape.at(theta2).d * palms.phi1_rad.sin();
                let off = |predicted: f64, measured: Option<f64>| {
                    measured.map_or(0.0, |measured| ((predicted - measured) / OPTIONS.sensor_sd_m).powi(2))
                };
                off(s1, sample.s1_m) + off(s2, sample.s2_m) + (g / OPTIONS.balance_sd_m).powi(2)
            })
            .sum();
        let harmonics = shape.harmonics_m().iter().enumerate().map(|(index, [a, b])| {
            let k = (index + 1) as f64;
            let sd_m = if index == 0 { OPTIONS.size_m } else { OPTIONS.prior_scale_m / (k * k) };
            (a * a + b * b) / (sd_m * sd_m)
        });
        let prior = (shape.mean_radius_m() / (10.0 * OPTIONS.size_m)).powi(2) + harmonics.sum::<f64>();
        (shape.min_curvature_radius_m() > 0.01 * OPTIONS.size_m).then_some(contacts + prior)
    }

    #[test]
    fn the_cost_is_that_of_the_forward_model_and_is_minimal() {
        let (run, shape, psi) = setting();
        let found = smooth_from(&run.log, &shape, &psi, &OPTIONS).expect("solvable");
        assert!(!found.held_convex);
        assert!(found.termination != Termination::StepsUsedUp && (1..OPTIONS.most_steps).contains(&found.steps));
        let here = cost(&run.log, &found.shape, &found.psi_rad).expect("convex");
        assert!((here / found.cost - 1.0).abs() < 1e-9, "{here} {}", found.cost);
        let coefficients = found.shape.coefficients();
        for index in 0..coefficients.len() {
            for step_m in [1e-6, -1e-6] {
                let mut moved = coefficients.clone();
                moved[index] += step_m;
                let there = cost(&run.log, &SupportFunction::from_coefficients(&moved), &found.psi_rad);
                assert!(there.expect("convex") > here - 1e-6 * here, "coefficient {index}");
            }
        }
        for index in (0..found.psi_rad.len()).step_by(37) {
            for step_rad in [1e-4, -1e-4] {
                let mut moved = found.psi_rad.clone();
                moved[index] += step_rad;
                assert!(cost(&run.log, &found.shape, &moved).expect("convex") > here - 1e-6 * here, "sample {index}");
            }
        }
    }

    #[test]
    fn it_tells_when_it_ran_out_of_steps() {
        let (run, shape, psi) = setting();
        let found = smooth_from(&run.log, &shape, &psi, &SmoothOptions { most_steps: 1, ..OPTIONS }).expect("solvable");
        assert_eq!((found.termination, found.steps), (Termination::StepsUsedUp, 1));
        let again = smooth_from(&run.log, &shape, &psi, &OPTIONS).expect("solvable");
        assert!(again.cost < found.cost);
        assert_eq!(SmoothOptions::new(6, 1e-4, 0.03), SmoothOptions { tolerance: 1e-8, ..OPTIONS });
    }

    #[test]
    fn invalid_starts_and_options_are_refused() {
        let (run, shape, psi) = setting();
        let refused = |options: SmoothOptions, psi: &[f64]| {
            matches!(smooth_from(&run.log, &shape, psi, &options), Err(ReconstructError::BadOption(_)))
        };
        let (orientations, samples) = (psi.len() - 1, psi.len());
        let short = smooth_from(&run.log, &shape, &psi[1..], &OPTIONS);
        assert_eq!(short, Err(ReconstructError::StartOfOtherLength { orientations, samples }));
        assert!(refused(SmoothOptions { harmonics: 1, ..OPTIONS }, &psi));
        assert!(refused(SmoothOptions { sensor_sd_m: 0.0, ..OPTIONS }, &psi));
        assert!(refused(SmoothOptions { prior_scale_m: f64::NAN, ..OPTIONS }, &psi));
    }
}
