//! From an optimum to the reported result: gauge (ψ = 0 at the first sample), outline, motion, error bars, χ² and verdict
//! (`docs/theory.md`, error bars).

use super::bent_poses::bent_poses;
use super::certificate::Findings;
use super::open_poses::open_motion_rad;
use super::uncertainty::Uncertainty;
use crate::estimate::coverage::{MOSTLY_FELT_AGAIN, NODES, completed, contact_paths, felt_again, touches};
use crate::estimate::jumps::{DetectedJump, jump_reversals};
use crate::estimate::measurements::{Instant, Measurements};
use crate::estimate::model::balance_tolerance::unstable_samples;
use crate::estimate::model::evidence::Evidence;
use crate::estimate::model::layout::{Layout, rotate};
use crate::estimate::model::noise_from_log::angle_residual_m;
use crate::estimate::model::sensor_memory::{contact_residuals_m, hidden_from_neighbours};
use crate::estimate::motion::unwrap;
use crate::estimate::solver::gauss_newton::Fit;
use crate::log::{Log, Sample};
use crate::math::statistics::{correlation_time, root_mean_square, typical_sd};
use crate::mechanics::Jump;
use crate::reconstruct::options::limits::CertificateLimits;
use crate::reconstruct::result::reconstruction::{FoundSymmetry, OutlinePoint, Pose, Reconstruction, com_sd_m};
use crate::shape::SupportFunction;
use std::f64::consts::TAU;

/// What is known of the noise besides the fit.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Expected {
    /// Standard deviation of a contact position that log or user state, metres.
    pub stated_m: Option<f64>,
    /// The same, from the scatter of neighbouring samples.
    pub scatter_m: f64,
    /// Samples for each error of its own, at least; 1 where the residuals tell all.
    pub samples_per_error: f64,
    /// Gross outliers that were set aside.
    pub outliers: usize,
}

/// Share of ambiguous samples up to which the standard deviation of ψ is that of the others: so many are a matter of a few pieces.
const MOST_AMBIGUOUS: f64 = 0.5;

/// A result, and how likely it is against others.
#[derive(Clone, Debug)]
pub(crate) struct Candidate {
    pub result: Reconstruction,
    /// ln of the evidence of the fit behind it and of the prior of its motion.
    pub posterior: Evidence,
}

