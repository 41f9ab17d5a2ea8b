//! From an optimum to the result that people see: gauge, outline, motion, error bars and verdict.

use super::certificate::judge;
use crate::estimate::coverage::{NODES, touches, tracks};
use crate::estimate::measurements::Problem;
use crate::estimate::model::contact::{contact_angles, residuals};
use crate::estimate::model::force::MODEL_ALLOWANCE;
use crate::estimate::model::layout::rotate;
use crate::estimate::model::noise_from_log::angle_scatter_rad;
use crate::estimate::model::noise_from_log::angle_sensitivity_m;
use crate::estimate::motion::unwrap;
use crate::estimate::solver::error_bars::ErrorBars;
use crate::estimate::solver::gauss_newton::Fit;
use crate::log::Log;
use crate::math::statistics::correlation_time;
use crate::palms::PalmPair;
use crate::reconstruct::reconstruction::{Jump, OutlinePoint, Pose, Reconstruction};
use crate::reconstruct::verdict::certificate::Evidence;
use crate::reconstruct::verdict::jumps::leaps;
use crate::shape::SupportFunction;
use std::f64::consts::TAU;

/// What is known of the noise besides the fit.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Expected {
    /// Standard deviation of a contact position that log or user state, metres.
    pub stated_m: Option<f64>,
    /// The same, from the scatter of neighbouring samples.
    pub scatter_m: f64,
}

/// A result, and whether nothing speaks against it.
#[derive(Clone, Debug)]
pub(crate) struct Judged {
    pub result: Reconstruction,
    pub explained: bool,
    pub log_evidence: f64,
}

