//! A start from nothing: each segment by its closed form, then one after the other laid on what is placed already, with the few rotations
//! that may be right followed side by side.

use std::ops::Range;

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use crate::math::angle::{mean_direction, wrapped};
use crate::math::statistics::root_mean_square;
use crate::pivot::association::{Known, Placement};
use crate::pivot::calibration::{Reading, TOLD};
use crate::pivot::curve::curve;
use crate::pivot::evidence::log_evidence;
use crate::pivot::motion_prior::MotionPrior;
use crate::pivot::result::OTHERWISE_RAD;
use crate::pivot::smoother::{Noise, Problem, State};

/// Harmonics during the search: enough to lay segments on each other.
pub(super) const SEARCH_ORDER: usize = 8;

/// More harmonics than these may follow what is elsewhere: a result that asks for them is held against all closed forms, and against rivals with few. One in
/// fifty logs that are right does.
pub(super) const TRUSTED_ORDER: usize = 10;

/// Noise during the search is at least this share of the size, so that shapes of few harmonics are told apart by their form.
pub(super) const LEAST_SEARCH_NOISE: f64 = 5e-4;

/// Arrangements that are followed side by side.
const WIDTH: usize = 4;

/// Rotations of one segment that are followed.
const BRANCHES: usize = 4;

/// The next segment is the clearest of so many: the longer a segment, the clearer its place.
const CLEAREST_OF: usize = 5;

/// An arrangement is sought to where a step lowers its cost by so little, in units of half a χ²: others are dropped by tens.
const ARRANGED: f64 = 0.5;

/// Rotations, and arrangements, that are worse by more than so many nats are dropped.
const DROPPED_NATS: f64 = 60.0;

/// Two states are the same where all contact angles are within so much of each other, radians, …
const SAME_RAD: f64 = 0.1;

/// … and the boundary there, as a share of the size.
const SAME_R: f64 = 0.01;

/// Segments with their readings and relative contact angles.
pub(super) struct Segments<'a> {
    pub readings: &'a [Reading],
    pub ranges: &'a [Range<usize>],
    /// Contact angles relative to the first sample of the segment, one per reading.
    pub relative_rad: &'a [f64],
    /// Whether each segment begins after the object was lifted.
    pub begins_at_rest: &'a [bool],
}

/// Some segments, placed: which, and shape and angles.
#[derive(Clone, Debug)]
pub(super) struct Arrangement {
    /// Numbers of the segments, in the order of their readings in the state.
    pub placed: Vec<usize>,
    pub state: State,
    pub log_evidence: f64,
}

