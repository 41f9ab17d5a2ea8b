//! Rival motions beside a jump that statics does not predict. Where an object is nearly symmetric, the samples after a jump may all have been
//! given poses a copy away from the true ones: the contacts fit nearly as well, and the jump itself is impossible, or there was none, since
//! the contacts did not move. Or the object landed on boundary that was not felt before, a copy of what was: over a barrier that errors of the
//! shape may have made, it seems to land on that instead. Here the samples after such a jump, up to the next one of that kind or the end of the log, are turned
//! together, so that the object lands where its potential energy lets it or stays (`docs/theory.md`, decoding of the motion). Each such
//! motion becomes an alternative, which the evidence decides ([`super::alternatives`]).

use crate::estimate::association::alternatives::{Alternative, Ambiguity};
use crate::estimate::coverage::{NODES, felt_nodes};
use crate::estimate::evidence::jump_prior::{is_over_barrier, variance_by};
use crate::estimate::jumps::{BARRIER_ALLOWANCE, DetectedJump};
use crate::estimate::measurements::Measurements;
use crate::estimate::solver::gauss_newton::{Fit, Smoother};
use crate::math::angle::wrapped;
use crate::mechanics::EnergyLandscape;
use crate::mechanics::passage::{SAME_POSE_RAD, barrier_m, is_same_pose};
use crate::palms::PalmPair;
use crate::shape::SupportFunction;
use std::f64::consts::TAU;
use std::ops::Range;

/// Jumps that are looked at: a motion with more that are not predicted is wrong in other ways.
const MOST_DOUBTFUL: usize = 4;

/// Landings of a jump that are tried, those over the lowest barriers.
const LANDINGS: usize = 2;

/// Steps that take each orientation to the minimum of its own sample after it was turned: the landing is good to a few degrees.
const PROJECTIONS: usize = 6;

/// Two poses are copies where the contacts differ by less than this between them, as a share of the mean radius: the jumps of objects that
/// are not symmetric move them by several per cent.
const COPY: f64 = 0.01;

/// The motions with the samples after a doubtful jump turned to where it may land. Their samples count as ambiguous until the evidence
/// decides.
pub(crate) fn landings(
    measurements: &Measurements,
    palms: &[PalmPair],
    fit: &Fit,
    jumps: &[DetectedJump],
    ambiguity: &mut Ambiguity,
) -> Vec<Alternative> {
    let shape = SupportFunction::from_coefficients(&fit.estimate.coefficients);
    let mut felt = vec![false; NODES];
    felt_nodes(measurements, &fit.estimate.psi).for_each(|node| felt[node] = true);
    let smoother = Smoother::new(measurements, fit.order, fit.noise, fit.prior);
    let information = smoother.factor(&smoother.linearise(&fit.estimate.coefficients, &fit.estimate.psi));
    let is_over_barrier = |jump: &DetectedJump| {
        information.as_ref().is_some_and(|information| {
            let variance_of = variance_by(information, fit.evidence.samples_per_error);
            is_over_barrier(measurements, &fit.estimate, fit.noise.balance_m, &variance_of, jump)
        })
    };
    let doubtful: Vec<(&DetectedJump, Vec<Landing>)> = jumps
        .iter()
        .filter(|jump| !jump.predicted)
        .map(|jump| (jump, allowed(&shape, &felt, &palms[jump.sample], jump, is_over_barrier(jump))))
        .filter(|(jump, landings)| !jump.physical || !landings.is_empty())
        .collect();
    if doubtful.len() > MOST_DOUBTFUL {
        return Vec::new();
    }
    let count = measurements.len();
    let mut alternatives = Vec::new();
    for (number, (jump, allowed)) in doubtful.iter().enumerate() {
        let next = doubtful.get(number + 1).map(|(next, _)| next.sample);
        let turned: Vec<Range<usize>> = next.into_iter().chain([count]).map(|end| jump.sample..end).collect();
        for landing in allowed.iter().take(LANDINGS) {
            for samples in &turned {
                let mut psi = fit.estimate.psi.clone();
                psi[samples.clone()].iter_mut().for_each(|psi| *psi += landing.psi_rad - jump.psi_after);
                let _ = smoother.project_orientations(&fit.estimate.coefficients, &mut psi, PROJECTIONS);
                let samples = ambiguity.settled(samples.clone());
                let is_predicted = landing.is_unfelt_and_easier;
                alternatives.push(Alternative { psi, samples, motion_cost: None, is_predicted });
            }
        }
    }
    alternatives.iter().for_each(|alternative| ambiguity.doubt(&alternative.samples));
    alternatives
}

/// A pose at which a jump may end.
struct Landing {
    psi_rad: f64,
    /// Of the highest place on the way there, metres.
    barrier_m: f64,
    /// Whether there is a barrier before the pose it was given and a lower one before this, and boundary that was not felt is what contradicts that:
    /// what the contacts would be there is a guess.
    is_unfelt_and_easier: bool,
}