/// Puts the result together. `None` when the information matrix cannot be factored (nothing was learnt).
/// `astray` says of each sample how far from its pose another is that explains it about as well (radians, 0 where there is none).
pub(crate) fn assemble(
    log: &Log,
    problem: &Problem,
    mut fit: Fit,
    astray: &[f64],
    expected: Expected,
) -> Option<Judged> {
    let turned = fit.estimate.psi[0];
    turn_frame(&mut fit, turned);
    unwrap(&mut fit.estimate.psi);
    let (coefficients, psi) = (&fit.estimate.coefficients, &fit.estimate.psi);
    let shape = SupportFunction::from_coefficients(coefficients);
    let palms: Vec<PalmPair> = log.samples.iter().map(|sample| sample.palms).collect();
    let leaps = leaps(&shape, &palms, psi);
    let starts: Vec<usize> = leaps.iter().map(|leap| leap.sample).collect();
    let piece_of = |index: usize| starts.iter().filter(|&&start| start <= index).count() as u32;

    let angles: Vec<(f64, f64)> =
        problem.instants.iter().zip(psi).map(|(instant, psi)| contact_angles(instant, *psi)).collect();
    let counts = touches(&tracks(problem, &angles, &starts));
    let node_angle = |node: usize| TAU * node as f64 / NODES as f64;
    let felt: Vec<f64> = (0..NODES).filter(|&node| counts[node] > 0).map(node_angle).collect();

    let left: Vec<_> = problem
        .instants
        .iter()
        .zip(psi)
        .map(|(instant, psi)| {
            let value = residuals(instant, coefficients, *psi).value;
            ((instant.weight1 > 0.0).then_some(-value[0]), (instant.weight2 > 0.0).then_some(-value[1]))
        })
        .collect();
    let of_sensor1: Vec<f64> = left.iter().filter_map(|both| both.0).collect();
    let of_sensor2: Vec<f64> = left.iter().filter_map(|both| both.1).collect();
    let inflation = 0.5 * (correlation_time(&of_sensor1) + correlation_time(&of_sensor2));
    let posterior = ErrorBars::new(problem, &fit, &felt, inflation)?;

    let outline: Vec<OutlinePoint> = (0..NODES)
        .map(|node| {
            let theta = node_angle(node);
            let (contact, point) = (shape.at(theta), shape.boundary_point(theta));
            OutlinePoint {
                theta_rad: theta,
                r_m: contact.r,
                r_sd_m: posterior.r_sd_m(theta),
                x_m: point.x_m,
                y_m: point.y_m,
                curvature_radius_m: contact.v,
                touches: counts[node],
            }
        })
        .collect();
    let angle_sd = angle_scatter_rad(problem);
    let motion: Vec<Pose> = log
        .samples
        .iter()
        .enumerate()
        .map(|(index, sample)| {
            let (theta1, theta2) = angles[index];
            let center = sample.palms.center_of_mass_m(shape.at(theta1), shape.at(theta2));
            let (psi_sd, com_sd) = posterior.pose_sd(index, &problem.instants[index], &fit, angle_sd);
            Pose {
                time_s: sample.time_s,
                psi_rad: psi[index],
                psi_sd_rad: psi_sd.max(astray[index]),
                com_x_m: center[0],
                com_y_m: center[1],
                com_sd_m: com_sd,
                theta1_rad: theta1,
                theta2_rad: theta2,
                piece: piece_of(index),
                residual1_m: left[index].0,
                residual2_m: left[index].1,
            }
        })
        .collect();

    let angle_error = angle_sd * angle_sensitivity_m(problem, coefficients, psi);
    let allowance = MODEL_ALLOWANCE * coefficients[0].abs();
    let expected_m = expected.stated_m.unwrap_or(expected.scatter_m.hypot(angle_error).max(allowance));
    let (chi2_per_dof, dof) = chi2(problem, &left, expected_m, 2 * fit.order + 1);
    let chi2_limit = 1.0 + (6.0 * (2.0 / dof).sqrt()).max(if expected.stated_m.is_some() { 0.2 } else { 0.5 });
    let times_s: Vec<f64> = log.samples.iter().map(|sample| sample.time_s).collect();
    let placed = || motion.iter().zip(astray).filter(|(_, astray)| **astray == 0.0).map(|(pose, _)| pose);
    let squares = placed().map(|pose| pose.psi_sd_rad.powi(2));
    let mean_square = squares.sum::<f64>() / placed().count().max(1) as f64;
    let verdict = judge(&Evidence {
        problem,
        coefficients,
        psi,
        chi2_per_dof,
        chi2_limit,
        noise_stated: expected.stated_m.is_some(),
        sensor_m: chi2_per_dof.sqrt() * expected_m,
        balance_m: fit.noise.balance_m,
        expected_sensor_m: expected_m,
        leaps: &leaps,
        times_s: &times_s,
        coverage: felt.len() as f64 / NODES as f64,
        unplaced: astray.iter().filter(|astray| **astray > 0.0).count(),
        astray: (astray.iter().map(|astray| astray * astray).sum::<f64>() / astray.len().max(1) as f64).sqrt(),
        psi_sd: [mean_square.sqrt(), placed().map(|pose| pose.psi_sd_rad).fold(0.0, f64::max)],
        largest_felt_r_sd_m: outline.iter().filter(|p| p.touches > 0).map(|p| p.r_sd_m).fold(0.0, f64::max),
        convex: shape.is_convex(),
    });
    let result = Reconstruction {
        shape,
        coverage: felt.len() as f64 / NODES as f64,
        outline,
        certified: verdict.certified,
        com_certified: verdict.com_certified,
        reason: verdict.reason,
        chi2_per_dof,
        jumps: leaps
            .iter()
            .map(|leap| Jump {
                time_s: times_s[leap.sample],
                psi_before_rad: leap.psi_before,
                psi_after_rad: leap.psi_after,
                height_before_m: leap.height_before_m,
                height_after_m: leap.height_after_m,
                physical: leap.physical,
            })
            .collect(),
        motion,
        alternatives: 1,
        others: Vec::new(),
        sensor_sd_m: fit.noise.sensor_m,
        balance_sd_m: fit.noise.balance_m,
    };
    Some(Judged { result, explained: verdict.explained, log_evidence: fit.log_evidence })
}

/// Turns the object frame so that ψ becomes ψ − `angle`.
fn turn_frame(fit: &mut Fit, angle: f64) {
    rotate(&mut fit.estimate.coefficients, angle);
    fit.estimate.psi.iter_mut().for_each(|psi| *psi -= angle);
}

/// χ² of the contact positions per degree of freedom, and the degrees of freedom.
fn chi2(problem: &Problem, left: &[(Option<f64>, Option<f64>)], sd_m: f64, unknowns: usize) -> (f64, f64) {
    let (mut sum, mut count) = (0.0, 0.0);
    for (instant, both) in problem.instants.iter().zip(left) {
        for (residual, weight) in [(both.0, instant.weight1), (both.1, instant.weight2)] {
            if let Some(residual) = residual {
                sum += (residual * weight / sd_m).powi(2);
                count += 1.0;
            }
        }
    }
    // Balance fixes ψ, so that both contact positions are left to the shape.
    let dof = f64::max(count - unknowns as f64, 1.0);
    (sum / dof, dof)
}
