//! Rival arrangements: every segment, and every group of segments that shares little boundary with the others, is taken out and laid on
//! what the others say of the shape once more. A rotation elsewhere that explains it about as well is followed to its optimum.

use std::f64::consts::TAU;

use rayon::prelude::*;

use crate::math::angle::wrapped;
use crate::pivot::association::Known;
use crate::pivot::calibration::Reading;
use crate::pivot::evidence::{Fit, ROUGHLY_SETTLED, log_evidence};
use crate::pivot::joint_rotations::turned;
use crate::pivot::motion_prior::MotionPrior;
use crate::pivot::search::{SEARCH_ORDER, TRUSTED_ORDER, same, search_noise};
use crate::pivot::smoother::{Problem, State};
use crate::pivot::thinning::Thinning;
use crate::pivot::verdict::RIVAL_NATS;

/// Rivals that look worse than this by what is linear are not followed, nats.
const FOLLOWED_NATS: f64 = 40.0;

/// Rivals of one group that are followed.
const FOLLOWED: usize = 3;

/// Groups hang together where they share less boundary than one of these, radians.
const SHARED_RAD: [f64; 3] = [0.1, 0.4, 0.8];

/// A rotation closer than this is the arrangement itself, radians.
const ITSELF_RAD: f64 = 0.1;

/// A contact angle that its own reading tells no better than this, radians, is a weak link: what lies beyond it may be turned.
const WEAK_LINK_RAD: f64 = 0.1;

/// Groups of which two are turned together at most, the largest.
const MOST_TOGETHER: usize = 5;

/// Arcs of the boundary for what segments share.
const ARCS: usize = 180;

/// Looks for rivals among the segments of a log.
pub(super) struct Rivals<'a> {
    /// The problem of the search: its noise and number of harmonics.
    pub search: &'a Problem<'a>,
    /// All readings that are used, and some of them.
    pub readings: &'a [Reading],
    pub thinning: &'a Thinning,
    /// The prior of the motion, with the segments among the readings.
    pub prior: &'a MotionPrior,
}

/// The arrangement that is questioned.
pub(super) struct Whole<'a> {
    pub problem: &'a Problem<'a>,
    pub fit: &'a Fit,
}

