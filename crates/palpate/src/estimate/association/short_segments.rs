//! Data association of short segments, those of a few samples between two jumps. A fit adapts the shape to them, so that they
//! always seem well placed; they are tested against the predictive shape that all other samples leave ([`super::predictive`]),
//! and then by the evidence ([`super::alternatives`]). Where both disagree, the pose is open.

use crate::estimate::association::alternatives::{Alternative, Ambiguity};
use crate::estimate::association::candidates::minima;
use crate::estimate::association::predictive::PredictiveShape;
use crate::estimate::association::transitions::near;
use crate::estimate::evidence::motion_prior::CERTAIN;
use crate::estimate::evidence::variance_components::balance_weight;
use crate::estimate::measurements::{Instant, Measurements};
use crate::estimate::model::contact::residuals;
use crate::estimate::motion::{SHORT_SEGMENT, segments_between, short_segments};
use crate::estimate::solver::gauss_newton::Fit;
use crate::math::angle::wrapped_to;
use rayon::prelude::*;

/// Samples in short segments beyond which all of them count as ambiguous: with so many set aside, the rest no longer predicts the
/// shape.
const MOST_SAMPLES: usize = 60;

/// A sample is out of balance that misses it by so many standard deviations. By Student's t one of 500 does; a whole piece does where it is not at rest,
/// or not where it was put.
const OUT_OF_BALANCE_SDS: f64 = 10.0;

/// Looks for other orientations of each short segment, given the predictive shape of all samples outside short segments. Lowers
/// the margins in `ambiguity` to that of the segment's most informative sample, the one with the largest margin, and returns the
/// most likely alternative motions.
pub(crate) fn reassociated(
    measurements: &Measurements,
    fit: &Fit,
    starts: &[usize],
    ambiguity: &mut Ambiguity,
) -> Vec<Alternative> {
    let short = short_segments(starts, measurements.len());
    let samples: usize = short.iter().map(|segment| segment.len()).sum();
    if samples == 0 {
        return Vec::new();
    }
    let mut others = measurements.clone();
    short.iter().cloned().flatten().for_each(|index| others.instants[index].set_aside());
    let Some(predictive) =
        (samples <= MOST_SAMPLES).then(|| PredictiveShape::from(&others, &fit.at_optimum_of(&others))).flatten()
    else {
        short.into_iter().for_each(|segment| ambiguity.lower(segment, 0.0));
        return Vec::new();
    };
    let period = fit.prior.symmetry.period_rad();
    let mut alternatives = Vec::new();
    for segment in short {
        let here = &fit.estimate.psi;
        let samples = segment.clone().into_par_iter();
        let elsewhere: Vec<(f64, Vec<f64>)> =
            samples.map(|index| predictive.elsewhere(&measurements.instants[index], here[index], period)).collect();
        let Some((margin, others)) = elsewhere.iter().max_by(|a, b| a.0.total_cmp(&b.0)) else { continue };
        if *margin >= CERTAIN.deviance() {
            continue;
        }
        ambiguity.lower(segment.clone(), *margin);
        for other in others {
            let mut psi = here.clone();
            for (index, (_, minima)) in segment.clone().zip(&elsewhere) {
                let distance = |psi: &f64| wrapped_to(psi - other, period).abs();
                let nearest = minima.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)));
                psi[index] = nearest.copied().filter(|psi| near(*psi, *other, period)).unwrap_or(*other);
            }
            let samples = segment.clone().collect();
            alternatives.push(Alternative { psi, samples, motion_cost: None, is_predicted: *margin < 0.0 });
        }
    }
    alternatives
}

/// Opens the poses of pieces that are out of balance in every sample: an object is not at rest there, and contacts alone do not tell the pose of a piece
/// that lies on boundary of its own. So it is with a sample beside a jump whose contacts are read as well where another orientation puts them. The weights of
/// `measurements` are those of the balance at the fit.
pub(crate) fn open_out_of_balance(measurements: &Measurements, fit: &Fit, starts: &[usize], ambiguity: &mut Ambiguity) {
    for segment in segments_between(starts, measurements.len()) {
        if segment.len() >= SHORT_SEGMENT && measurements.instants[segment.clone()].iter().all(is_out_of_balance) {
            ambiguity.open(segment);
        }
    }
    let mut beside: Vec<usize> = starts.iter().flat_map(|&start| [start.saturating_sub(1), start]).collect();
    beside.dedup();
    for sample in beside.into_iter().filter(|&sample| is_out_of_balance(&measurements.instants[sample])) {
        if let Some(away_rad) = read_as_well_elsewhere(&measurements.instants[sample], fit, fit.estimate.psi[sample]) {
            ambiguity.open_to(sample, away_rad);
        }
    }
}

/// Whether an instant with the weight that its balance has at a fit misses that by far.
pub(crate) fn is_out_of_balance(instant: &Instant) -> bool {
    instant.balance_weight > 0.0 && instant.balance_weight < balance_weight(OUT_OF_BALANCE_SDS)
}

/// The distance of the furthest other orientation at which the contacts of a sample are read about as well, radians.
fn read_as_well_elsewhere(instant: &Instant, fit: &Fit, here: f64) -> Option<f64> {
    let (coefficients, period) = (&fit.estimate.coefficients, fit.prior.symmetry.period_rad());
    let misfit = |psi: f64| {
        let value = residuals(instant, coefficients, psi).value;
        ((instant.weight1 * value[0]).powi(2) + (instant.weight2 * value[1]).powi(2)) / fit.noise.sensor_m.powi(2)
    };
    let most = misfit(here) + CERTAIN.deviance();
    let others = minima(here, period, &misfit).into_iter().filter(|(_, misfit)| *misfit < most);
    let away = others.filter(|(psi, _)| !near(*psi, here, period)).map(|(psi, _)| wrapped_to(psi - here, period).abs());
    away.max_by(f64::total_cmp)
}

#[cfg(test)]
mod tests;
