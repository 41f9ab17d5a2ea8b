//! Contact angles of a segment for a shape that is about known: the path over a grid of angles that explains the readings best, with steps
//! that cost by their length, up to what a leap costs (Viterbi; Forney, *Proceedings of the IEEE* 61, 1973). It mends what the closed form
//! got wrong: samples on the wrong branch of the curve (r, d), short leaps within a segment.

use std::f64::consts::TAU;
use std::ops::Range;

use crate::estimate::model::contact::support;
use crate::pivot::smoother::{Noise, State, across};
use crate::shape::ContactSupport;

/// Angles of the grid: half a degree.
const GRID: usize = 720;

/// A step costs one nat per so many radians, up to what a leap costs.
const STEP_RAD: f64 = 0.05;

/// No reading costs more than this: a gross error tells nothing.
const MOST_NATS: f64 = 40.0;

/// What an angle other than the one that is known costs: more than any leap.
const HELD_NATS: f64 = 1e3;

/// Standard deviation, radians, of an angle about the node that the cheapest path ends at, before its own reading is looked at: steps cost by their length, so
/// that the path lags behind where readings hardly tell an angle.
const PATH_SD_RAD: f64 = 0.1;

/// Newton steps from a node to the angle that explains a reading best.
const SETTLING_STEPS: usize = 3;

/// The shape in a table: what each angle of the grid says of a reading.
#[derive(Clone, Debug)]
pub(super) struct Table {
    coefficients: Vec<f64>,
    nodes: Vec<Node>,
    noise: Noise,
}

#[derive(Clone, Debug)]
struct Node {
    r_m: f64,
    d_m: f64,
    /// The unit vector across the curve, in units of the noise.
    across: [f64; 2],
    /// How far along the curve half a step of the grid is, in units of the noise.
    reach: f64,
    /// Variance across the curve, in units of the noise, and half its logarithm.
    variance: f64,
    half_log: f64,
}

/// Where a reading is next to a node of the grid.
#[derive(Clone, Copy, Debug)]
pub(super) struct Settled {
    pub theta_rad: f64,
    /// Variance of the angle by the noise of the reading, square radians.
    pub variance: f64,
    /// How an error of height and offset moves it, radians per metre.
    pub along: [f64; 2],
    /// Squared distance of the reading, in standard deviations; one is expected.
    pub square: f64,
}

impl Table {
    /// `variance_across` gives the variance of the shape across the curve (r, d) at an angle, for a unit vector across it in units of the noise.
    pub fn new(coefficients: &[f64], noise: Noise, variance_across: impl Fn(f64, [f64; 2]) -> f64) -> Self {
        let node = |node: usize| {
            let theta = angle(node);
            let ContactSupport { r: r_m, d: d_m, v: v_m } = support(coefficients, theta);
            let slope = [-d_m / noise.r_m, (r_m - v_m) / noise.d_m];
            let across = across(slope);
            let reach = 0.5 * TAU / GRID as f64 * slope[0].hypot(slope[1]);
            let variance = 1.0 + variance_across(theta, across);
            Node { r_m, d_m, across, reach, variance, half_log: 0.5 * variance.ln() }
        };
        Self { coefficients: coefficients.to_vec(), nodes: (0..GRID).map(node).collect(), noise }
    }

    /// The angle next to a node that explains a reading best. It is not held to the node, which noise has chosen too.
    pub fn settled(&self, node: usize, [r_m, d_m]: [f64; 2]) -> Settled {
        let Noise { r_m: r_sd, d_m: d_sd } = self.noise;
        let path = 1.0 / (PATH_SD_RAD * PATH_SD_RAD);
        let step = |theta_rad: f64| {
            let ContactSupport { r, d, v } = support(&self.coefficients, theta_rad);
            let slope = [-d / r_sd, (r - v) / d_sd];
            let information = slope[0] * slope[0] + slope[1] * slope[1] + path;
            let pull = slope[0] * (r - r_m) / r_sd + slope[1] * (d - d_m) / d_sd + path * (theta_rad - angle(node));
            (theta_rad - (pull / information).clamp(-PATH_SD_RAD, PATH_SD_RAD), slope, information)
        };
        let theta_rad = (1..SETTLING_STEPS).fold(angle(node), |theta_rad, _| step(theta_rad).0);
        let (theta_rad, [slope_r, slope_d], information) = step(theta_rad);
        Settled {
            theta_rad,
            variance: 1.0 / information,
            along: [slope_r / r_sd / information, slope_d / d_sd / information],
            square: square(&self.nodes[node], [r_m, d_m], self.noise),
        }
    }
}