impl Rivals<'_> {
    /// Rivals that are not clearly worse, the best first.
    pub fn of(&self, whole: &Whole, others: impl Iterator<Item = State>) -> Vec<Fit> {
        let orders = Self::orders(whole.fit);
        let mut starts: Vec<State> = others.collect();
        starts.extend(orders.iter().flat_map(|order| self.elsewhere(whole, *order)));
        let mut found: Vec<Fit> = Vec::new();
        for start in starts {
            let of_orders = orders.iter().filter_map(|order| self.solved(whole, *order, start.clone()));
            let Some(rival) = of_orders.max_by(|a, b| a.log_evidence.total_cmp(&b.log_evidence)) else { continue };
            let clearly_worse = rival.log_evidence < whole.fit.log_evidence - RIVAL_NATS;
            let known =
                std::iter::once(whole.fit).chain(&found).any(|fit| same(&fit.optimum.state, &rival.optimum.state));
            if !clearly_worse && !known {
                found.push(rival);
            }
        }
        found.sort_by(|a, b| b.log_evidence.total_cmp(&a.log_evidence));
        found
    }

    /// Numbers of harmonics with which rivals are looked for: those of the fit, since fewer would tell what they leave out from what is elsewhere; and where
    /// these are many, which may follow what is wrong with it, those of the search as well.
    fn orders(fit: &Fit) -> Vec<usize> {
        let few = (fit.order > TRUSTED_ORDER).then_some(SEARCH_ORDER);
        std::iter::once(fit.order).chain(few).collect()
    }

    /// Starts for rivals with so many harmonics.
    fn elsewhere(&self, whole: &Whole, order: usize) -> Vec<State> {
        let state = &whole.fit.optimum.state;
        let some = self.thinning.of(self.readings);
        let search = Problem {
            readings: &some,
            noise: search_noise(self.search.noise, self.search.size_m),
            order,
            harmonics: whole.fit.harmonics,
            ..self.search.clone()
        };
        // Compared with few samples first: what is clearly worse by these is so by all.
        let present = State { theta_rad: self.thinning.of(&state.theta_rad), ..state.clone() };
        let Some(present) = search.solve_to(present, ROUGHLY_SETTLED) else { return Vec::new() };
        let Some(evidence) = log_evidence(&search, &present) else { return Vec::new() };
        let present = present.state;
        let (parts, shared) = self.parts(whole);
        let groups = Self::groups(&parts, &shared);
        let mut moved: Vec<State> = groups.par_iter().flat_map(|group| self.moved(&search, &present, group)).collect();
        moved.extend(Self::turned_apart(&parts, &shared, &search, &present));
        let mut starts = Vec::new();
        let mut seen: Vec<State> = vec![present];
        let solved = |start: State| {
            let optimum = search.solve_to(start, ROUGHLY_SETTLED)?;
            Some((log_evidence(&search, &optimum)?, optimum))
        };
        for (own, optimum) in moved.into_par_iter().filter_map(solved).collect::<Vec<_>>() {
            if own < evidence - RIVAL_NATS || seen.iter().any(|seen| same(seen, &optimum.state)) {
                continue;
            }
            let theta_rad = self.thinning.spread(&state.theta_rad, &optimum.state.theta_rad);
            starts.push(State { theta_rad, ..optimum.state.clone() });
            seen.push(optimum.state);
        }
        starts
    }

    /// The optimum with so many harmonics from a start, under the noise and prior of the arrangement that is questioned.
    fn solved(&self, whole: &Whole, order: usize, start: State) -> Option<Fit> {
        let problem = Problem { order, ..whole.problem.clone() };
        let optimum = problem.solve(start)?;
        let log_evidence = log_evidence(&problem, &optimum)? - self.prior.cost(&optimum.state.theta_rad);
        Some(Fit { optimum, order, log_evidence, ..whole.fit.clone() })
    }

    /// Segments, cut at weak links, as the places of their readings among the thinned ones; and what boundary two of them share, radians: all of it where
    /// both begin with the object hanging at rest, which it does in one way.
    fn parts(&self, whole: &Whole) -> (Vec<Vec<usize>>, impl Fn(usize, usize) -> f64) {
        let slopes = &whole.fit.optimum.linear.told.slopes;
        let is_weak = |index: usize| slopes[index][0].hypot(slopes[index][1]) * WEAK_LINK_RAD < 1.0;
        let mut parts: Vec<Vec<usize>> = Vec::new();
        let mut at_rest = Vec::new();
        for (range, begins_at_rest) in self.thinning.ranges.iter().zip(&self.prior.begins_at_rest) {
            at_rest.extend(begins_at_rest.then_some(range.start));
            let mut part = Vec::new();
            for place in range.clone() {
                if is_weak(self.thinning.kept[place]) {
                    parts.push(std::mem::take(&mut part));
                    continue;
                }
                if place > range.start && self.leaps_between(whole, place - 1, place) {
                    parts.push(std::mem::take(&mut part));
                }
                part.push(place);
            }
            parts.push(part);
        }
        parts.retain(|part| part.len() >= 2);
        let theta = self.thinning.of(&whole.fit.optimum.state.theta_rad);
        let arcs: Vec<Vec<bool>> = parts
            .iter()
            .map(|part| {
                let mut felt = vec![false; ARCS];
                // The contact rolls from one to the next, over what is between as well.
                for two in part.windows(2) {
                    let [from, to] = [theta[two[0]], theta[two[1]]].map(|theta| (theta / TAU * ARCS as f64).floor());
                    for arc in (from.min(to) as i64..=from.max(to) as i64).take(ARCS) {
                        felt[arc.rem_euclid(ARCS as i64) as usize] = true;
                    }
                }
                felt
            })
            .collect();
        let rests: Vec<bool> =
            parts.iter().map(|part| part.first().is_some_and(|first| at_rest.contains(first))).collect();
        let shared = move |a: usize, b: usize| {
            if rests[a] && rests[b] {
                return TAU;
            }
            let both = arcs[a].iter().zip(&arcs[b]).filter(|(a, b)| **a && **b).count();
            TAU * both as f64 / ARCS as f64
        };
        (parts, shared)
    }

    /// Parts alone and in groups that hang together; as the places of their readings among the thinned ones.
    fn groups(parts: &[Vec<usize>], shared: impl Fn(usize, usize) -> f64) -> Vec<Vec<usize>> {
        let mut groups: Vec<Vec<usize>> = (0..parts.len()).map(|part| vec![part]).collect();
        for least in SHARED_RAD {
            groups.extend(connected(parts.len(), |a, b| shared(a, b) > least));
        }
        groups.retain(|group| group.len() < parts.len());
        groups.sort();
        groups.dedup();
        groups.into_iter().map(|group| places(parts, &group)).collect()
    }

    /// States of the thinned problem with a group turned, or two, that share nothing with each other or the rest.
    fn turned_apart(
        parts: &[Vec<usize>],
        shared: impl Fn(usize, usize) -> f64,
        search: &Problem,
        state: &State,
    ) -> Vec<State> {
        let groups = connected(parts.len(), |a, b| shared(a, b) > SHARED_RAD[0]);
        let mut groups: Vec<Vec<usize>> = groups.iter().map(|group| places(parts, group)).collect();
        groups.sort_by_key(|group| std::cmp::Reverse(group.len()));
        groups.truncate(MOST_TOGETHER);
        let count = groups.len();
        // Of two or three the first may stay where it is.
        let alone = (1..count).map(|group| (group, None));
        let first = usize::from(count == 3);
        let pairs = (first..count).flat_map(|a| (a + 1..count).map(move |b| (a, Some(b)))).filter(|_| count > 2);
        alone
            .chain(pairs)
            .flat_map(|(group, other)| {
                let turned = turned(search, state, &groups[group], other.map(|other| &groups[other][..]));
                turned
                    .into_iter()
                    .take_while(|(worse, _)| *worse < FOLLOWED_NATS)
                    .take(FOLLOWED)
                    .map(|(_, state)| state)
            })
            .collect()
    }

    /// Whether the contact leaps between two samples that stay.
    fn leaps_between(&self, whole: &Whole, from: usize, to: usize) -> bool {
        let theta = &whole.fit.optimum.state.theta_rad;
        (self.thinning.kept[from] + 1..=self.thinning.kept[to]).any(|index| self.prior.is_break(theta, index))
    }

    /// States of the thinned problem with a group of readings turned to where it may lie as well.
    fn moved(&self, search: &Problem, state: &State, group: &[usize]) -> Vec<State> {
        let mut inside = vec![false; search.readings.len()];
        group.iter().for_each(|&place| inside[place] = true);
        let (kept, kept_rad): (Vec<Reading>, Vec<f64>) = (0..inside.len())
            .filter(|&place| !inside[place])
            .map(|place| (search.readings[place], state.theta_rad[place]))
            .unzip();
        let (taken, taken_rad): (Vec<Reading>, Vec<f64>) =
            group.iter().map(|&place| (search.readings[place], state.theta_rad[place])).unzip();
        let problem = Problem { readings: &kept, ..search.clone() };
        let kept_state = State { theta_rad: kept_rad, ..state.clone() };
        let Some(optimum) = problem.solve_to(kept_state, ROUGHLY_SETTLED) else { return Vec::new() };
        let Some(factor) = optimum.linear.factorised(&optimum.state.coefficients, 0.0) else { return Vec::new() };
        let known = Known::new(&problem, &optimum.state, &factor);
        let placements = known.placements(&taken, &taken_rad);
        let Some(best) = placements.first().map(|placement| placement.cost) else { return Vec::new() };
        placements
            .iter()
            .filter(|placement| {
                wrapped(placement.rotation_rad).abs() > ITSELF_RAD && placement.cost < best + FOLLOWED_NATS
            })
            .take(FOLLOWED)
            .map(|placement| {
                let mut moved = state.clone();
                group.iter().for_each(|&place| moved.theta_rad[place] += placement.rotation_rad);
                // The shape must not hold on to where they were.
                moved.coefficients.clone_from(&optimum.state.coefficients);
                moved
            })
            .collect()
    }
}

