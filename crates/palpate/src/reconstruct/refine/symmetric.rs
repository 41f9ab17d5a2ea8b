//! Symmetric models of the object in place of the general one, where the evidence prefers them (`docs/theory.md`, symmetry).

use crate::estimate::coverage::{NODES, contact_paths, overlap, touches};
use crate::estimate::evidence::symmetry::{against_general, log_prior_odds, symmetric_models};
use crate::estimate::measurements::Measurements;
use crate::estimate::model::prior::Prior;
use crate::estimate::motion::{outlying_steps, same_motion, unwrap_to};
use crate::estimate::solver::gauss_newton::{Estimate, Fit};
use crate::reconstruct::options::error::ReconstructError;
use crate::reconstruct::refine::job::{Job, Refined};
use crate::reconstruct::refine::resample::carry_over;
use crate::reconstruct::result::reconstruction::FoundSymmetry;
use crate::shape::Symmetry;
use std::f64::consts::TAU;
use std::ops::Range;

/// Symmetric models that are fitted at most, the most likely first: each costs as much as the general one.
const MOST_MODELS: usize = 3;

/// A symmetric model is fitted where the posterior of the general one does not exclude it by more than this, in nats: a generous
/// limit, since a piece at a wrong pose spoils that posterior, and the fit decides.
const NOT_EXCLUDED: f64 = 200.0;

/// Where one model holds, those further behind the likeliest than this are not fitted, in nats.
const FAR_BEHIND: f64 = 20.0;

/// Least share of the felt boundary that must have been felt on two copies: with less, they are not compared, and a symmetric model
/// extrapolates. The pieces of a symmetric object can lie on one copy, where they share a boundary, as well as on several.
const OVERLAP: f64 = 0.2;

/// The probability behind log odds.
fn probability(log_odds: f64) -> f64 {
    1.0 / (1.0 + (-log_odds).exp())
}

impl Job<'_> {
    /// The most likely of the general optimum and of those with a symmetry.
    pub(super) fn with_symmetry(
        &self,
        medium: &Measurements,
        ranges: &[Range<usize>],
        mut general: Refined,
    ) -> Refined {
        let mut models = symmetric_models(&general.measurements, &general.fine);
        models.retain(|model| model.log_ratio > -NOT_EXCLUDED);
        // ln of the evidence of each model that was fitted, times its prior odds against the general one.
        let mut weights: Vec<f64> = Vec::new();
        let mut best: Option<(f64, Refined)> = None;
        let likeliest = models.first().map_or(0.0, |model| model.log_ratio);
        for model in models.into_iter().take(MOST_MODELS) {
            if best.is_some() && model.log_ratio < likeliest - FAR_BEHIND {
                break;
            }
            let prior = Prior { symmetry: model.symmetry, ..general.fine.prior };
            let mut psi: Vec<f64> = general.fine.estimate.psi.iter().map(|psi| psi - model.turn).collect();
            unwrap_to(&mut psi, model.symmetry.period_rad());
            let on_medium = carry_over(&self.measurements, &psi, &model.coefficients, medium, ranges);
            let estimate = Estimate { coefficients: model.coefficients, psi: on_medium, cost: f64::INFINITY };
            let rough = Fit { estimate, prior, ..general.coarse.clone() };
            let Ok(mut refined) = self.to_fixed_point(medium, ranges, rough, Some(psi)) else { continue };
            refined.fine.estimate.psi = self.motion(&refined.fine);
            let is_same = |general: &Refined| same_motion(&general.fine.estimate.psi, &refined.fine.estimate.psi, TAU);
            // The pieces of an object that is not symmetric may lie as the symmetric model has them.
            if !is_same(&general) && self.unphysical_jumps(&general.fine.estimate, TAU) > 0 {
                general = general.or_likelier(self.without_symmetry(medium, ranges, &refined));
            }
            let against_general = against_general(&refined.measurements, &refined.fine);
            let Some(held) = against_general.filter(|held| !held.model.is_contradicted()) else { continue };
            let weight = refined.fine.log_evidence + log_prior_odds();
            let radius_m = refined.fine.estimate.coefficients[0].abs();
            let compared = self.overlap(&refined.fine) >= OVERLAP;
            let deviation_sd_m = if compared { held.deviation_sd_m } else { radius_m };
            if !compared && self.unphysical_jumps(&refined.fine.estimate, TAU) > 0 {
                continue;
            }
            let limits = &self.options.limits;
            let is_guess = deviation_sd_m > limits.symmetry_deviation * radius_m
                || probability(weight - general.fine.log_evidence) < limits.symmetry_probability;
            // So may those of one that is not known to be.
            if is_guess && !is_same(&general) {
                general = general.or_likelier(self.without_symmetry(medium, ranges, &refined));
            }
            // A symmetry that would be a doubt is of no use where the general model has the same motion. Else the two are rivals.
            if is_guess && is_same(&general) {
                continue;
            }
            refined.symmetry =
                FoundSymmetry { symmetry: model.symmetry, probability: None, deviation_sd_m: Some(deviation_sd_m) };
            weights.push(weight);
            if best.as_ref().is_none_or(|(least, _)| weight > *least) {
                // The search compares arrangements by the general model.
                best = Some((weight, Refined { coarse: general.coarse.clone(), ..refined }));
            }
        }
        // ln of the posterior odds against the general model.
        let odds_of = |weight: f64| weight - general.fine.log_evidence;
        let log_odds: Vec<f64> = weights.into_iter().map(odds_of).collect();
        let best = best.map(|(weight, refined)| (odds_of(weight), refined));
        let largest = log_odds.iter().copied().fold(0.0, f64::max);
        let sum = (-largest).exp() + log_odds.iter().map(|odds| (odds - largest).exp()).sum::<f64>();
        let (odds, mut likeliest) = best.filter(|(odds, _)| *odds > 0.0).unwrap_or((0.0, general));
        likeliest.symmetry.probability = Some((odds - largest).exp() / sum);
        likeliest
    }

    /// The general optimum next to a symmetric one.
    fn without_symmetry(
        &self,
        medium: &Measurements,
        ranges: &[Range<usize>],
        symmetric: &Refined,
    ) -> Result<Refined, ReconstructError> {
        let Fit { estimate: Estimate { coefficients, psi, .. }, prior, .. } = &symmetric.fine;
        let on_medium = carry_over(&self.measurements, psi, coefficients, medium, ranges);
        let estimate = Estimate { coefficients: coefficients.clone(), psi: on_medium, cost: f64::INFINITY };
        let rough = Fit { estimate, prior: Prior { symmetry: Symmetry::NONE, ..*prior }, ..symmetric.coarse.clone() };
        self.to_fixed_point(medium, ranges, rough, Some(psi.clone()))
    }

    /// Share of the felt boundary that was felt on two copies.
    fn overlap(&self, fine: &Fit) -> f64 {
        let symmetry: Symmetry = fine.prior.symmetry;
        let psi = &fine.estimate.psi;
        let angles: Vec<(f64, f64)> =
            self.measurements.instants.iter().zip(psi).map(|(instant, psi)| instant.contact_angles(*psi)).collect();
        let counts = touches(&contact_paths(&self.measurements, &angles, &outlying_steps(psi)));
        debug_assert_eq!(counts.len(), NODES);
        overlap(&counts, symmetry, 0.0)
    }
}
