//! Model comparison between alternative data associations by their Laplace evidence (MacKay 1992; `docs/theory.md`, section on
//! the decoded motion). The decoding ([`super::decode`]) compares poses for a given shape; here each alternative motion is
//! smoothed to an optimum of its own, with a shape of its own, and the difference of the log evidences decides.

use crate::estimate::association::transitions::near;
use crate::estimate::evidence::jump_prior::{deviance, variance_by};
use crate::estimate::evidence::laplace::laplace_evidence;
use crate::estimate::evidence::motion_prior::{CERTAIN, UNSTABLE_POSE};
use crate::estimate::evidence::variance_components::with_balance_weights;
use crate::estimate::jumps::DetectedJump;
use crate::estimate::measurements::Measurements;
use crate::estimate::model::balance_tolerance::{STABILITY_SLACK, unstable_samples, with_exact_balance};
use crate::estimate::model::evidence::Evidence;
use crate::estimate::model::sensor_memory::samples_per_error_by;
use crate::estimate::motion::LONGEST_STEP;
use crate::estimate::motion::{common_rotation, moved};
use crate::estimate::solver::gauss_newton::{Estimate, Fit, Smoother, StoppingCriteria};
use crate::math::angle::wrapped_to;
use rayon::prelude::*;
use std::ops::Range;

/// An alternative motion.
pub(crate) struct Alternative {
    /// One orientation for each sample.
    pub psi: Vec<f64>,
    /// Samples whose ambiguity it resolves.
    pub samples: Vec<usize>,
    /// By how much its motion prior (jumps, unstable poses) costs more than that of the decoded motion, −2 ln: at least, for decoding knows barriers only
    /// roughly, and its jumps may cost more once it is fitted. `None`: by these alone.
    pub motion_cost: Option<f64>,
    /// Whether the predictive shape prefers it, or statics with what is not known of the shape. The evidence then does not exclude it: from a shape that is
    /// bent to the present motion, the way to the optimum of another is not always found, and that an object has copies of what was felt is
    /// likelier than the prior of shapes believes.
    pub is_predicted: bool,
}

impl Alternative {
    /// By how much its motion costs more, with what its jumps and unstable poses cost more than those of the present motion.
    fn cost(&self, of_motion: f64) -> f64 {
        self.motion_cost.map_or(of_motion, |cost| cost.max(of_motion))
    }
}

/// Optima are compared by the evidence in units of 1, which this resolves.
const STOPPING: StoppingCriteria = StoppingCriteria { iterations: 20, tolerance: 1e-7 };

/// An alternative whose margin is below minus this replaces the motion (−2 ln of the odds): less is within what two runs of the
/// smoother differ by.
const LIKELIER: f64 = 1.0;

/// An alternative that has at least this share of the samples elsewhere, and whose margin is below this, may be more likely once noise and
/// number of harmonics are its own: those of the present motion can be worth as much to it.
const WIDESPREAD: f64 = 0.05;
const NEARLY_AS_LIKELY: f64 = 60.0;

/// What became of alternative motions.
#[derive(Default)]
pub(crate) struct Compared {
    /// The best of them, where it is more likely than the fit.
    pub likelier: Option<Estimate>,
    /// Else the best that deserves a fit of its own, all unknowns included.
    pub nearly_as_likely: Option<Vec<f64>>,
}

/// How ambiguous the pose of each sample is.
pub(crate) struct Ambiguity {
    /// For each sample, how much more the best motion costs that has it at another pose, −2 ln.
    margin: Vec<f64>,
    /// Distance of that pose, radians.
    distance_rad: Vec<f64>,
}

/// The standard deviation of an angle of which nothing is known, that of a uniform distribution over the circle: π/√3 radians.
const UNIFORM_SD_RAD: f64 = 1.813_8;

impl Ambiguity {
    pub fn new(margin: Vec<f64>) -> Self {
        Self { distance_rad: vec![UNIFORM_SD_RAD; margin.len()], margin }
    }