/// Other poses than that after a jump which the object reaches without a barrier, or keeps, the lowest barrier first. Where statics allows the
/// jump, copies of that pose only, and poses on boundary that was not felt, which may be copies of it, where the jump is over a barrier.
fn allowed(
    shape: &SupportFunction,
    felt: &[bool],
    palms: &PalmPair,
    jump: &DetectedJump,
    is_over_barrier: bool,
) -> Vec<Landing> {
    let landscape = EnergyLandscape::new(shape, palms);
    let allowance_m = BARRIER_ALLOWANCE * shape.mean_radius_m();
    let barrier_to = |psi_rad: f64| barrier_m(|psi| landscape.height_m(psi), jump.psi_before, psi_rad);
    let taken_m = barrier_to(jump.psi_after);
    let mut reached: Vec<Landing> = Vec::new();
    for rest in landscape.stable_poses() {
        let psi_rad = jump.psi_before + wrapped(rest.psi_rad - jump.psi_before);
        let barrier_m = barrier_to(psi_rad);
        if is_same_pose(psi_rad, jump.psi_after) || barrier_m > allowance_m {
            continue;
        }
        let is_unfelt_and_easier = is_over_barrier && barrier_m < taken_m && is_unfelt(felt, palms, psi_rad);
        if !jump.physical || is_unfelt_and_easier || are_copies(shape, palms, psi_rad, jump.psi_after) {
            reached.push(Landing { psi_rad, barrier_m, is_unfelt_and_easier });
        }
    }
    reached.sort_by(|a, b| a.barrier_m.total_cmp(&b.barrier_m));
    reached
}

/// Whether a contact is on boundary that was not felt, nor any close to it: what was felt tells where the boundary beside it is.
fn is_unfelt(felt: &[bool], palms: &PalmPair, psi: f64) -> bool {
    let node = |theta: f64| (theta.rem_euclid(TAU) / TAU * felt.len() as f64).round() as usize % felt.len();
    let beside = (SAME_POSE_RAD / TAU * felt.len() as f64) as usize;
    let is_unfelt =
        |theta: f64| (0..=2 * beside).all(|step| !felt[(node(theta) + felt.len() + step - beside) % felt.len()]);
    let (theta1, theta2) = palms.contact_angles(psi);
    is_unfelt(theta1) || is_unfelt(theta2)
}