/// Assembles the result. `None` when the information matrix cannot be factored (the log does not determine the shape).
/// `ambiguity_rad` is, for each sample, the distance of another pose that explains it about as well (radians, 0 where there is
/// none); `found_symmetry` how the object is symmetric. `uncertainty` is in the frame of the fit; with
/// inertia the object may be on its way at any sample.
pub(crate) fn assemble(
    log: &Log,
    measurements: &Measurements,
    mut fit: Fit,
    (ambiguity_rad, found_symmetry): (&[f64], FoundSymmetry),
    expected: Expected,
    uncertainty: &dyn Uncertainty,
    limits: &CertificateLimits,
) -> Option<Candidate> {
    let turned = fit.estimate.psi[0];
    turn_frame(&mut fit, turned);
    unwrap(&mut fit.estimate.psi);
    let (coefficients, psi) = (&fit.estimate.coefficients, &fit.estimate.psi);
    let shape = SupportFunction::from_coefficients(coefficients);
    let palms = log.palms();
    let mut jumps = uncertainty.jumps(&shape, log, psi);
    let starts: Vec<usize> = jumps.iter().map(|jump| jump.sample).collect();
    let piece_of = |index: usize| starts.iter().filter(|&&start| start <= index).count() as u32;

    let angles: Vec<(f64, f64)> =
        measurements.instants.iter().zip(psi).map(|(instant, psi)| instant.contact_angles(*psi)).collect();
    let symmetry = fit.prior.symmetry;
    let counts = completed(&touches(&contact_paths(measurements, &angles, &starts)), symmetry, turned);
    let node_angle = |node: usize| TAU * node as f64 / NODES as f64;
    let felt: Vec<f64> = (0..NODES).filter(|&node| counts[node] > 0).map(node_angle).collect();

    let residuals_m: Vec<(Option<f64>, Option<f64>)> = measurements
        .instants
        .iter()
        .zip(psi)
        .map(|(instant, psi)| contact_residuals_m(instant, coefficients, *psi))
        .collect();
    let of_sensor1: Vec<f64> = residuals_m.iter().filter_map(|both| both.0).collect();
    let of_sensor2: Vec<f64> = residuals_m.iter().filter_map(|both| both.1).collect();
    let typical_sensor_m = typical_sd(of_sensor1.iter().chain(&of_sensor2));
    let inflation =
        f64::max(0.5 * (correlation_time(&of_sensor1) + correlation_time(&of_sensor2)), expected.samples_per_error);
    let inertia = uncertainty.inertia(inflation);
    let friction = uncertainty.friction();
    let at_rest = inertia.is_none() && friction.is_none();
    let mut ambiguity_rad = ambiguity_rad.to_vec();
    if expected.outliers > 0 && at_rest {
        for (sample, bent_rad) in bent_poses(&shape, &palms, psi, &residuals_m, typical_sensor_m, &jumps) {
            ambiguity_rad[sample] = ambiguity_rad[sample].max(bent_rad);
        }
    }
    let felt_there: Vec<f64> = felt.iter().map(|theta| theta - turned).collect();
    let error_bars = uncertainty.error_bars(&felt_there, inflation)?;
    let of_rig = uncertainty.of_rig(inflation);

    let own_frame = |jump: &DetectedJump| DetectedJump {
        psi_before: jump.psi_before + turned,
        psi_after: jump.psi_after + turned,
        ..*jump
    };
    let in_own: Vec<DetectedJump> = jumps.iter().map(own_frame).collect();
    let besides = of_rig.as_ref().map_or(0.0, |rig| rig.log_evidence) - error_bars.deviance_of(&in_own)?;
    for (jump, in_own) in jumps.iter_mut().zip(&in_own) {
        jump.physical = jump.physical || error_bars.may_be_without_barrier(in_own);
    }
    let posterior = Evidence { samples_per_error: inflation, ..fit.evidence.with(besides) };

    let largest_felt = |sd_m: &dyn Fn(f64) -> f64| felt_there.iter().map(|theta| sd_m(*theta)).fold(0.0, f64::max);
    let largest_r_sd_m = largest_felt(&|theta| error_bars.r_sd_m(theta));
    let largest_form_sd_m = largest_felt(&|theta| error_bars.form_sd_m(theta));
    let center_known = largest_r_sd_m <= limits.r_sd * coefficients[0] || largest_r_sd_m == largest_form_sd_m;
    // About a centre of mass that is not known the form still has its own error bars.
    let outline = outline(&shape, &counts, |theta| {
        let theta = theta - turned;
        if center_known { error_bars.r_sd_m(theta) } else { error_bars.form_sd_m(theta) }
    });
    let motion: Vec<Pose> = log
        .samples
        .iter()
        .enumerate()
        .map(|(index, sample)| {
            let instant = &measurements.instants[index];
            let (psi_sd, com_sd) = error_bars.pose_sd(index, instant);
            let pose = pose(sample, instant, &shape, coefficients, psi[index]);
            let psi_sd_rad = psi_sd.max(ambiguity_rad[index]);
            let com_sd = match ambiguity_rad[index] {
                0.0 => com_sd,
                away_rad => com_sd.max(center_elsewhere_m(instant, &shape, psi[index], away_rad)),
            };
            let modes = uncertainty.modes(index);
            Pose { psi_sd_rad, com_sd_m: com_sd, piece: piece_of(index), modes, ..pose }
        })
        .collect();

    let center_sd_m = com_sd_m(&motion);
    let angle_error = angle_residual_m(measurements, coefficients, psi, fit.noise);
    let allowance = limits.model_allowance * coefficients[0].abs();
    let hidden = hidden_from_neighbours(&of_sensor1).min(hidden_from_neighbours(&of_sensor2));
    let expected_m = expected.stated_m.unwrap_or((hidden * expected.scatter_m).hypot(angle_error).max(allowance));
    let (chi2_per_dof, dof) = chi2(measurements, &residuals_m, expected_m, Layout::of_shape(fit.order).unknowns());
    let times_s: Vec<f64> = log.samples.iter().map(|sample| sample.time_s).collect();
    let ambiguous = ambiguity_rad.iter().filter(|ambiguity_rad| **ambiguity_rad > 0.0).count();
    // Where hardly a sample could be placed, it is the orientation itself that is not known.
    let all = ambiguous as f64 > MOST_AMBIGUOUS * motion.len() as f64;
    let is_placed = |(_, ambiguity_rad): &(&Pose, &f64)| all || **ambiguity_rad == 0.0;
    let unambiguous = || motion.iter().zip(&ambiguity_rad).filter(is_placed).map(|(pose, _)| pose);
    let squares = unambiguous().map(|pose| pose.psi_sd_rad.powi(2));
    let mean_square = squares.sum::<f64>() / unambiguous().count().max(1) as f64;
    let slack_m = limits.stability_slack * coefficients[0].abs();
    // With inertia the object may be on its way at any sample.
    let unphysical = || jumps.iter().filter(|jump| inertia.is_none() && !jump.physical);
    let is_aside = |sample: usize| measurements.instants[sample].is_aside();
    let findings = Findings {
        mean_radius_m: coefficients[0],
        concavity_m: shape.concavity_m(),
        chi2_per_dof,
        dof,
        noise_stated: expected.stated_m.is_some(),
        sensor_m: chi2_per_dof.sqrt() * expected_m,
        typical_sensor_m,
        expected_sensor_m: expected_m,
        balance_m: fit.noise.balance_m,
        samples: log.samples.len(),
        unphysical_jumps: unphysical().count(),
        first_unphysical_jump: unphysical().next().map(|jump| (times_s[jump.sample], jump.turn())),
        jump_reversals: if at_rest { jump_reversals(&jumps) } else { 0 },
        shortest_jump_rad: if at_rest { shortest_turn_rad(&jumps) } else { f64::INFINITY },
        unstable: if at_rest {
            unstable_samples(measurements, coefficients, psi, slack_m, fit.noise.balance_m)
        } else {
            0
        },
        coverage: felt.len() as f64 / NODES as f64,
        ambiguous,
        // Where inertia is fitted, short pieces that are open may be what was not explained.
        ambiguity_rad: if inertia.is_none() {
            open_motion_rad(&ambiguity_rad, is_aside)
        } else {
            root_mean_square(&ambiguity_rad)
        },
        psi_sd_rad: mean_square.sqrt(),
        largest_psi_sd_rad: unambiguous().map(|pose| pose.psi_sd_rad).fold(0.0, f64::max),
        largest_felt_r_sd_m: outline.iter().filter(|p| p.touches > 0).map(|p| p.r_sd_m).fold(0.0, f64::max),
        center_sd_m: if center_known { 0.0 } else { center_sd_m },
        readings: expected.outliers + of_sensor1.len() + of_sensor2.len(),
        outliers: expected.outliers,
        furthest_constant: of_rig.as_ref().map(|rig| rig.furthest.clone()),
        rig_unsettled_sds: of_rig.as_ref().map_or(0.0, |rig| rig.unsettled_sds),
        symmetry_deviation_sd_m: found_symmetry.deviation_sd_m,
        symmetry_probability: found_symmetry.probability.filter(|_| symmetry.is_any()),
    };
    let verdict = findings.verdict(limits);
    let result = Reconstruction {
        shape,
        coverage: felt.len() as f64 / NODES as f64,
        outline,
        symmetry: found_symmetry,
        verdict,
        findings: Some(findings),
        chi2_per_dof,
        jumps: jumps
            .iter()
            .map(|jump| Jump {
                time_s: times_s[jump.sample],
                psi_before_rad: jump.psi_before,
                psi_after_rad: jump.psi_after,
                height_before_m: jump.height_before_m,
                height_after_m: jump.height_after_m,
                physical: jump.physical,
            })
            .collect(),
        motion,
        alternatives: 1,
        others: Vec::new(),
        sensor_sd_m: fit.noise.sensor_m,
        balance_sd_m: fit.noise.balance_m,
        calibration: of_rig.map(|rig| rig.estimate),
        friction,
        inertia,
    };
    Some(Candidate { result, posterior })
}