    /// Whether the pose of a sample is open.
    pub fn is_open(&self, sample: usize) -> bool {
        self.margin[sample] < CERTAIN.deviance()
    }

    /// For each sample, the distance of another pose that explains it about as well, radians; 0 where there is none.
    pub fn ambiguity_rad(&self) -> Vec<f64> {
        (0..self.margin.len())
            .map(|sample| if self.is_open(sample) { self.distance_rad[sample] } else { 0.0 })
            .collect()
    }

    /// The decoded motion as an alternative to the fitted one, where they differ; the samples at which they do are ambiguous
    /// until then.
    pub fn unsettled(&mut self, fitted: &[f64], decoded: &[f64], period: f64) -> Option<Alternative> {
        let differ = |sample: &usize| !near(fitted[*sample], decoded[*sample], period);
        let samples: Vec<usize> = (0..fitted.len()).filter(differ).collect();
        self.doubt(&samples);
        (!samples.is_empty()).then(|| Alternative {
            psi: decoded.to_vec(),
            samples,
            motion_cost: Some(0.0),
            is_predicted: false,
        })
    }

    /// Those of a run of samples that are not open: an alternative for them leaves samples that are ambiguous for other reasons as they are.
    pub fn settled(&self, samples: Range<usize>) -> Vec<usize> {
        samples.filter(|&sample| !self.is_open(sample)).collect()
    }

    /// Opens samples until the evidence decides.
    pub fn doubt(&mut self, samples: &[usize]) {
        samples.iter().for_each(|&sample| self.lower(sample..sample + 1, 0.0));
    }

    /// Opens a run of samples of whose pose nothing is known, whatever decided on it before.
    pub fn open(&mut self, samples: Range<usize>) {
        self.distance_rad[samples.clone()].fill(UNIFORM_SD_RAD);
        self.lower(samples, 0.0);
    }

    /// Opens a sample whose pose may be so far away, whatever decided on it before.
    pub fn open_to(&mut self, sample: usize, distance_rad: f64) {
        self.distance_rad[sample] = distance_rad;
        self.lower(sample..sample + 1, 0.0);
    }

    /// Lowers the margins of a run of samples to at most this.
    pub fn lower(&mut self, samples: Range<usize>, margin: f64) {
        self.margin[samples].iter_mut().for_each(|present| *present = present.min(margin));
    }
}

