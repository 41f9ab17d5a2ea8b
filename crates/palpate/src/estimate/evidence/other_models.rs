//! Other models of a log than that of its answer, with their probabilities (J. A. Hoeting et al., *Bayesian model averaging: a tutorial*, Statistical
//! Science 14, 1999): other numbers of harmonics, and other scales of the prior. Where most of the boundary was felt only once, they have
//! optima with about the same evidence and other motions, and what one of them leaves open is less than what is unknown.

use crate::estimate::evidence::order::orders;
use crate::estimate::evidence::profile::{Center, Profile};
use crate::estimate::measurements::Measurements;
use crate::estimate::model::prior::Prior;
use crate::estimate::solver::gauss_newton::{Estimate, Fit, Smoother, StoppingCriteria};
use rayon::prelude::*;

/// Numbers of harmonics that are tried on each side of that of the answer: the evidence is flat over one or two.
const NUMBERS: usize = 2;

/// Scales of the prior that are tried, as multiples of that of the answer: of the few harmonics that a short log determines, it is known to a
/// factor of two.
const SCALES: [f64; 4] = [0.5, 1.0, 2.0, 4.0];

/// Effort of the smoother for each.
const STOPPING: StoppingCriteria = StoppingCriteria { iterations: 60, tolerance: 1e-7 };

/// Least probability that counts: with less, a model a whole turn away adds less than a degree.
const LEAST_WEIGHT: f64 = 1e-5;

/// Nats below the likeliest model from which on a model, or a place along its profile, has none of that: the weight above, and what a place gains by the
/// width that it stands for.
const NEGLIGIBLE: f64 = 14.0;

/// Nats by which the evidence may rise along the profile of the answer where it falls on the whole. Where it rises by more, that of a model says little about
/// that of the places along its profile, and all are looked at.
const RISE: f64 = 1.0;

/// What else explains a log.
pub(crate) struct OtherModels {
    /// Optima with their probabilities; what is missing to one is that of the answer.
    pub fits: Vec<(f64, Fit)>,
    /// What the error bars of the answer know of its own profile already: see [`Profile::linear`].
    pub linear: Estimate,
}

/// The optima of the other models, from that of the answer and with its noise, and all along their profiles. `None` where that of the answer
/// cannot be determined.
pub(crate) fn other_models(measurements: &Measurements, answer: &Fit) -> Option<OtherModels> {
    let orders = orders(answer.prior.symmetry.order);
    let here = orders.iter().position(|&order| order >= answer.order).unwrap_or(orders.len());
    let numbers = &orders[here.saturating_sub(NUMBERS)..(here + NUMBERS + 1).min(orders.len())];
    let models: Vec<(usize, f64)> = numbers
        .iter()
        .flat_map(|order| SCALES.map(|scale| (*order, scale * answer.prior.scale_m)))
        .filter(|model| *model != (answer.order, answer.prior.scale_m))
        .collect();
    let at = |(order, scale_m): (usize, f64)| {
        let prior = Prior { scale_m, ..answer.prior };
        let smoother = Smoother::new(measurements, order, answer.noise, prior).strictly_convex();
        let Estimate { coefficients, psi, .. } = answer.estimate.clone();
        let estimate = smoother.run(coefficients, psi, STOPPING);
        estimate
            .cost
            .is_finite()
            .then(|| Center::new(measurements, Fit { estimate, order, prior, ..answer.clone() }))?
    };
    let center = Center::new(measurements, answer.clone())?;
    let others: Vec<Center> = models.into_par_iter().filter_map(at).collect();
    let likeliest_log = others.iter().map(Center::log_evidence).fold(center.log_evidence(), f64::max);
    let Profile { places, linear } = center.profile(f64::NEG_INFINITY);
    let rises = places.iter().any(|(_, place)| place.evidence.log() > center.log_evidence() + RISE);
    let least_log = if rises { f64::NEG_INFINITY } else { likeliest_log - NEGLIGIBLE };
    let others: Vec<Profile> = others
        .into_par_iter()
        .filter(|other| other.log_evidence() > least_log)
        .map(|other| other.profile(least_log))
        .collect();
    let all = || places.iter().chain(others.iter().flat_map(|profile| &profile.places));
    let most = all().map(|(log, _)| *log).fold(f64::NEG_INFINITY, f64::max);
    let sum: f64 = all().map(|(log, _)| (log - most).exp()).sum();
    // The first place is the answer itself.
    let weighted = all().skip(1).map(|(log, fit)| ((log - most).exp() / sum, fit.clone()));
    Some(OtherModels { fits: weighted.filter(|(weight, _)| *weight > LEAST_WEIGHT).collect(), linear })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::evidence::tests::{optimum, turned};

    /// Variance of the motion over the mixture, over what the curvature at the answer says along its profile.
    fn wider_by(answer: &Fit, OtherModels { fits, linear }: &OtherModels) -> f64 {
        let mean: f64 = fits.iter().map(|(weight, fit)| weight * turned(&answer.estimate, &fit.estimate)).sum();
        mean / turned(&answer.estimate, linear)
    }

    #[test]
    fn a_second_has_other_numbers_of_harmonics_and_other_scales() {
        let (measurements, answer) = optimum(5_973_073, 100, 1);
        let others = other_models(&measurements, &answer).expect("determined");
        let probability = |is_of: &dyn Fn(&Fit) -> bool| -> f64 {
            others.fits.iter().filter(|(_, fit)| is_of(fit)).map(|(weight, _)| weight).sum()
        };
        let all = probability(&|_| true);
        assert!(all > 0.5 && all < 1.0, "{all}");
        assert!(others.fits.iter().all(|(weight, fit)| *weight > LEAST_WEIGHT && fit.noise == answer.noise));
        assert!(probability(&|fit| fit.order != answer.order) > 0.1);
        assert!(probability(&|fit| fit.prior.scale_m != answer.prior.scale_m) > 0.1);
        let wider = wider_by(&answer, &others);
        assert!(wider > 4.0, "{wider}");
    }

    #[test]
    fn those_of_a_long_log_say_the_same() {
        let (measurements, answer) = optimum(5, 600, 10);
        let wider = wider_by(&answer, &other_models(&measurements, &answer).expect("determined"));
        assert!((0.5..2.0).contains(&wider), "{wider}");
    }
}