/// Readings, and what is known of their contact angles before the shape is looked at.
pub(super) struct Decoding<'a> {
    /// Height and offset.
    pub measured: &'a [[f64; 2]],
    /// What a leap up to a reading costs, nats.
    pub leap_nats: &'a dyn Fn(usize) -> f64,
    /// Angles that are known already, radians.
    pub known_rad: &'a dyn Fn(usize) -> Option<f64>,
}

/// The contact angles of the readings of some segments; continuous within one but for leaps. `variance_across` is as of [`Table::new`].
pub(super) fn decoded(
    state: &State,
    decoding: &Decoding,
    segments: &[Range<usize>],
    noise: Noise,
    variance_across: impl Fn(f64, [f64; 2]) -> f64,
) -> Vec<f64> {
    let table = Table::new(&state.coefficients, noise, variance_across);
    segments.iter().flat_map(|range| path(&table, decoding, range.clone())).collect()
}

fn angle(node: usize) -> f64 {
    TAU * node as f64 / GRID as f64
}

/// Squared distance of a reading from a node, whose angle is free within half a step of the grid, in standard deviations.
fn square(node: &Node, [r_m, d_m]: [f64; 2], noise: Noise) -> f64 {
    let residual = [(node.r_m - r_m) / noise.r_m, (node.d_m - d_m) / noise.d_m];
    let [r_share, d_share] = node.across;
    let left = r_share * residual[0] + d_share * residual[1];
    let along = d_share * residual[0] - r_share * residual[1];
    let beyond = (along.abs() - node.reach).max(0.0);
    (left * left + beyond * beyond) / node.variance
}

/// −ln of the likelihood of a reading at a node.
fn emission(node: &Node, reading: [f64; 2], noise: Noise) -> f64 {
    (0.5 * square(node, reading, noise) + node.half_log).min(MOST_NATS)
}

/// Costs of the cheapest paths to each angle of the grid, reading by reading.
#[derive(Clone, Debug)]
pub(super) struct Forward {
    costs: Vec<f64>,
    is_begun: bool,
}

impl Default for Forward {
    /// Before the first reading: any angle is as good as any other.
    fn default() -> Self {
        Self { costs: vec![0.0; GRID], is_begun: false }
    }
}

impl Forward {
    /// Takes the next reading in, up to which a leap costs so much, and says from which angle the cheapest path to each comes.
    pub fn push(&mut self, table: &Table, reading: [f64; 2], leap_nats: f64) -> Vec<u16> {
        let mut from: Vec<u16> = (0..GRID as u16).collect();
        if self.is_begun {
            self.step(&mut from, leap_nats);
        }
        self.is_begun = true;
        let nodes = self.costs.iter_mut().zip(&table.nodes);
        nodes.for_each(|(cost, node)| *cost += emission(node, reading, table.noise));
        from
    }

    /// The least of cost + distance, around the circle both ways, and of a leap from anywhere.
    fn step(&mut self, from: &mut [u16], leap_nats: f64) {
        let costs = &mut self.costs;
        let next = |node: usize| (node + 1) % GRID;
        // The second time around as far as anything is lowered: beyond that the first time has done it.
        (0..GRID).rev().for_each(|node| _ = relax(costs, from, node, next(node)));
        (0..GRID).rev().all(|node| relax(costs, from, node, next(node)));
        (0..GRID).for_each(|before| _ = relax(costs, from, next(before), before));
        (0..GRID).all(|before| relax(costs, from, next(before), before));
        let least = (0..GRID).min_by(|&a, &b| costs[a].total_cmp(&costs[b])).unwrap_or(0);
        let (leapt, origin) = (costs[least] + leap_nats, from[least]);
        for node in 0..GRID {
            if leapt < costs[node] {
                (costs[node], from[node]) = (leapt, origin);
            }
        }
    }

    /// The last reading is known to be at this angle.
    fn hold(&mut self, theta_rad: f64) {
        let is_far = |node: usize| crate::math::angle::wrapped(angle(node) - theta_rad).abs() > TAU / GRID as f64;
        self.costs.iter_mut().enumerate().filter(|(node, _)| is_far(*node)).for_each(|(_, cost)| *cost += HELD_NATS);
    }

    /// The angle of the grid that the cheapest path leads to.
    pub fn cheapest(&self) -> usize {
        (0..GRID).min_by(|&a, &b| self.costs[a].total_cmp(&self.costs[b])).unwrap_or(0)
    }

    /// Root mean square distance from an angle of the grid of those that are farther from it than so much, each as likely as its cheapest path; radians.
    pub fn elsewhere_rad(&self, node: usize, beyond_rad: f64) -> f64 {
        let (mut all, mut squares) = (0.0, 0.0);
        for (other, cost) in self.costs.iter().enumerate() {
            let weight = (self.costs[node] - cost).exp();
            let away_rad = crate::math::angle::wrapped(angle(other) - angle(node)).abs();
            all += weight;
            squares += if away_rad > beyond_rad { weight * away_rad * away_rad } else { 0.0 };
        }
        (squares / all).sqrt()
    }
}