/// Compares alternative motions with that of a fit by their evidence, and replaces the margins of the samples they were proposed
/// for. `jumps` are those of a motion.
pub(crate) fn compare_evidence(
    measurements: &Measurements,
    fit: &Fit,
    alternatives: &[Alternative],
    jumps: &(dyn Fn(&Estimate) -> Vec<DetectedJump> + Sync),
    ambiguity: &mut Ambiguity,
) -> Compared {
    if alternatives.is_empty() {
        return Compared::default();
    }
    let of_fit = Smoother::new(measurements, fit.order, fit.noise, fit.prior).strictly_convex();
    // The evidence, −2 ln of the prior of jumps and poses, and the optimum.
    let weigh = |smoother: &Smoother, estimate: Estimate| {
        let normal = smoother.linearise_without_convexity(&estimate.coefficients, &estimate.psi);
        let evidence = laplace_evidence(smoother, &estimate, &normal)?;
        let factor = smoother.factor(&smoother.held_convex(normal, &estimate.coefficients))?;
        let samples_per_error = samples_per_error_by(measurements, &estimate.coefficients, &estimate.psi);
        let variance_of = variance_by(&factor, samples_per_error);
        let balance_m = smoother.noise.balance_m;
        let of_jumps = deviance(measurements, &estimate, balance_m, &variance_of, &jumps(&estimate));
        // On boundary that nothing else felt the stiffness is hardly known.
        let slack_m = STABILITY_SLACK * estimate.coefficients[0].abs();
        let unstable = unstable_samples(measurements, &estimate.coefficients, &estimate.psi, slack_m, balance_m);
        let of_poses = UNSTABLE_POSE.deviance() * unstable as f64;
        Some((Evidence { samples_per_error, ..evidence }, of_jumps + of_poses, estimate))
    };
    let likelier = |estimate: Estimate| {
        // A loose balance may be the work of the present motion, so that each motion has the more likely of that and an exact one.
        let exact = with_exact_balance(fit.noise).and_then(|noise| {
            let measurements = with_balance_weights(measurements.clone(), &estimate, noise.balance_m);
            let exact = Smoother::new(&measurements, fit.order, noise, fit.prior).strictly_convex();
            let there = exact.run_chord(estimate.coefficients.clone(), estimate.psi.clone(), STOPPING);
            weigh(&exact, there)
        });
        let loose = weigh(&of_fit, estimate);
        [loose, exact].into_iter().flatten().reduce(|a, b| if b.0.log_ratio(&a.0) > 0.0 { b } else { a })
    };
    let Estimate { coefficients, psi, .. } = fit.estimate.clone();
    let here = of_fit.run(coefficients, psi, STOPPING);
    let Some((here_evidence, motion_here, here)) = likelier(here) else { return Compared::default() };
    let period = fit.prior.symmetry.period_rad();
    let weighed: Vec<(Estimate, f64)> = alternatives
        .par_iter()
        .map(|alternative| {
            let there = of_fit.run_chord(here.coefficients.clone(), alternative.psi.clone(), STOPPING);
            let Some((evidence, motion_there, there)) = likelier(there.clone()) else {
                return (there, f64::INFINITY);
            };
            let margin = 2.0 * here_evidence.log_ratio(&evidence) + alternative.cost(motion_there - motion_here);
            (there, if margin.is_nan() { f64::INFINITY } else { margin })
        })
        .collect();
    let open: Vec<usize> = (0..here.psi.len()).filter(|&sample| ambiguity.is_open(sample)).collect();
    let mut is_predicted = vec![false; here.psi.len()];
    let predicted = alternatives.iter().filter(|alternative| alternative.is_predicted);
    predicted.flat_map(|alternative| &alternative.samples).for_each(|&sample| is_predicted[sample] = true);
    for &sample in alternatives.iter().flat_map(|alternative| &alternative.samples) {
        if !is_predicted[sample] {
            (ambiguity.margin[sample], ambiguity.distance_rad[sample]) = (f64::INFINITY, 0.0);
        }
    }
    for (there, margin) in &weighed {
        let turned = common_rotation(&here.psi, &there.psi, period);
        for &sample in &open {
            let distance = wrapped_to(there.psi[sample] + turned - here.psi[sample], period).abs();
            // A motion that returned to the fitted pose is no alternative.
            if distance >= LONGEST_STEP {
                ambiguity.margin[sample] = ambiguity.margin[sample].min(*margin);
                if *margin < CERTAIN.deviance() {
                    ambiguity.distance_rad[sample] = ambiguity.distance_rad[sample].max(distance);
                }
            }
        }
    }
    Compared::of(&here.psi, weighed, period)
}