impl Segments<'_> {
    /// The readings of some segments in turn.
    pub fn readings_of(&self, placed: &[usize]) -> Vec<Reading> {
        placed.iter().flat_map(|&segment| self.readings[self.ranges[segment].clone()].iter().copied()).collect()
    }

    /// The state of an arrangement of all segments, its angles in the order of the readings.
    pub fn in_order(&self, arrangement: &Arrangement) -> Option<State> {
        if arrangement.placed.len() != self.ranges.len() {
            return None;
        }
        let mut angles: Vec<&[f64]> = vec![&[]; self.ranges.len()];
        let mut rest = &arrangement.state.theta_rad[..];
        for &segment in &arrangement.placed {
            let (own, others) = rest.split_at_checked(self.ranges[segment].len())?;
            angles[segment] = own;
            rest = others;
        }
        Some(State { theta_rad: angles.concat(), ..arrangement.state.clone() })
    }

    fn relative_of(&self, segment: usize) -> &[f64] {
        &self.relative_rad[self.ranges[segment].clone()]
    }

    /// How far the contact turned in a segment, radians.
    fn turned(&self, segment: usize) -> f64 {
        let angles = self.relative_of(segment);
        let (low, high) = angles.iter().fold((f64::MAX, f64::MIN), |(low, high), a| (low.min(*a), high.max(*a)));
        high - low
    }

    /// Arrangements of all segments, the best first. `problem` has the noise; its readings do not matter.
    pub fn arrangements(&self, problem: &Problem) -> Vec<Arrangement> {
        let longest = (0..self.ranges.len()).max_by(|a, b| self.turned(*a).total_cmp(&self.turned(*b)));
        let Some(first) = longest else { return Vec::new() };
        let Some(start) = self.first(problem, first) else { return Vec::new() };
        let mut beam = vec![start];
        for _ in 1..self.ranges.len() {
            let known: Vec<Known> = beam.iter().map_while(|arrangement| self.known(problem, arrangement)).collect();
            let Some(next) = known.first().and_then(|known| self.next(known, &beam[0])) else { break };
            let of_beam: Vec<(&Arrangement, &Known)> = beam.iter().zip(&known).collect();
            let mut grown: Vec<Arrangement> = of_beam
                .into_par_iter()
                .flat_map(|(arrangement, known)| self.grown(problem, arrangement, known, next))
                .collect();
            if grown.is_empty() {
                break;
            }
            grown.sort_by(|a, b| b.log_evidence.total_cmp(&a.log_evidence));
            let best = grown[0].log_evidence;
            let mut kept: Vec<Arrangement> = Vec::new();
            for arrangement in grown {
                let new = kept.iter().all(|other| !same(&other.state, &arrangement.state));
                if new && kept.len() < WIDTH && arrangement.log_evidence > best - DROPPED_NATS {
                    kept.push(arrangement);
                }
            }
            beam = kept;
        }
        beam
    }

    /// One segment alone.
    fn first(&self, problem: &Problem, segment: usize) -> Option<Arrangement> {
        let readings = self.readings_of(&[segment]);
        let problem = Problem { readings: &readings, ..problem.clone() };
        let theta_rad = self.relative_of(segment).to_vec();
        let start = shape_given_angles(&problem, theta_rad)?;
        let optimum = problem.solve_to(start, ARRANGED)?;
        let log_evidence = log_evidence(&problem, &optimum)?;
        Some(Arrangement { placed: vec![segment], state: optimum.state, log_evidence })
    }

    /// What an arrangement tells of shape and constants.
    fn known(&self, problem: &Problem, arrangement: &Arrangement) -> Option<Known> {
        let readings = self.readings_of(&arrangement.placed);
        let problem = Problem { readings: &readings, ..problem.clone() };
        let linear = problem.linearised(&arrangement.state);
        let factor = linear.factorised(&arrangement.state.coefficients, 0.0)?;
        Some(Known::new(&problem, &arrangement.state, &factor))
    }

    /// The segment whose place is clearest among those that turned most.
    fn next(&self, known: &Known, arrangement: &Arrangement) -> Option<usize> {
        let mut open: Vec<usize> =
            (0..self.ranges.len()).filter(|segment| !arrangement.placed.contains(segment)).collect();
        open.sort_by(|a, b| self.turned(*b).total_cmp(&self.turned(*a)));
        let clear = |segment: usize| {
            let placements = known.placements(&self.readings[self.ranges[segment].clone()], self.relative_of(segment));
            match placements[..] {
                [best, second, ..] => second.cost - best.cost,
                _ => 0.0,
            }
        };
        let clear = open.into_iter().take(CLEAREST_OF).map(|segment| (segment, clear(segment)));
        clear.max_by(|a, b| a.1.total_cmp(&b.1)).map(|(segment, _)| segment)
    }

    /// An arrangement with one more segment, at each of the rotations that may be right.
    fn grown(&self, problem: &Problem, arrangement: &Arrangement, known: &Known, segment: usize) -> Vec<Arrangement> {
        let added = &self.readings[self.ranges[segment].clone()];
        let placements = known.placements(added, self.relative_of(segment));
        let Some(best) = placements.first().map(|placement| placement.cost) else { return Vec::new() };
        let worth = |placement: &&Placement| placement.cost < best + DROPPED_NATS;
        let mut followed: Vec<f64> =
            placements.iter().filter(worth).take(BRANCHES).map(|placement| placement.rotation_rad).collect();
        followed.extend(self.same_start(arrangement, segment));
        let mut placed = arrangement.placed.clone();
        placed.push(segment);
        let all = self.readings_of(&placed);
        let problem = Problem { readings: &all, ..problem.clone() };
        let prior = self.prior(&placed);
        let grow = |rotation_rad: f64| {
            let mut state = arrangement.state.clone();
            state.theta_rad.extend(self.relative_of(segment).iter().map(|theta| theta + rotation_rad));
            let optimum = problem.solve_to(state, ARRANGED)?;
            let log_evidence = log_evidence(&problem, &optimum)? - prior.cost(&optimum.state.theta_rad);
            Some(Arrangement { placed: placed.clone(), state: optimum.state, log_evidence })
        };
        followed.into_par_iter().filter_map(grow).collect()
    }

    /// The rotation at which a stroke begins where the first of those that are placed does.
    fn same_start(&self, arrangement: &Arrangement, segment: usize) -> Option<f64> {
        let mut begin = 0;
        for &placed in &arrangement.placed {
            if self.begins_at_rest[placed] && self.begins_at_rest[segment] {
                return Some(arrangement.state.theta_rad[begin] - self.relative_of(segment).first()?);
            }
            begin += self.ranges[placed].len();
        }
        None
    }

    /// The prior of the motion of some segments in turn.
    fn prior(&self, placed: &[usize]) -> MotionPrior {
        let mut begin = 0;
        let ranges = placed.iter().map(|&segment| {
            begin += self.ranges[segment].len();
            begin - self.ranges[segment].len()..begin
        });
        // Thinned samples lie further apart than a leap is long.
        let ranges = ranges.map(|range| range.start..range.start + 1).collect();
        let begins_at_rest = placed.iter().map(|&segment| self.begins_at_rest[segment]).collect();
        MotionPrior {
            ranges,
            begins_at_rest,
            relative_rad: [Vec::new(), Vec::new()],
            tips_over: Vec::new(),
            lifted: Vec::new(),
        }
    }
}

