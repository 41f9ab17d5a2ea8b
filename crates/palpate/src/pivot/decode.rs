//! Contact angles of a segment for a shape that is about known: the path over a grid of angles that explains the readings best, with steps
//! that cost by their length, up to what a leap costs (Viterbi; Forney, *Proceedings of the IEEE* 61, 1973). It mends what the closed form
//! got wrong: samples on the wrong branch of the curve (r, d), short leaps within a segment.

use std::f64::consts::TAU;
use std::ops::Range;

use crate::estimate::model::contact::support;
use crate::pivot::motion_prior::LEAP_NATS;
use crate::pivot::smoother::{Noise, State, across};
use crate::shape::ContactSupport;

/// Angles of the grid: half a degree.
const GRID: usize = 720;

/// A step costs one nat per so many radians, up to what a leap costs.
const STEP_RAD: f64 = 0.05;

/// No reading costs more than this: a gross error tells nothing.
const MOST_NATS: f64 = 40.0;

/// The shape in a table.
struct Node {
    r_m: f64,
    d_m: f64,
    slope: [f64; 2],
    /// Variance across the curve, in units of the noise, and half its logarithm.
    variance: f64,
    half_log: f64,
}

/// The contact angles of all readings, segment by segment; continuous within one but for leaps. `variance_across` gives the variance of the
/// shape across the curve (r, d) at an angle, for a unit vector across it in units of the noise.
pub(super) fn decoded(
    state: &State,
    measured: &[[f64; 2]],
    segments: &[Range<usize>],
    noise: Noise,
    variance_across: impl Fn(f64, [f64; 2]) -> f64,
) -> Vec<f64> {
    let table: Vec<Node> = (0..GRID)
        .map(|node| {
            let theta = angle(node);
            let ContactSupport { r: r_m, d: d_m, v: v_m } = support(&state.coefficients, theta);
            let slope = [-d_m / noise.r_m, (r_m - v_m) / noise.d_m];
            let variance = 1.0 + variance_across(theta, across(slope));
            Node { r_m, d_m, slope, variance, half_log: 0.5 * variance.ln() }
        })
        .collect();
    let mut theta = Vec::with_capacity(measured.len());
    for range in segments {
        theta.extend(path(&table, &measured[range.clone()], noise));
    }
    theta
}

fn angle(node: usize) -> f64 {
    TAU * node as f64 / GRID as f64
}

/// −ln of the likelihood of a reading at a node, whose angle is free within half a step of the grid.
fn emission(node: &Node, [r_m, d_m]: [f64; 2], noise: Noise) -> f64 {
    let residual = [(node.r_m - r_m) / noise.r_m, (node.d_m - d_m) / noise.d_m];
    let cross = across(node.slope);
    let left = cross[0] * residual[0] + cross[1] * residual[1];
    let along = cross[1] * residual[0] - cross[0] * residual[1];
    let reach = 0.5 * TAU / GRID as f64 * node.slope[0].hypot(node.slope[1]);
    let beyond = (along.abs() - reach).max(0.0);
    (0.5 * (left * left + beyond * beyond) / node.variance + node.half_log).min(MOST_NATS)
}

/// The cheapest path of one segment.
fn path(table: &[Node], measured: &[[f64; 2]], noise: Noise) -> Vec<f64> {
    let per_node = TAU / GRID as f64 / STEP_RAD;
    let mut costs = vec![0.0; GRID];
    let mut came_from: Vec<Vec<u16>> = Vec::with_capacity(measured.len());
    for (index, reading) in measured.iter().enumerate() {
        let mut from: Vec<u16> = (0..GRID as u16).collect();
        if index > 0 {
            // The least of cost + distance, around the circle both ways, and of a leap from anywhere.
            for pass in 0..2 * GRID {
                let (node, before) = (pass % GRID, (pass + GRID - 1) % GRID);
                relax(&mut costs, &mut from, node, before, per_node);
            }
            for pass in (0..2 * GRID).rev() {
                let (node, before) = (pass % GRID, (pass + 1) % GRID);
                relax(&mut costs, &mut from, node, before, per_node);
            }
            let least = (0..GRID).min_by(|&a, &b| costs[a].total_cmp(&costs[b])).unwrap_or(0);
            let (leapt, origin) = (costs[least] + LEAP_NATS, from[least]);
            for node in 0..GRID {
                if leapt < costs[node] {
                    (costs[node], from[node]) = (leapt, origin);
                }
            }
        }
        came_from.push(from);
        costs.iter_mut().zip(table).for_each(|(cost, node)| *cost += emission(node, *reading, noise));
    }
    let mut node = (0..GRID).min_by(|&a, &b| costs[a].total_cmp(&costs[b])).unwrap_or(0);
    let mut nodes = vec![0; measured.len()];
    for index in (0..measured.len()).rev() {
        nodes[index] = node;
        node = usize::from(came_from[index][node]);
    }
    // Unwrapped: the shorter way from one to the next.
    let mut theta = Vec::with_capacity(nodes.len());
    let mut last = nodes.first().map_or(0.0, |&node| angle(node));
    for node in nodes {
        last += crate::math::angle::wrapped(angle(node) - last);
        theta.push(last);
    }
    theta
}

fn relax(costs: &mut [f64], from: &mut [u16], node: usize, before: usize, per_node: f64) {
    let through = costs[before] + per_node;
    if through < costs[node] {
        costs[node] = through;
        from[node] = from[before];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_with_a_leap_is_found_from_the_shape_alone() {
        let coefficients = vec![0.03, 0.003, 0.002, 0.0004, 0.002, -0.001, 0.0006];
        let noise = Noise { r_m: 2e-5, d_m: 1e-4 };
        let theta: Vec<f64> = (0..200).map(|i| 1.0 + 0.02 * f64::from(i) + if i < 90 { 0.0 } else { 1.3 }).collect();
        let measured: Vec<[f64; 2]> = theta
            .iter()
            .map(|theta| {
                let ContactSupport { r, d, .. } = support(&coefficients, *theta);
                [r, d]
            })
            .collect();
        let state = State { coefficients, told: [0.0; 3], theta_rad: Vec::new() };
        let found = decoded(&state, &measured, std::slice::from_ref(&(0..200)), noise, |_, _| 0.0);
        for (found, theta) in found.iter().zip(&theta) {
            assert!(crate::math::angle::wrapped(found - theta).abs() < 0.02, "{found} {theta}");
        }
    }

    #[test]
    fn a_gross_error_does_not_move_its_neighbours() {
        let coefficients = vec![0.03, 0.003, 0.002, 0.0004, 0.002, -0.001, 0.0006];
        let noise = Noise { r_m: 2e-5, d_m: 1e-4 };
        let mut measured: Vec<[f64; 2]> =
            (0..60).map(|i| support(&coefficients, 1.0 + 0.02 * f64::from(i))).map(|at| [at.r, at.d]).collect();
        measured[30][1] += 5e-3;
        let state = State { coefficients, told: [0.0; 3], theta_rad: Vec::new() };
        let found = decoded(&state, &measured, std::slice::from_ref(&(0..60)), noise, |_, _| 0.0);
        for index in (0..60).filter(|index| *index != 30) {
            assert!((found[index] - 1.0 - 0.02 * index as f64).abs() < 0.02);
        }
    }
}