impl Compared {
    /// Of alternatives with their margins, to the motion `here`.
    fn of(here: &[f64], weighed: Vec<(Estimate, f64)>, period: f64) -> Self {
        let least = |best: (Estimate, f64), other: (Estimate, f64)| if other.1 < best.1 { other } else { best };
        let is_widespread = |there: &Estimate| moved(here, &there.psi, period) as f64 >= WIDESPREAD * here.len() as f64;
        let (likelier, others): (Vec<_>, Vec<_>) = weighed.into_iter().partition(|(_, margin)| *margin < -LIKELIER);
        let likelier = likelier.into_iter().reduce(least).map(|(estimate, _)| estimate);
        let near = others.into_iter().filter(|(there, margin)| *margin < NEARLY_AS_LIKELY && is_widespread(there));
        Self { likelier, nearly_as_likely: near.reduce(least).map(|(estimate, _)| estimate.psi) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::association::simulated::turned_pebble;
    use crate::estimate::model::contact::residuals;

    /// The motion of a fit with some samples turned by `turn`.
    fn elsewhere(fit: &Fit, samples: Range<usize>, turn: f64) -> Vec<f64> {
        let mut psi = fit.estimate.psi.clone();
        psi[samples].iter_mut().for_each(|psi| *psi += turn);
        psi
    }

    #[test]
    fn an_ambiguity_is_resolved_where_the_evidence_rejects_the_alternative() {
        let (measurements, fit) = turned_pebble();
        let count = measurements.len();
        let mut ambiguity = Ambiguity::new(vec![f64::INFINITY; count]);
        ambiguity.lower(50..52, 1.0);
        ambiguity.lower(80..81, 1.0);
        let ambiguity_rad = ambiguity.ambiguity_rad();
        assert!(
            ambiguity_rad[50] > 1.8 && ambiguity_rad[51] > 1.8 && ambiguity_rad[80] > 1.8 && ambiguity_rad[49] == 0.0
        );
        let alternative = Alternative {
            psi: elsewhere(&fit, 50..52, 1.5),
            samples: vec![50, 51],
            motion_cost: Some(20.0),
            is_predicted: false,
        };
        assert!(
            compare_evidence(&measurements, &fit, &[alternative], &|_| Vec::new(), &mut ambiguity).likelier.is_none()
        );
        let ambiguity_rad = ambiguity.ambiguity_rad();
        assert_eq!((ambiguity_rad[50], ambiguity_rad[51]), (0.0, 0.0));
        assert!(ambiguity_rad[80] > 1.8, "no alternative was proposed for it");
    }

    #[test]
    fn an_object_is_not_at_rest_at_a_maximum_of_its_energy() {
        let (mut measurements, fit) = turned_pebble();
        // Nothing but the balance tells these poses, and it holds at a maximum as well.
        measurements.instants[50..52].iter_mut().for_each(|instant| (instant.weight1, instant.weight2) = (0.0, 0.0));
        let other_rest = |sample: usize, is_unstable: bool| {
            let missed_m = |psi: f64| {
                let at = residuals(&measurements.instants[sample], &fit.estimate.coefficients, psi);
                (at.is_unstable(fit.noise.balance_m) == is_unstable).then_some(at.value[2].abs())
            };
            let apart = |turn: f64| fit.estimate.psi[sample] + turn;
            let turns = (500..5783).map(|milliradians| apart(1e-3 * f64::from(milliradians)));
            let rests = turns.filter_map(|psi| Some((missed_m(psi).filter(|missed_m| *missed_m < 1e-4)?, psi)));
            rests.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, psi)| psi)
        };
        let is_open = |is_unstable: bool| {
            let mut psi = fit.estimate.psi.clone();
            (50..52).for_each(|sample| psi[sample] = other_rest(sample, is_unstable).expect("another equilibrium"));
            let alternative = Alternative { psi, samples: vec![50, 51], motion_cost: None, is_predicted: false };
            let mut ambiguity = Ambiguity::new(vec![f64::INFINITY; measurements.len()]);
            ambiguity.lower(50..52, 1.0);
            compare_evidence(&measurements, &fit, &[alternative], &|_| Vec::new(), &mut ambiguity);
            ambiguity.is_open(50)
        };
        assert!(is_open(false) && !is_open(true));
    }