/// The noise of the search.
pub(super) fn search_noise(noise: Noise, size_m: f64) -> Noise {
    let least_m = LEAST_SEARCH_NOISE * size_m;
    Noise { r_m: noise.r_m.max(0.2 * least_m), d_m: noise.d_m.max(least_m) }
}

/// The most likely shape for given contact angles: linear least squares.
pub(super) fn shape_given_angles(problem: &Problem, theta_rad: Vec<f64>) -> Option<State> {
    let order = problem.order;
    let unknowns = 2 * order + 1;
    // Angles from the closed form are good to a few hundredths of a radian, which is as much of the size in d.
    let d_sd = problem.noise.d_m.hypot(0.02 * problem.size_m);
    let r_sd = problem.noise.r_m.hypot(0.004 * problem.size_m);
    let mut columns = DMatrix::zeros(unknowns, 2 * theta_rad.len());
    let mut values = DVector::zeros(2 * theta_rad.len());
    for (index, (theta, reading)) in theta_rad.iter().zip(problem.readings).enumerate() {
        let measured = reading.measured(&problem.stated);
        columns[(0, 2 * index)] = 1.0 / r_sd;
        for k in 1..=order {
            let (sin, cos) = (k as f64 * theta).sin_cos();
            columns[(k, 2 * index)] = cos / r_sd;
            columns[(order + k, 2 * index)] = sin / r_sd;
            columns[(k, 2 * index + 1)] = k as f64 * sin / d_sd;
            columns[(order + k, 2 * index + 1)] = -(k as f64) * cos / d_sd;
        }
        values[2 * index] = measured.r_m / r_sd;
        values[2 * index + 1] = measured.d_m / d_sd;
    }
    let mut normal = &columns * columns.transpose();
    let sds = problem.harmonics.sds(order, problem.size_m);
    for (index, sd) in sds.iter().enumerate() {
        normal[(index, index)] += 1.0 / (sd * sd);
    }
    let coefficients = normal.cholesky()?.solve(&(columns * values));
    let told: [f64; TOLD] = problem.stated.told();
    Some(State { coefficients: coefficients.iter().copied().collect(), told, theta_rad })
}

/// Whether two states are one shape up to a rotation: contacts at the same angles, and the same boundary there. What was not felt does not count: readings
/// do not tell it.
pub(super) fn same(a: &State, b: &State) -> bool {
    let off_rad = angles_off(a, b);
    off_rad.iter().all(|off| off.abs() < SAME_RAD) && has_same_boundary(a, b, &off_rad)
}