/// Groups of so many parts that hang together where two of them are linked.
fn connected(parts: usize, is_linked: impl Fn(usize, usize) -> bool) -> Vec<Vec<usize>> {
    let mut label: Vec<usize> = (0..parts).collect();
    for a in 0..parts {
        for b in 0..a {
            if is_linked(a, b) && label[a] != label[b] {
                let (from, to) = (label[a], label[b]);
                label.iter_mut().filter(|l| **l == from).for_each(|l| *l = to);
            }
        }
    }
    let group = |of: usize| (0..parts).filter(|&part| label[part] == of).collect::<Vec<usize>>();
    (0..parts).map(group).filter(|group| !group.is_empty()).collect()
}

/// The readings of some parts.
fn places(parts: &[Vec<usize>], group: &[usize]) -> Vec<usize> {
    group.iter().flat_map(|&part| parts[part].iter().copied()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_hang_together_through_others() {
        let links = [(0, 2), (2, 4), (1, 3)];
        let found = connected(6, |a, b| links.contains(&(a, b)) || links.contains(&(b, a)));
        let mut found = found;
        found.sort();
        assert_eq!(found, [vec![0, 2, 4], vec![1, 3], vec![5]]);
        assert_eq!(places(&[vec![3], vec![], vec![1, 2]], &[0, 2]), [3, 1, 2]);
    }
}