/// Whether the contacts are at the same places in two poses.
fn are_copies(shape: &SupportFunction, palms: &PalmPair, one: f64, other: f64) -> bool {
    let (s, t) = (palms.contact_positions_m(shape, one), palms.contact_positions_m(shape, other));
    (s.0 - t.0).abs().max((s.1 - t.1).abs()) < COPY * shape.mean_radius_m()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::jumps::detect_jumps;
    use crate::estimate::model::evidence::Evidence;
    use crate::estimate::model::noise::Noise;
    use crate::estimate::model::prior::Prior;
    use crate::estimate::motion::{same_motion, unwrap};
    use crate::estimate::solver::gauss_newton::{Estimate, StoppingCriteria};
    use crate::palms::PalmMotion;
    use crate::sensor::Touchpad;
    use crate::shape::ellipse;
    use crate::simulate::{SimulateOptions, simulate};
    use std::f64::consts::PI;

    const NOISE: Noise = Noise { sensor_m: 5e-5, balance_m: 1e-5 };

    fn fitted(measurements: &Measurements, coefficients: Vec<f64>, psi: Vec<f64>) -> Fit {
        let (order, prior) = (coefficients.len() / 2, Prior::new(0.03, 0.015));
        let stopping = StoppingCriteria { iterations: 30, tolerance: 1e-7 };
        let mut estimate: Estimate = Smoother::new(measurements, order, NOISE, prior).run(coefficients, psi, stopping);
        unwrap(&mut estimate.psi);
        Fit { estimate, order, noise: NOISE, prior, evidence: Evidence::NONE }
    }

    #[test]
    fn samples_half_a_turn_away_after_a_jump_are_brought_back() {
        // An ellipse but for the third harmonic.
        let mut coefficients = ellipse(0.03, 0.025).expect("possible").coefficients();
        let order = coefficients.len() / 2;
        coefficients[3] += 5e-5;
        coefficients[order + 1] += 3e-5;
        let shape = SupportFunction::from_coefficients(&coefficients);
        let (mut forbidden, mut brought_back) = (0, 0);
        for seed in 0..20 {
            let motion = PalmMotion::random(seed, 20.0, 1.0).and_then(|motion| motion.sample(20.0)).expect("possible");
            let touchpad = Touchpad { noise_sd_m: NOISE.sensor_m, ..Touchpad::ideal() };
            let options = SimulateOptions { touchpad, seed, ..SimulateOptions::default() };
            let Ok(run) = simulate(&shape, &motion, &options) else { continue };
            let palms = run.log.palms();
            let measurements = Measurements::new(&run.log, None);
            let truth: Vec<f64> = run.truth.motion.iter().map(|pose| pose.psi_rad).collect();
            let Some(first) = run.jumps.first() else { continue };
            let after = run.log.samples.partition_point(|sample| sample.time_s < first.time_s);
            let mut flipped = truth.clone();
            flipped[after..].iter_mut().for_each(|psi| *psi += PI);
            let fit = fitted(&measurements, coefficients.clone(), flipped);
            let jumps = detect_jumps(
                &SupportFunction::from_coefficients(&fit.estimate.coefficients),
                &run.log,
                &fit.estimate.psi,
            );
            if jumps.iter().all(|jump| jump.physical) {
                continue;
            }
            forbidden += 1;
            let mut ambiguity = Ambiguity::new(vec![f64::INFINITY; truth.len()]);
            let found = landings(&measurements, &palms, &fit, &jumps, &mut ambiguity);
            assert!(found.iter().flat_map(|other| &other.samples).all(|&sample| ambiguity.is_open(sample)));
            let is_true = |other: &Alternative| {
                let there = fitted(&measurements, fit.estimate.coefficients.clone(), other.psi.clone());
                same_motion(&there.estimate.psi, &truth, TAU)
            };
            brought_back += usize::from(found.iter().any(is_true));
        }
        assert!(forbidden >= 3 && brought_back * 10 >= forbidden * 8, "{brought_back} of {forbidden}");
    }

    #[test]
    fn a_few_forbidden_jumps_are_looked_at_and_no_others() {
        let motion = PalmMotion::random(1, 10.0, 0.5).and_then(|motion| motion.sample(20.0)).expect("possible");
        let shape = ellipse(0.03, 0.025).expect("possible");
        let run = simulate(&shape, &motion, &SimulateOptions::default()).expect("possible");
        let palms = run.log.palms();
        let measurements = Measurements::new(&run.log, None);
        let truth: Vec<f64> = run.truth.motion.iter().map(|pose| pose.psi_rad).collect();
        let fit = fitted(&measurements, shape.coefficients(), truth);
        // As if the samples from each on were half a turn away.
        let jumps = |count: usize, physical: bool| -> Vec<DetectedJump> {
            let jump = |number: usize| {
                let (sample, psi_before) = (20 + number, fit.estimate.psi[19 + number]);
                let psi_after = psi_before + PI;
                let (height_before_m, height_after_m) = (0.0, 0.0);
                DetectedJump {
                    sample,
                    psi_before,
                    psi_after,
                    height_before_m,
                    height_after_m,
                    physical,
                    predicted: false,
                }
            };
            (0..count).map(jump).collect()
        };
        let found = |jumps: &[DetectedJump]| {
            let mut ambiguity = Ambiguity::new(vec![f64::INFINITY; palms.len()]);
            let found = landings(&measurements, &palms, &fit, jumps, &mut ambiguity);
            (!found.is_empty(), ambiguity.is_open(palms.len() - 1), ambiguity.is_open(0))
        };
        assert_eq!(found(&jumps(1, false)), (true, true, false));
        assert_eq!(found(&jumps(MOST_DOUBTFUL, false)), (true, true, false));
        assert_eq!(found(&jumps(MOST_DOUBTFUL + 1, false)), (false, false, false));
        assert_eq!(found(&jumps(1, true)), (false, false, false));
    }

    #[test]
    fn what_falls_more_easily_onto_boundary_that_was_not_felt_may_have() {
        let shape = ellipse(0.03, 0.029).expect("possible");
        let palms = PalmPair::hinged(0.6, 1.7);
        let landscape = EnergyLandscape::new(&shape, &palms);
        let poses = landscape.stable_poses();
        let [left, right] = [0, 1].map(|pose| poses[pose].psi_rad);
        let highest = |a: &f64, b: &f64| landscape.height_m(*a).total_cmp(&landscape.height_m(*b));
        let between = (1..1000).map(|step| left + (right - left) * f64::from(step) / 1000.0);
        let top = between.max_by(highest).expect("a top");
        let allowed = |psi_before: f64, unfelt_beside: i32, is_over_barrier: bool| {
            let jump = DetectedJump {
                sample: 0,
                psi_before,
                psi_after: right,
                height_before_m: landscape.height_m(psi_before),
                height_after_m: landscape.height_m(right),
                physical: true,
                predicted: false,
            };
            // The ellipse itself has its copy half a turn away, where all was felt.
            let mut felt = vec![true; NODES];
            let (theta1, _) = palms.contact_angles(left);
            for step in -unfelt_beside..=unfelt_beside {
                let theta = theta1 + f64::from(step) * TAU / NODES as f64;
                felt[(theta.rem_euclid(TAU) / TAU * NODES as f64).round() as usize % NODES] = false;
            }
            let found = super::allowed(&shape, &felt, &palms, &jump, is_over_barrier);
            found.iter().any(|landing| landing.is_unfelt_and_easier)
        };
        // From a little to the left of the top, and to the right.
        let beside = (SAME_POSE_RAD / TAU * NODES as f64) as i32;
        assert!(allowed(top - 0.05, beside, true) && !allowed(top - 0.05, beside, false));
        assert!(!allowed(top + 0.05, beside, true));
        // Beside boundary that was felt.
        assert!(!allowed(top - 0.05, beside - 1, true));
    }
}