/// How far the centre of mass of an object at another orientation, so far from this one either way, is from where it is here, metres.
fn center_elsewhere_m(instant: &Instant, shape: &SupportFunction, psi_rad: f64, away_rad: f64) -> f64 {
    let center_m = |psi_rad: f64| {
        let (theta1, theta2) = instant.contact_angles(psi_rad);
        instant.palms.center([shape.at(theta1).r, shape.at(theta2).r])
    };
    let [x, y] = center_m(psi_rad);
    let elsewhere = [psi_rad - away_rad, psi_rad + away_rad].map(center_m);
    elsewhere.into_iter().map(|[at_x, at_y]| (at_x - x).hypot(at_y - y)).fold(0.0, f64::max)
}

fn shortest_turn_rad(jumps: &[DetectedJump]) -> f64 {
    jumps.iter().map(|jump| jump.turn().abs()).fold(f64::INFINITY, f64::min)
}

/// Whether the log itself checks most of what it tells of a boundary.
pub(crate) fn is_mostly_felt_again(outline: &[OutlinePoint]) -> bool {
    felt_again(outline.iter().map(|point| point.touches)) >= MOSTLY_FELT_AGAIN
}

/// The boundary at [`NODES`] normal angles, felt as often as `counts` say, with the standard deviation of r at each.
pub(crate) fn outline(shape: &SupportFunction, counts: &[u32], r_sd_m: impl Fn(f64) -> f64) -> Vec<OutlinePoint> {
    let point = |(node, touches): (usize, &u32)| {
        let theta_rad = TAU * node as f64 / NODES as f64;
        let (contact, point) = (shape.at(theta_rad), shape.boundary_point(theta_rad));
        OutlinePoint {
            theta_rad,
            r_m: contact.r,
            r_sd_m: r_sd_m(theta_rad),
            x_m: point.x_m,
            y_m: point.y_m,
            curvature_radius_m: contact.v,
            touches: *touches,
        }
    };
    counts.iter().enumerate().map(point).collect()
}