/// The samples whose contact angles are not the same in two states that are one shape, and one motion but for these few; `None` where there is more to it.
pub(super) fn same_but_for(a: &State, b: &State) -> Option<Vec<usize>> {
    let off_rad = angles_off(a, b);
    let is_one = root_mean_square(&off_rad) < OTHERWISE_RAD && has_same_boundary(a, b, &off_rad);
    is_one.then(|| (0..off_rad.len()).filter(|&place| off_rad[place].abs() >= SAME_RAD).collect())
}

/// Contact angles of one state less those of another, each up to a rotation.
fn angles_off(a: &State, b: &State) -> Vec<f64> {
    let off = || a.theta_rad.iter().zip(&b.theta_rad).map(|(a, b)| a - b);
    let turn_rad = mean_direction(off());
    off().map(|off| wrapped(off - turn_rad)).collect()
}

/// Whether the boundary is the same where the contact angles are.
fn has_same_boundary(a: &State, b: &State, off_rad: &[f64]) -> bool {
    let near_m = SAME_R * a.coefficients[0].abs();
    let turned: Vec<f64> = b.theta_rad.iter().zip(off_rad).map(|(theta, off)| theta + off).collect();
    let (there, here) = (curve(&a.coefficients, &a.theta_rad), curve(&b.coefficients, &turned));
    let mut at_same = there.iter().zip(here).zip(off_rad).filter(|(_, off)| off.abs() < SAME_RAD);
    at_same.all(|((a, b), _)| (a.r - b.r).abs() < near_m)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn states_are_the_same_where_contacts_and_the_boundary_at_these_are() {
        let theta_rad: Vec<f64> = (0..100).map(|index| 0.01 * f64::from(index)).collect();
        let one = State { coefficients: vec![0.03, 0.002, 0.001, 0.003, 0.0], told: [0.0; TOLD], theta_rad };
        let mut turned = one.clone();
        crate::estimate::model::layout::rotate(&mut turned.coefficients, 1.3);
        turned.theta_rad.iter_mut().for_each(|theta| *theta += 1.3);
        assert!(same(&one, &turned));
        // One of a hundred angles hardly moves their mean.
        let moved = |by: f64| {
            let mut moved = turned.clone();
            moved.theta_rad[50] += by;
            same(&one, &moved)
        };
        assert!(moved(0.97 * SAME_RAD) && !moved(1.03 * SAME_RAD));
        let larger = |by: f64| {
            let mut larger = turned.clone();
            larger.coefficients[0] += by * 0.03;
            same(&one, &larger)
        };
        assert!(larger(0.99 * SAME_R) && !larger(1.01 * SAME_R));
        // Where few samples are elsewhere, the rest is the same.
        assert_eq!(same_but_for(&one, &turned), Some(Vec::new()));
        let few = |samples: usize, by: f64| {
            let mut few = turned.clone();
            few.theta_rad.iter_mut().take(samples).for_each(|theta| *theta += by);
            same_but_for(&one, &few)
        };
        assert_eq!((few(1, 0.3), few(4, 0.2)), (Some(vec![0]), Some(vec![0, 1, 2, 3])));
        // Root mean squares of 0.049 and 0.051.
        assert!(few(1, 0.495).is_some() && few(1, 0.52).is_none());
        let mut larger_but_for = turned.clone();
        larger_but_for.coefficients[0] *= 1.0 + 1.01 * SAME_R;
        assert_eq!(same_but_for(&one, &larger_but_for), None);
        // A bump of a tenth on the other side, where nothing was felt: ((1 + cos(θ − there))/2)².
        let there = std::f64::consts::PI + 0.5;
        let mut elsewhere = one.clone();
        let bump =
            [0.375, 0.5 * there.cos(), 0.125 * (2.0 * there).cos(), 0.5 * there.sin(), 0.125 * (2.0 * there).sin()];
        elsewhere.coefficients.iter_mut().zip(bump).for_each(|(value, bump)| *value += 0.1 * 0.03 * bump);
        let off = |theta: f64| {
            (curve(&one.coefficients, &[theta])[0].r - curve(&elsewhere.coefficients, &[theta])[0].r).abs()
        };
        assert!(off(there) > 5.0 * SAME_R * 0.03 && same(&one, &elsewhere));
    }
}