/// The cheapest path of one segment.
fn path(table: &Table, Decoding { measured, leap_nats, known_rad }: &Decoding, range: Range<usize>) -> Vec<f64> {
    let mut forward = Forward::default();
    let next = |place: usize| {
        let came_from = forward.push(table, measured[place], leap_nats(place));
        if let Some(theta_rad) = known_rad(place) {
            forward.hold(theta_rad);
        }
        came_from
    };
    let came_from: Vec<Vec<u16>> = range.map(next).collect();
    let mut node = forward.cheapest();
    let mut nodes = vec![0; came_from.len()];
    for index in (0..came_from.len()).rev() {
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

/// Whether the way from a node to the one next to it is cheaper than what led there; it is taken then.
fn relax(costs: &mut [f64], from: &mut [u16], node: usize, before: usize) -> bool {
    let through = costs[before] + TAU / GRID as f64 / STEP_RAD;
    let is_cheaper = through < costs[node];
    if is_cheaper {
        costs[node] = through;
        from[node] = from[before];
    }
    is_cheaper
}

#[cfg(test)]
impl Forward {
    /// Two nodes that explain everything, each as well as the other.
    pub fn of_two(one: usize, other: usize) -> Self {
        let cost = |node: usize| if node == one || node == other { 0.0 } else { 1e6 };
        Self { costs: (0..GRID).map(cost).collect(), is_begun: true }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pivot::motion_prior::LEAP_NATS;

    fn free(measured: &[[f64; 2]]) -> Decoding<'_> {
        Decoding { measured, leap_nats: &|_| LEAP_NATS, known_rad: &|_| None }
    }

    /// What is known already is kept, and what lies next to it follows, or leaps where that costs little: not to where the shape is the same.
    #[test]
    fn what_is_known_holds_what_is_next_to_it() {
        // It comes to itself by half a turn.
        let coefficients = vec![0.03, 0.0, 0.003, 0.0, 0.002];
        let noise = Noise { r_m: 2e-5, d_m: 1e-4 };
        let theta: Vec<f64> = (0..40).map(|i| 1.0 + 0.02 * f64::from(i) + if i < 35 { 0.0 } else { 1.0 }).collect();
        let measured: Vec<[f64; 2]> =
            theta.iter().map(|theta| support(&coefficients, *theta)).map(|at| [at.r, at.d]).collect();
        let state = State { coefficients, told: [0.0; 3], theta_rad: Vec::new() };
        for turn_rad in [0.0, 0.5 * TAU] {
            let known_rad = |place: usize| (place < 30).then_some(theta[place] + turn_rad);
            let decoding = Decoding { known_rad: &known_rad, ..free(&measured) };
            let found = decoded(&state, &decoding, std::slice::from_ref(&(0..40)), noise, |_, _| 0.0);
            for (found, theta) in found.iter().zip(&theta) {
                assert!(crate::math::angle::wrapped(found - theta - turn_rad).abs() < 0.02, "{found} {theta}");
            }
        }
    }

    /// The path is no more than a start: its node is chosen by noise, or lags behind.
    #[test]
    fn an_angle_is_that_of_its_own_reading() {
        let coefficients = vec![0.03, 0.003, 0.002, 0.0004, 0.002, -0.001, 0.0006];
        let table = Table::new(&coefficients, Noise { r_m: 2e-5, d_m: 1e-4 }, |_, _| 0.0);
        for off in [-0.02, -0.004, 0.0, 0.004, 0.02] {
            let ContactSupport { r, d, .. } = support(&coefficients, angle(300) + off);
            let found = table.settled(300, [r, d]);
            assert!((found.theta_rad - angle(300) - off).abs() < 1e-4 + 0.01 * f64::abs(off), "{off}: {found:?}");
        }
    }

    #[test]
    fn where_a_reading_tells_no_angle_the_path_does() {
        // A circle about the pivot.
        let table = Table::new(&[0.03, 0.0, 0.0], Noise { r_m: 2e-5, d_m: 1e-4 }, |_, _| 0.0);
        let found = table.settled(300, [0.03, 0.0]);
        assert!((found.theta_rad - angle(300)).abs() < 1e-12 && (found.variance.sqrt() - PATH_SD_RAD).abs() < 1e-12);
    }

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
        let found = decoded(&state, &free(&measured), std::slice::from_ref(&(0..200)), noise, |_, _| 0.0);
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
        let found = decoded(&state, &free(&measured), std::slice::from_ref(&(0..60)), noise, |_, _| 0.0);
        for index in (0..60).filter(|index| *index != 30) {
            assert!((found[index] - 1.0 - 0.02 * index as f64).abs() < 0.02);
        }
    }
}