/// The pose of one sample, with the residuals of its contacts; without error bars, and with piece 0.
pub(crate) fn pose(
    sample: &Sample,
    instant: &Instant,
    shape: &SupportFunction,
    coefficients: &[f64],
    psi_rad: f64,
) -> Pose {
    let (theta1_rad, theta2_rad) = instant.contact_angles(psi_rad);
    let [com_x_m, com_y_m] = sample.palms.center_of_mass_m(shape.at(theta1_rad), shape.at(theta2_rad));
    let (residual1_m, residual2_m) = contact_residuals_m(instant, coefficients, psi_rad);
    Pose {
        time_s: sample.time_s,
        psi_rad,
        psi_sd_rad: f64::NAN,
        com_x_m,
        com_y_m,
        com_sd_m: f64::NAN,
        theta1_rad,
        theta2_rad,
        piece: 0,
        residual1_m,
        residual2_m,
        modes: None,
    }
}

/// Turns the object frame so that ψ becomes ψ − `angle`.
fn turn_frame(fit: &mut Fit, angle: f64) {
    rotate(&mut fit.estimate.coefficients, angle);
    fit.estimate.psi.iter_mut().for_each(|psi| *psi -= angle);
}

/// χ² of the contact positions per degree of freedom, and the degrees of freedom.
fn chi2(
    measurements: &Measurements,
    residuals_m: &[(Option<f64>, Option<f64>)],
    sd_m: f64,
    unknowns: usize,
) -> (f64, f64) {
    let (mut sum, mut count) = (0.0, 0.0);
    for (instant, both) in measurements.instants.iter().zip(residuals_m) {
        for (residual, weight) in [(both.0, instant.weight1), (both.1, instant.weight2)] {
            if let Some(residual) = residual {
                sum += (residual * weight / sd_m).powi(2);
                count += 1.0;
            }
        }
    }
    // Balance determines ψ, so that both contact positions count for the shape.
    let dof = f64::max(count - unknowns as f64, 1.0);
    (sum / dof, dof)
}

#[cfg(test)]
mod tests;