    #[test]
    fn the_evidence_alone_does_not_exclude_what_is_predicted() {
        let (measurements, fit) = turned_pebble();
        let ambiguity_rad = |is_predicted: bool| {
            let mut ambiguity = Ambiguity::new(vec![f64::INFINITY; measurements.len()]);
            ambiguity.lower(50..52, -1.0);
            let (psi, samples) = (elsewhere(&fit, 50..52, 1.5), vec![50, 51]);
            let alternative = Alternative { psi, samples, motion_cost: None, is_predicted };
            compare_evidence(&measurements, &fit, &[alternative], &|_| Vec::new(), &mut ambiguity);
            ambiguity.ambiguity_rad()[50]
        };
        assert!(ambiguity_rad(true) > 1.8 && ambiguity_rad(false) == 0.0);
    }

    #[test]
    fn an_alternative_costs_what_its_jumps_do_where_decoding_thought_them_cheaper() {
        let costs = |motion_cost: Option<f64>, of_jumps: f64| {
            let alternative = Alternative { psi: Vec::new(), samples: Vec::new(), motion_cost, is_predicted: false };
            alternative.cost(of_jumps)
        };
        assert_eq!([costs(Some(5.0), 40.0), costs(Some(5.0), -40.0)], [40.0, 5.0]);
        assert_eq!([costs(None, 40.0), costs(None, -40.0)], [40.0, -40.0]);
    }

    #[test]
    fn a_more_likely_alternative_is_taken_and_its_samples_stay_ambiguous_until_then() {
        let (measurements, right) = turned_pebble();
        let mut wrong = right.clone();
        wrong.estimate.psi = elsewhere(&right, 50..52, 1.5);
        let mut ambiguity = Ambiguity::new(vec![f64::INFINITY; measurements.len()]);
        let alternative = ambiguity
            .unsettled(&wrong.estimate.psi, &right.estimate.psi, std::f64::consts::TAU)
            .expect("two samples differ");
        assert_eq!(alternative.samples, [50, 51]);
        let better = compare_evidence(&measurements, &wrong, &[alternative], &|_| Vec::new(), &mut ambiguity)
            .likelier
            .expect("the right poses are likelier");
        for (found, truth) in better.psi.iter().zip(&right.estimate.psi) {
            assert!((found - truth).abs() < 1e-3, "{found} {truth}");
        }
        let ambiguity_rad = ambiguity.ambiguity_rad();
        assert!(ambiguity_rad[50] > 0.5 && ambiguity_rad[49] == 0.0, "{}", ambiguity_rad[50]);
    }

    #[test]
    fn a_widespread_alternative_that_is_not_much_less_likely_deserves_a_fit_of_its_own() {
        let here = vec![0.0; 100];
        // The first samples a radian away.
        let alternative = |count: usize, margin: f64| {
            let psi = (0..here.len()).map(|sample| if sample < count { 1.0 } else { 0.0 }).collect();
            (Estimate { coefficients: Vec::new(), psi, cost: 0.0 }, margin)
        };
        let of = |weighed: &[(Estimate, f64)]| {
            let compared = Compared::of(&here, weighed.to_vec(), std::f64::consts::TAU);
            let elsewhere = |psi: &Vec<f64>| psi.iter().filter(|psi| **psi > 0.5).count();
            (compared.likelier.map(|it| elsewhere(&it.psi)), compared.nearly_as_likely.as_ref().map(elsewhere))
        };
        assert_eq!(of(&[alternative(5, NEARLY_AS_LIKELY - 0.1)]), (None, Some(5)));
        assert_eq!(of(&[alternative(4, NEARLY_AS_LIKELY - 0.1)]), (None, None), "too few samples");
        assert_eq!(of(&[alternative(5, NEARLY_AS_LIKELY + 0.1)]), (None, None), "too unlikely");
        let likelier = [alternative(5, 3.0), alternative(6, 2.0), alternative(7, -1.1), alternative(8, -2.0)];
        assert_eq!(of(&likelier), (Some(8), Some(6)));
        assert_eq!(of(&[alternative(9, -0.9)]), (None, Some(9)));
    }
}
